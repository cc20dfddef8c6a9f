#include "service/keeper/program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

// This header requires that signal.h and unistd.h are included before it.
#include <linux/close_range.h>

#include "common/base/check.h"
#include "common/base/descriptor.h"

namespace sleight::keeper {
namespace {

constexpr int k_low_priority = 10;

/// Restores the default dispositions and signal mask.
void reset_signals(bool blocks_sigterm) {
  for (int number = 1; number < NSIG; ++number)
    std::signal(number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  if (blocks_sigterm) sigaddset(&none, SIGTERM);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
}

bool take_streams(const ProgramStart& start) {
  const int input = start.input >= 0 ? start.input : ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  const int words = start.words >= 0 ? start.words : start.output;
  return input >= 0 && ::dup2(input, STDIN_FILENO) >= 0 &&
         ::dup2(start.output, STDOUT_FILENO) >= 0 && ::dup2(words, STDERR_FILENO) >= 0;
}

bool dump_no_core() {
  const rlimit none{.rlim_cur = 0, .rlim_max = 0};
  return ::setrlimit(RLIMIT_CORE, &none) == 0;
}

/// Runs in the child. Becomes the program, or reports the error to `report` and exits.
[[noreturn]] void become(const ProgramStart& start, char* const* arguments,
                         char* const* environment, pid_t starter, int report, Moments& moments) {
  // Do this first. If the starter has just died, the child then doesn't outlive it.
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0 || ::getppid() != starter) ::_exit(127);
  moments.reached(Moment::in_child);
  if (start.yields) ::setpriority(PRIO_PROCESS, 0, k_low_priority);
  const bool is_ready = ::setsid() >= 0 && take_streams(start) && dump_no_core() &&
                        ::close_range(3, ~0U, CLOSE_RANGE_CLOEXEC) == 0;
  if (is_ready) {
    reset_signals(start.blocks_sigterm);
    ::execvpe(arguments[0], arguments, environment);
  }
  const int error = errno;
  const ssize_t written = ::write(report, &error, sizeof(error));
  ::_exit(written == sizeof(error) ? 127 : 126);
}

}  // namespace

std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words)
    pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

base::Result<pid_t, std::string> start_program(const ProgramStart& start, Moments& moments) {
  CHECK(!start.command.empty());
  const auto failed = [&](int error) {
    return fmt::format("can't start {}: {}", start.command.front(), std::strerror(error));
  };
  std::vector<std::string> command = start.command;
  std::vector<std::string> variables = start.environment;
  const std::vector<char*> arguments = pointers_to(command);
  const std::vector<char*> environment = pointers_to(variables);
  // If exec succeeds, it closes the child's end, so an empty pipe means success.
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return failed(errno);
  const base::Descriptor heard(ends[0]);
  base::Descriptor report(ends[1]);
  const pid_t starter = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) return failed(errno);
  if (child == 0) {
    become(start, arguments.data(), environment.data(), starter, report.get(), moments);
  }
  report.reset();
  moments.reached(Moment::forked);
  int error = 0;
  ssize_t count = 0;
  do {
    count = ::read(heard.get(), &error, sizeof(error));
  } while (count < 0 && errno == EINTR);
  if (count != sizeof(error)) return child;
  ::waitpid(child, nullptr, 0);
  return failed(error);
}

}  // namespace sleight::keeper
