// Defines two comparisons that Cap'n Proto 0.9.2's headers use but clang doesn't find. Include this
// header before all others where clang compiles them (deploy/cmake/SleightLibraries.cmake).
//
// In C++20, `const char* == kj::StringPtr` should be StringPtr's own comparison with the operands
// reversed. By a later rule of the standard (P2468, in clang 16 but not in GCC 12), however, a
// class that also has != gets no reversed comparison.
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
