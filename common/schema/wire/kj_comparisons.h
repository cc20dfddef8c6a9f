// Two comparisons that Cap'n Proto 0.9.2's headers use and clang doesn't find; included before all
// else where clang compiles these headers (deploy/cmake/SleightLibraries.cmake).
//
// `const char* == kj::StringPtr` is to be, in C++20, the turned comparison of StringPtr's own. By
// the standard's later rule (P2468, in clang 16 and not in GCC 12) a class that has != as well has
// none.
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
