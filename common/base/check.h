// Checks for bugs. They stay on in release, print both operands and stop the process: a state that
// "can't happen" must not reach an archive. What can happen (bad input, full disk, a lost process)
// is never a CHECK: see result.h and error.h.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace sleight::base {

/// Prints `file:line: check failed: condition (operands)` to stderr and aborts. The place is the
/// caller's; std::source_location is missing from the clang that builds the fuzzers.
[[noreturn]] void check_failed(std::string_view condition, std::string_view operands,
                               const char* file = __builtin_FILE(), int line = __builtin_LINE());

namespace detail {
template <class T>
std::string printed(const T& value) {
  if constexpr (fmt::is_formattable<T>::value) {
    return fmt::format("{}", value);
  } else {
    return "?";
  }
}
template <class A, class B>
[[noreturn]] void check_pair_failed(std::string_view condition, const A& a, const B& b,
                                    const char* file, int line) {
  check_failed(condition, fmt::format("{} against {}", printed(a), printed(b)), file, line);
}
}  // namespace detail

}  // namespace sleight::base

#define CHECK(condition)                                  \
  do {                                                    \
    if (!(condition)) [[unlikely]]                        \
      ::sleight::base::check_failed(#condition, "false"); \
  } while (false)

#define SLEIGHT_CHECK_PAIR(a, op, b)                                                             \
  do {                                                                                           \
    const auto& sleight_left = (a);                                                              \
    const auto& sleight_right = (b);                                                             \
    if (!(sleight_left op sleight_right)) [[unlikely]]                                           \
      ::sleight::base::detail::check_pair_failed(#a " " #op " " #b, sleight_left, sleight_right, \
                                                 __FILE__, __LINE__);                            \
  } while (false)

#define CHECK_EQ(a, b) SLEIGHT_CHECK_PAIR(a, ==, b)
#define CHECK_NE(a, b) SLEIGHT_CHECK_PAIR(a, !=, b)
#define CHECK_LT(a, b) SLEIGHT_CHECK_PAIR(a, <, b)
#define CHECK_LE(a, b) SLEIGHT_CHECK_PAIR(a, <=, b)
#define CHECK_GT(a, b) SLEIGHT_CHECK_PAIR(a, >, b)
#define CHECK_GE(a, b) SLEIGHT_CHECK_PAIR(a, >=, b)
