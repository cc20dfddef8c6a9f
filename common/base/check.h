// Checks for bugs. Checks stay on in release builds, print both operands and abort the process,
// because an "impossible" state must not reach an archive. A CHECK is never used for expected
// failures such as bad input, a full disk or a lost process (see result.h and error.h).
//
// To make bugs reproducible, a program's main function records the command line, the request and
// the seed as notes. The notes suffice to repeat the run. The notes and the bug listener are this
// library's only global state. The notes and the listener affect only the output after an uncaught
// exception, or after a failed check in any thread.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace sleight::base {

/// Prints `file:line: check failed: condition (operands)` to stderr and aborts. Default arguments
/// provide the caller's place, because the clang that builds the fuzzers lacks
/// std::source_location.
[[noreturn]] void check_failed(std::string_view condition, std::string_view operands,
                               const char* file = __builtin_FILE(), int line = __builtin_LINE());

/// Adds a line to the output after a failed check. A program's main function may add a few lines,
/// which are never freed. Thread-safe.
void add_repeat_note(std::string_view line);

std::string repeat_notes();

/// After a failed check or an uncaught exception, this function is called before the process
/// aborts. For an uncaught exception, `place` is empty. The function runs in any thread, so it may
/// call little more than write(2).
struct BugListener {
  void (*heard)(void* context, const std::string& place, const std::string& words) = nullptr;
  void* context = nullptr;
};

/// Replaces the listener; an empty one removes it. For a program's main. Thread-safe.
void set_bug_listener(BugListener listener);

/// Returns the arguments as one line, quoted for a shell.
std::string command_line(int argc, const char* const* argv);

/// Makes uncaught exceptions print their message and the notes before aborting. An uncaught
/// std::bad_alloc exits with ExitCode::environment. Call this function first in a main function.
void report_uncaught_exceptions();

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
