#include "service/keeper/tool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>

#include "common/base/clock.h"
#include "common/base/descriptor.h"
#include "common/base/error.h"
#include "service/keeper/command.h"
#include "service/keeper/program.h"

namespace sleight::keeper {
namespace {

/// After a program's output has ended, run_tool() checks at this interval whether it has exited.
constexpr int k_wait_ms = 2;
/// Interval of checks of ToolOptions::stop.
constexpr int k_look_at_stop_ms = 100;

struct Pipe {
  base::Descriptor reader;
  base::Descriptor writer;
};

Pipe make_pipe() {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw base::Error(fmt::format("can't create a pipe: {}", std::strerror(errno)));
  return {.reader = base::Descriptor(ends[0]), .writer = base::Descriptor(ends[1])};
}

/// Reads available output. Closes the pipe at the end of the output.
void take(base::Descriptor& from, std::string& into, std::size_t bytes_max, bool& is_cut) {
  std::array<char, 16384> piece;
  const ssize_t count = ::read(from.get(), piece.data(), piece.size());
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return;
  if (count <= 0) {
    from.reset();
    return;
  }
  const std::size_t room = bytes_max - std::min(bytes_max, into.size());
  is_cut = is_cut || static_cast<std::size_t>(count) > room;
  into.append(piece.data(), std::min(room, static_cast<std::size_t>(count)));
}

/// Writes input to the program. Closes the pipe when all input is written, or when the program
/// stops reading.
void give(base::Descriptor& to, std::string_view& rest) {
  const ssize_t count = rest.empty() ? 0 : ::write(to.get(), rest.data(), rest.size());
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return;
  if (count > 0) rest.remove_prefix(static_cast<std::size_t>(count));
  if (count < 0 || rest.empty()) to.reset();
}

/// Blocks SIGPIPE: if a program doesn't read, writing to it must not end this process.
class NoPipeSignal {
 public:
  NoPipeSignal() {
    sigset_t pipe;
    sigemptyset(&pipe);
    sigaddset(&pipe, SIGPIPE);
    ::pthread_sigmask(SIG_BLOCK, &pipe, &before_);
  }
  ~NoPipeSignal() {
    // Consume a pending SIGPIPE before unblocking it.
    sigset_t pipe;
    sigemptyset(&pipe);
    sigaddset(&pipe, SIGPIPE);
    const timespec at_once{};
    if (!sigismember(&before_, SIGPIPE))
      while (::sigtimedwait(&pipe, nullptr, &at_once) > 0) {
      }
    ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoPipeSignal(const NoPipeSignal&) = delete;
  NoPipeSignal& operator=(const NoPipeSignal&) = delete;

 private:
  sigset_t before_{};
};

/// Removes control characters and trailing space.
void tidy_words(std::string& words) {
  for (char& c : words) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\t') {
      c = ' ';
    } else if (byte == 0x7f || (byte < ' ' && c != '\n')) {
      c = '?';
    }
  }
  while (!words.empty() && (words.back() == ' ' || words.back() == '\n'))
    words.pop_back();
}

}  // namespace

std::string ToolEnd::why() const {
  if (was_too_slow) return "the command timed out";
  if (!words.empty()) {
    std::string line = words;
    std::ranges::replace(line, '\n', ' ');
    return line;
  }
  if (exit_code < 0) return "the command was killed";
  return fmt::format("the command exited with code {}", exit_code);
}

ToolEnd run_tool(const std::vector<std::string>& command, const ToolOptions& options) {
  const NoPipeSignal guard;
  const base::SteadyClock clock;
  Pipe input = make_pipe();
  Pipe output = make_pipe();
  Pipe words = make_pipe();
  ::fcntl(input.writer.get(), F_SETFL, O_NONBLOCK);
  Moments none;
  const auto started = start_program({.command = command,
                                      .environment = options.environment,
                                      .input = input.reader.get(),
                                      .output = output.writer.get(),
                                      .words = words.writer.get(),
                                      .yields = options.yields},
                                     none);
  if (!started) throw base::Error(started.error());
  const pid_t child = started.value();
  input.reader.reset();
  output.writer.reset();
  words.writer.reset();

  ToolEnd end;
  std::string_view rest = options.input;
  const double end_s = clock.now_s() + options.seconds_max;
  while (output.reader || words.reader) {
    const double left_s = options.stop != nullptr && *options.stop ? 0 : end_s - clock.now_s();
    end.was_too_slow = left_s <= 0;
    if (end.was_too_slow) break;
    std::array<pollfd, 3> waits{{{.fd = output.reader.get(), .events = POLLIN, .revents = 0},
                                 {.fd = words.reader.get(), .events = POLLIN, .revents = 0},
                                 {.fd = input.writer.get(), .events = POLLOUT, .revents = 0}}};
    if (::poll(waits.data(), waits.size(),
               std::min(static_cast<int>(left_s * 1000) + 1, k_look_at_stop_ms)) < 0)
      continue;
    bool are_words_cut = false;
    if (waits[0].revents != 0)
      take(output.reader, end.output, options.output_bytes_max, end.is_cut);
    if (waits[1].revents != 0)
      take(words.reader, end.words, options.words_bytes_max, are_words_cut);
    if (waits[2].revents != 0) give(input.writer, rest);
  }
  // A program that has closed both streams may still run.
  int status = 0;
  pid_t waited = 0;
  while (!end.was_too_slow && (waited = ::waitpid(child, &status, WNOHANG)) == 0) {
    end.was_too_slow = clock.now_s() >= end_s || (options.stop != nullptr && *options.stop);
    ::poll(nullptr, 0, k_wait_ms);
  }
  if (waited != child) {
    ::kill(-child, SIGKILL);
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
  }
  if (WIFEXITED(status) && !end.was_too_slow) end.exit_code = WEXITSTATUS(status);
  tidy_words(end.words);
  return end;
}

std::vector<std::string> environment_without(const std::vector<std::string>& beginnings,
                                             const std::vector<std::string>& kept) {
  std::vector<std::string> variables = whole_environment();
  std::erase_if(variables, [&](const std::string& variable) {
    const auto begins = [&](const std::string& beginning) {
      return variable.starts_with(beginning);
    };
    return std::ranges::any_of(beginnings, begins) && std::ranges::none_of(kept, begins);
  });
  return variables;
}

}  // namespace sleight::keeper
