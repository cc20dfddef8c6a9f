// Defines two comparisons that Cap'n Proto 0.9.2's headers use but clang doesn't find. If clang
// compiles those headers, include this header before all others
// (deploy/cmake/SleightLibraries.cmake).
//
// In C++20, `const char* == kj::StringPtr` should call StringPtr's own comparison with reversed
// operands. But by a later rule of the standard (P2468), a class that also has != gets no reversed
// comparison. clang 16 has this rule; GCC 12 does not.
#pragma once

#include <kj/string.h>

namespace kj {

inline bool operator==(const char* a, const StringPtr& b) {
  return b == StringPtr(a);
}
inline bool operator!=(const char* a, const StringPtr& b) {
  return b != StringPtr(a);
}

}  // namespace kj
