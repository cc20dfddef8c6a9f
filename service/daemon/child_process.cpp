#include "service/daemon/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "common/base/clock.h"
#include "common/base/error.h"
#include "service/keeper/command.h"

namespace sleight::daemon {
namespace {

constexpr int k_low_priority = 10;
/// How often it is asked whether the program is to be stopped.
constexpr double k_look_ms = 100;

std::vector<std::string> environment_of_this() {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable)
    variables.emplace_back(*variable);
  return keeper::cleaned_environment(variables);
}

std::vector<char*> pointers_of(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts)
    pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

/// Between fork and exec: only what is async-signal-safe, and nothing that allocates.
[[noreturn]] void become(char* const* arguments, char* const* variables, int output, bool yields) {
  if (yields) setpriority(PRIO_PROCESS, 0, k_low_priority);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  close_range(STDERR_FILENO + 1, ~0U, 0);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execve(arguments[0], arguments, variables);
  _exit(127);
}

/// Reads until the other end is closed; false where that takes too long.
bool read_all(int descriptor, const ChildOptions& options, std::string& output) {
  const base::SteadyClock clock;
  const double end_s = clock.now_s() + options.seconds_max;
  std::array<char, 4096> piece;
  while (true) {
    const double left_s = end_s - clock.now_s();
    if (left_s <= 0 || (options.stop != nullptr && *options.stop)) return false;
    pollfd waiting{.fd = descriptor, .events = POLLIN, .revents = 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::min(left_s * 1000 + 1, k_look_ms)));
    if (ready < 0 && errno != EINTR) return true;
    if (ready <= 0) continue;
    const ssize_t count = read(descriptor, piece.data(), piece.size());
    if (count == 0 || (count < 0 && errno != EINTR)) return true;
    const std::size_t room = options.output_bytes_max - output.size();
    if (count > 0) output.append(piece.data(), std::min(room, static_cast<std::size_t>(count)));
  }
}

}  // namespace

ChildEnd run_child(const std::vector<std::string>& command, const ChildOptions& options) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0)
    throw base::Error(fmt::format("{}: no pipe: {}", command.front(), std::strerror(errno)));
  std::vector<std::string> arguments = command;
  std::vector<std::string> variables = environment_of_this();
  const std::vector<char*> argument_pointers = pointers_of(arguments);
  const std::vector<char*> variable_pointers = pointers_of(variables);
  const pid_t child = fork();
  if (child == 0)
    become(argument_pointers.data(), variable_pointers.data(), ends[1], options.yields);
  const int failure = errno;
  close(ends[1]);
  if (child < 0) {
    close(ends[0]);
    throw base::Error(
        fmt::format("{}: can't be started: {}", command.front(), std::strerror(failure)));
  }
  ChildEnd end;
  end.was_too_slow = !read_all(ends[0], options, end.output);
  close(ends[0]);
  if (end.was_too_slow) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status)) end.exit_code = WEXITSTATUS(status);
  if (end.exit_code == 127 && end.output.empty())
    throw base::Error(fmt::format("{}: can't be started", command.front()));
  return end;
}

}  // namespace sleight::daemon
