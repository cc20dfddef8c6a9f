#include "common/archive/remote/reader_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <system_error>
#include <vector>

#include "common/archive/remote/messages.h"

namespace sleight::archive::remote {
namespace {

/// Time that a process has to end after closing its pipe.
constexpr auto k_ending = std::chrono::seconds(2);
constexpr int k_look_every_ms = 2;
/// Size of the answers' pipe. A batch fits into the pipe, so that the reader need not wait for this
/// process.
constexpr int k_pipe_bytes = 1 << 20;
/// Copies of descriptors get at least this number. The new process's own descriptors are lower, so
/// they overwrite no copy.
constexpr int k_first_free_descriptor = 10;

[[noreturn]] void fail_start(const std::string& program, int reason) {
  throw base::Error(fmt::format(
      "{}: can't start the process that reads archives: {}{}", program, std::strerror(reason),
      reason == ENOENT ? "; install it in the folder of the program that starts it" : ""));
}

base::Descriptor raised(const base::Descriptor& low, const std::string& program) {
  base::Descriptor high(::fcntl(low.get(), F_DUPFD_CLOEXEC, k_first_free_descriptor));
  if (!high) fail_start(program, errno);
  return high;
}

struct Ends {
  base::Descriptor ours;
  base::Descriptor theirs;
};

/// If `is_ours_first`, this process reads from the pipe and the other process writes.
Ends pipe_of(bool is_ours_first, const std::string& program) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail_start(program, errno);
  base::Descriptor first(ends[0]);
  base::Descriptor second(ends[1]);
  if (is_ours_first) return {std::move(first), raised(second, program)};
  return {std::move(second), raised(first, program)};
}

/// Returns a socket pair. A socket is better than a pipe: sending to an exited process then raises
/// no signal.
Ends socket_pair(const std::string& program) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    fail_start(program, errno);
  base::Descriptor first(ends[0]);
  const base::Descriptor second(ends[1]);
  return {std::move(first), raised(second, program)};
}

class SpawnOrders {
 public:
  SpawnOrders() {
    ::posix_spawn_file_actions_init(&actions_);
    ::posix_spawnattr_init(&attributes_);
  }
  SpawnOrders(const SpawnOrders&) = delete;
  SpawnOrders& operator=(const SpawnOrders&) = delete;
  ~SpawnOrders() {
    ::posix_spawn_file_actions_destroy(&actions_);
    ::posix_spawnattr_destroy(&attributes_);
  }

  void place(int descriptor, int at) {
    note(::posix_spawn_file_actions_adddup2(&actions_, descriptor, at));
  }

  /// Closes all other descriptors and resets ignored and blocked signals. Sets a new process group,
  /// so that the process gets no signals from the terminal.
  void clean_all_else() {
#ifndef SLEIGHT_SANITIZED
    // Discard standard error, except under a sanitizer, which writes its reports there.
    note(::posix_spawn_file_actions_addopen(&actions_, STDERR_FILENO, "/dev/null", O_WRONLY, 0));
#endif
    note(::posix_spawn_file_actions_addclosefrom_np(&actions_, k_lifeline_descriptor + 1));
    sigset_t all;
    sigset_t none;
    ::sigfillset(&all);
    ::sigemptyset(&none);
    note(::posix_spawnattr_setsigdefault(&attributes_, &all));
    note(::posix_spawnattr_setsigmask(&attributes_, &none));
    note(::posix_spawnattr_setpgroup(&attributes_, 0));
    note(::posix_spawnattr_setflags(
        &attributes_, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP));
  }

  /// Returns 0, or an error number.
  int spawn(pid_t& id, const std::string& program, char* const* arguments,
            char* const* environment) const {
    if (reason_ != 0) return reason_;
    return ::posix_spawn(&id, program.c_str(), &actions_, &attributes_, arguments, environment);
  }

 private:
  void note(int result) {
    if (reason_ == 0) reason_ = result;
  }
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
  int reason_ = 0;
};

std::vector<std::string> cleaned_environment() {
  std::vector<std::string> variables{"LC_ALL=C"};
#ifdef SLEIGHT_SANITIZED
  for (const char* name : {"ASAN_OPTIONS", "UBSAN_OPTIONS", "TSAN_OPTIONS"}) {
    if (const char* value = std::getenv(name))
      variables.push_back(fmt::format("{}={}", name, value));
  }
#endif
  return variables;
}

std::vector<char*> pointers_of(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words)
    pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

ReaderEnd why_it_ended(int status, const ReaderLimits& limits) {
  if (!WIFSIGNALED(status)) {
    return {.words = fmt::format(
                "the reader process exited early with code {}; the file is damaged or hostile",
                WEXITSTATUS(status)),
            .is_abrupt = true};
  }
  const int signal = WTERMSIG(status);
  if (signal == SIGXCPU) {
    return {.words = fmt::format("reading the archive takes more than {} s of processor time; the "
                                 "file is damaged or hostile",
                                 limits.cpu_s)};
  }
  if (signal == SIGSYS) {
    return {.words =
                "the reader process made a forbidden system call and was killed; the file is "
                "damaged or hostile"};
  }
  if (signal == SIGKILL) {
    return {.words = "the reader process was killed, by a user or because memory ran out",
            .exit_code = base::ExitCode::environment};
  }
  return {.words = fmt::format("the reader process crashed ({}); the file is damaged or hostile",
                               ::strsignal(signal)),
          .is_abrupt = true};
}

}  // namespace

ReaderProcess::ReaderProcess(const std::string& program, int archive, const ReaderLimits& limits)
    : limits_(limits) {
  Ends questions = socket_pair(program);
  Ends answers = pipe_of(true, program);
  Ends lifeline = pipe_of(false, program);
  const base::Descriptor raised_archive(::fcntl(archive, F_DUPFD_CLOEXEC, k_first_free_descriptor));
  if (!raised_archive) fail_start(program, errno);
  // Failure is harmless, because a larger pipe is only faster.
  ::fcntl(answers.ours.get(), F_SETPIPE_SZ, k_pipe_bytes);
  ::fcntl(answers.ours.get(), F_SETFL, O_NONBLOCK);

  SpawnOrders orders;
  orders.place(questions.theirs.get(), k_questions_descriptor);
  orders.place(answers.theirs.get(), k_answers_descriptor);
  orders.place(raised_archive.get(), k_archive_descriptor);
  orders.place(lifeline.theirs.get(), k_lifeline_descriptor);
  orders.clean_all_else();
  std::vector<std::string> arguments{program, std::to_string(limits.address_space_bytes)};
  std::vector<std::string> environment = cleaned_environment();
  const int reason =
      orders.spawn(id_, program, pointers_of(arguments).data(), pointers_of(environment).data());
  if (reason != 0) fail_start(program, reason);
  questions_ = std::move(questions.ours);
  answers_ = std::move(answers.ours);
  lifeline_ = std::move(lifeline.ours);
  renew_limits();
}

ReaderProcess::~ReaderProcess() {
  if (id_ < 0) return;
  ::kill(id_, SIGKILL);
  while (::waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void ReaderProcess::renew_limits() {
  deadline_ = std::chrono::steady_clock::now() +
              std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                  std::chrono::duration<double>(limits_.timeout_s));
  // Don't renew the limit at each question, because that would double the system calls for a
  // question. Losing one second of the limit is harmless.
  constexpr auto k_renewed_every = std::chrono::seconds(1);
  const auto now = std::chrono::steady_clock::now();
  if (now - renewed_ < k_renewed_every) return;
  renewed_ = now;
  limit_processor_time();
}

/// Sets the limit from this process, so that the reader can give up the right to change its limits.
/// If setting the limit fails, the deadline still applies.
void ReaderProcess::limit_processor_time() const {
  clockid_t clock{};
  timespec used{};
  rlimit limit{};
  if (::clock_getcpuclockid(id_, &clock) != 0 || ::clock_gettime(clock, &used) != 0 ||
      ::prlimit(id_, RLIMIT_CPU, nullptr, &limit) != 0)
    return;
  const rlim_t seconds = static_cast<rlim_t>(used.tv_sec) + limits_.cpu_s;
  limit.rlim_cur = std::min(std::max<rlim_t>(seconds, 1), limit.rlim_max);
  ::prlimit(id_, RLIMIT_CPU, &limit, nullptr);
}

bool ReaderProcess::send(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(questions_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
  return true;
}

Received ReaderProcess::receive(std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t got = ::read(answers_.get(), bytes.data(), bytes.size());
    if (got > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(got));
      continue;
    }
    if (got == 0 || (errno != EAGAIN && errno != EINTR)) return Received::ended;
    // Check the deadline here: even if a reader sends single bytes, this point is reached after
    // each byte. Received data is never late.
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline_ - std::chrono::steady_clock::now());
    if (left.count() <= 0) return Received::late;
    pollfd watched{answers_.get(), POLLIN, 0};
    ::poll(&watched, 1, static_cast<int>(std::min<std::int64_t>(left.count(), 60'000)));
  }
  return Received::all;
}

bool ReaderProcess::has_unasked_words() const {
  pollfd watched{answers_.get(), POLLIN, 0};
  return ::poll(&watched, 1, 0) > 0 && (watched.revents & POLLIN) != 0;
}

ReaderEnd ReaderProcess::end() {
  const auto latest = std::chrono::steady_clock::now() + k_ending;
  int status = 0;
  pid_t got = 0;
  while ((got = ::waitpid(id_, &status, WNOHANG)) == 0 || (got < 0 && errno == EINTR)) {
    if (std::chrono::steady_clock::now() > latest) {
      ::kill(id_, SIGKILL);
      while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
      }
      id_ = -1;
      return {.words = "the reader process stopped answering; the file is damaged or hostile"};
    }
    ::poll(nullptr, 0, k_look_every_ms);
  }
  id_ = -1;
  // If this program ignores SIGCHLD, the exit status is unavailable.
  if (got < 0)
    return {.words = "the reader process has exited; the file is damaged or hostile",
            .is_abrupt = true};
  return why_it_ended(status, limits_);
}

std::string reader_beside_this_program() {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) {
    throw base::Error(
        fmt::format("/proc/self/exe: can't find the path of this program: {}", error.message()));
  }
  return program.parent_path() / "sleight-reader";
}

}  // namespace sleight::archive::remote
