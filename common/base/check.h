// Checks for bugs. They stay on in release, print both operands and stop the process: a state that
// "can't happen" must not reach an archive. What can happen (bad input, full disk, a lost process)
// is never a CHECK: see result.h and error.h.
//
// A bug's report should say how to see it again. So a program's main notes what repeats its run:
// the command line, the request, the seed. These notes, and who hears of a bug, are the one state
// of a process as a whole that this library has; they change nothing but what is told when a check
// fails, in whatever thread, or an exception is caught by nobody.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace sleight::base {

/// Prints `file:line: check failed: condition (operands)` to stderr and aborts. The place is the
/// caller's; std::source_location is missing from the clang that builds the fuzzers.
[[noreturn]] void check_failed(std::string_view condition, std::string_view operands,
                               const char* file = __builtin_FILE(), int line = __builtin_LINE());

/// Adds a line to what is printed after a failed check. For a program's main: a few lines a
/// process, which are kept for its life. Thread-safe.
void add_repeat_note(std::string_view line);

/// The notes in the order in which they were added, each ended by a newline.
std::string repeat_notes();

/// Hears of a check that fails, and of an exception that nobody catches (`place` is then empty),
/// before the process aborts; in whatever thread, so that it may call little but write(2).
struct BugListener {
  void (*heard)(void* context, const std::string& place, const std::string& words) = nullptr;
  void* context = nullptr;
};

/// In place of the one before; an empty one takes it away. For a program's main. Thread-safe.
void set_bug_listener(BugListener listener);

/// Arguments as one line that a shell reads as the same ones.
std::string command_line(int argc, const char* const* argv);

/// From now on an exception that nobody catches is printed, with the notes, before the process
/// aborts; where it is std::bad_alloc it ends with ExitCode::environment. Call it first thing in a
/// main.
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
