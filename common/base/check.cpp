#include "common/base/check.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>

#include "common/base/error.h"
#include "common/base/memory.h"

namespace sleight::base {
namespace {

/// Notes are never freed, because another thread may be printing them.
struct Note {
  std::string line;
  const Note* before = nullptr;
};
std::atomic<const Note*> last_note = nullptr;

void print(const std::string& message) {
  std::fputs((message + repeat_notes()).c_str(), stderr);
  std::fflush(stderr);
}

/// The listener is two atomics, its function and its context, because not every machine has atomics
/// of 16 bytes. The context is stored first.
std::atomic<void*> listener_context = nullptr;
std::atomic<decltype(BugListener::heard)> listener_heard = nullptr;

void tell_listener(const std::string& place, const std::string& words) {
  const auto heard = listener_heard.exchange(nullptr);  // once
  if (heard != nullptr) heard(listener_context, place, words);
}

[[noreturn]] void print_uncaught_and_abort() {
  std::string reason = "no exception";
  try {
    if (std::current_exception()) std::rethrow_exception(std::current_exception());
  } catch (const std::bad_alloc&) {
    // Libraries allocate memory even in functions that must not throw, so the cause may be lack of
    // memory, which is no bug.
    std::fprintf(stderr, "%s\n", k_too_little_memory);
    std::_Exit(static_cast<int>(ExitCode::environment));
  } catch (const std::exception& failure) {
    reason = failure.what();
  } catch (...) {
    reason = "an exception of an unknown type";
  }
  tell_listener("", reason);
  print(fmt::format("terminated: {}\n", reason));
  std::abort();
}

}  // namespace

void check_failed(std::string_view condition, std::string_view operands, const char* file,
                  int line) {
  const std::string place = fmt::format("{}:{}", file, line);
  const std::string words = fmt::format("check failed: {} ({})", condition, operands);
  tell_listener(place, words);  // first, because writing to a closed stderr may end the process
  print(fmt::format("{}: {}\n", place, words));
  std::abort();
}

void add_repeat_note(std::string_view line) {
  auto* note = new Note{.line = std::string(line), .before = last_note};
  while (!last_note.compare_exchange_weak(note->before, note)) {
  }
}

void set_bug_listener(BugListener listener) {
  listener_heard = nullptr;
  listener_context = listener.context;
  listener_heard = listener.heard;
}

std::string repeat_notes() {
  std::string notes;
  for (const Note* note = last_note; note != nullptr; note = note->before)
    notes.insert(0, note->line + "\n");
  return notes;
}

std::string command_line(int argc, const char* const* argv) {
  std::string line;
  for (int i = 0; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (i > 0) line += ' ';
    constexpr std::string_view k_plain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./=:,+@%";
    if (!argument.empty() && argument.find_first_not_of(k_plain) == std::string_view::npos) {
      line += argument;
      continue;
    }
    line += '\'';
    for (const char character : argument) {
      if (character == '\'') {
        line += R"('\'')";
      } else {
        line += character;
      }
    }
    line += '\'';
  }
  return line;
}

void report_uncaught_exceptions() {
  std::set_terminate(print_uncaught_and_abort);
}

}  // namespace sleight::base
