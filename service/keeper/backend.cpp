#include "service/keeper/backend.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

// This header requires that unistd.h is included before it.
#include <linux/close_range.h>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "service/keeper/keeper_lock.h"
#include "service/keeper/process_table.h"
#include "service/keeper/program.h"

namespace sleight::keeper {
namespace {

constexpr std::size_t k_keeper_words_max = 4096;

[[noreturn]] void fail(const std::string& what, int error) {
  throw base::Error(fmt::format("{}: {}", what, std::strerror(error)));
}

// Debian 12's <sys/pidfd.h> declares these functions only for C.
int open_process(pid_t pid) {
  return static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
}

bool signal_process(int descriptor, int number) {
  return ::syscall(SYS_pidfd_send_signal, descriptor, number, nullptr, 0) == 0;
}

/// The two ends of a connection between the launcher and the keeper's process.
struct Line {
  base::Descriptor mine;
  base::Descriptor theirs;
};

Line make_line() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    fail("can't create a socket", errno);
  return {.mine = base::Descriptor(ends[0]), .theirs = base::Descriptor(ends[1])};
}

/// Returns whether the whole value arrived.
template <class T>
bool receive(int descriptor, T& value) {
  ssize_t count = 0;
  do {
    count = ::recv(descriptor, &value, sizeof(value), MSG_WAITALL);
  } while (count < 0 && errno == EINTR);
  return count == sizeof(value);
}

/// Sends the value. If the peer has closed its end, this fails without a signal.
template <class T>
bool send(int descriptor, const T& value) {
  return ::send(descriptor, &value, sizeof(value), MSG_NOSIGNAL) == sizeof(value);
}

/// Data for the forked processes, prepared before the fork. The daemon has other threads, so a
/// forked process must not call functions that take locks.
struct KeeperStart {
  char* const* arguments;
  char* const* environment;
  int null;
  int words;      ///< becomes its stdout and stderr
  int line;       ///< sends the process id, receives permission to begin, sends exec's error
  int other_end;  ///< the launcher's end of the line
};

/// Runs in the keeper's process: waits for the launcher's permission, then becomes the keeper.
[[noreturn]] void become_keeper(const KeeperStart& start) {
  // Close this process's copy of the launcher's end. If the launcher dies, the connection then
  // breaks.
  ::close(start.other_end);
  bool goes = false;
  if (!send(start.line, ::getpid()) || !receive(start.line, goes)) ::_exit(127);
  // Block signals until the keeper can handle them.
  sigset_t waiting;
  sigemptyset(&waiting);
  for (const int number : {SIGUSR1, SIGINT, SIGTERM})
    sigaddset(&waiting, number);
  if (::sigprocmask(SIG_SETMASK, &waiting, nullptr) == 0 && ::dup2(start.null, STDIN_FILENO) >= 0 &&
      ::dup2(start.words, STDOUT_FILENO) >= 0 && ::dup2(start.words, STDERR_FILENO) >= 0 &&
      ::close_range(3, ~0U, CLOSE_RANGE_CLOEXEC) == 0) {
    ::execve(start.arguments[0], start.arguments, start.environment);
  }
  send(start.line, errno);
  ::_exit(127);
}

/// Runs in the intermediate process. The intermediate process forks the keeper's process and exits
/// at once, so that the keeper isn't the daemon's child.
[[noreturn]] void fork_keeper(const KeeperStart& start) {
  if (::setsid() < 0) ::_exit(1);
  const pid_t keeper = ::fork();
  if (keeper == 0) become_keeper(start);
  ::_exit(keeper < 0 ? 1 : 0);
}

std::string words_in(const std::string& folder) {
  const std::string path = folder + "/" + k_keeper_words_name;
  try {
    return base::PosixFileSystem().exists(path) ? base::read_text_file(path, k_keeper_words_max)
                                                : std::string();
  } catch (const base::Error&) {
    return {};  // words are only for display
  }
}

}  // namespace

RunningKeeper::RunningKeeper(ProcessIdentity identity, base::Descriptor descriptor)
    : identity_(std::move(identity)), descriptor_(std::move(descriptor)) {}

bool RunningKeeper::has_gone() const {
  pollfd wait{.fd = descriptor(), .events = POLLIN, .revents = 0};
  return ::poll(&wait, 1, 0) > 0;
}

bool RunningKeeper::stop(Stop how) const {
  if (has_gone()) return false;
  return signal_process(descriptor(), how == Stop::now ? SIGTERM : SIGUSR1);
}

LocalBackend::LocalBackend(Programs programs) : programs_(std::move(programs)) {}

RunningKeeper LocalBackend::launch(const AttemptSpec& spec) const {
  CHECK_GT(spec.attempt, 0U);
  if (const std::string obstacle = obstacle_of(spec, programs_); !obstacle.empty())
    throw base::Error(obstacle);
  return launch_command(spec.folder, keeper_command_of(spec, programs_));
}

RunningKeeper LocalBackend::launch_command(const std::string& folder,
                                           std::vector<std::string> command) const {
  std::vector<std::string> variables = program_environment();
  const std::vector<char*> arguments = pointers_to(command);
  const std::vector<char*> environment = pointers_to(variables);
  const base::Descriptor null(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  if (!null) fail("/dev/null", errno);
  const std::string words_path = folder + "/" + k_keeper_words_name;
  const base::Descriptor words(
      ::open(words_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!words) fail(words_path, errno);
  Line line = make_line();

  const pid_t between = ::fork();
  if (between < 0) fail("can't start a keeper", errno);
  if (between == 0) {
    fork_keeper({.arguments = arguments.data(),
                 .environment = environment.data(),
                 .null = null.get(),
                 .words = words.get(),
                 .line = line.theirs.get(),
                 .other_end = line.mine.get()});
  }
  line.theirs.reset();
  while (::waitpid(between, nullptr, 0) < 0 && errno == EINTR) {
  }
  pid_t keeper = 0;
  if (!receive(line.mine.get(), keeper)) fail("can't start a keeper", EAGAIN);
  // The keeper's process still waits for permission, so its id can't have been reused.
  RunningKeeper running(identity_of(keeper).value_or(ProcessIdentity{.pid = keeper}),
                        base::Descriptor(open_process(keeper)));
  if (running.descriptor() < 0) fail("can't watch the keeper", errno);
  if (!send(line.mine.get(), true)) fail("can't start a keeper", ESRCH);
  int error = 0;
  if (receive(line.mine.get(), error)) fail(command.front(), error);
  return running;
}

Look LocalBackend::look(const std::string& folder, std::uint32_t attempt) const {
  // Records only advance. Read the record before and after testing the lock. If the record stayed
  // the same, it was current during the test.
  std::string text = record_text_in(folder);
  bool is_held = KeeperLock::is_held(folder);
  for (std::string again = record_text_in(folder); again != text; again = record_text_in(folder)) {
    text = std::move(again);
    is_held = KeeperLock::is_held(folder);
  }
  Look look{.record = record_in(folder, text)};
  const std::uint32_t newest = look.record ? look.record->attempt : 0;
  if (newest > attempt) {
    throw base::Error(
        fmt::format("{}: attempt {} has begun after attempt {}; another server uses this folder",
                    folder, newest, attempt));
  }
  const bool has_begun = newest == attempt;
  const bool has_ended = has_begun && look.record->end;
  if (!has_begun) look.record.reset();
  // Somebody may have deleted the lock file. If the keeper lives, it still has the folder.
  const bool lives = has_begun && !has_ended && is_living(look.record->keeper);
  if (is_held || lives) {
    look.state = Look::State::running;
  } else if (!has_begun) {
    look.words = words_in(folder);
  } else {
    look.state = has_ended ? Look::State::ended : Look::State::died;
  }
  return look;
}

std::optional<RunningKeeper> LocalBackend::adopt(const std::string& folder,
                                                 std::uint32_t attempt) const {
  const Look looked = look(folder, attempt);
  if (looked.state != Look::State::running || !looked.record) return std::nullopt;
  const ProcessIdentity& recorded = looked.record->keeper;
  base::Descriptor descriptor(open_process(recorded.pid));
  // Open the descriptor before reading the identity. If the identity then matches, the descriptor
  // refers to the recorded process.
  if (!descriptor || identity_of(recorded.pid) != recorded) return std::nullopt;
  return RunningKeeper(recorded, std::move(descriptor));
}

bool LocalBackend::stop(const std::string& folder, std::uint32_t attempt, Stop how) const {
  const auto keeper = adopt(folder, attempt);
  return keeper && keeper->stop(how);
}

}  // namespace sleight::keeper
