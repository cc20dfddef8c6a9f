#include "common/archive/hdf5/guarded.h"

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
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <new>
#include <string_view>

#include "common/base/error.h"

namespace sleight::archive::hdf5 {
namespace {

/// What a shell reports of a process that a broken pipe ended.
constexpr int k_exit_code_of_broken_pipe = 128 + SIGPIPE;

/// Longest message that a child hands up.
constexpr std::size_t k_message_bytes_max = 64 * 1024;
/// Pause between two looks at a child that has closed its pipe but not ended.
constexpr int k_exit_poll_ms = 5;

/// Processor time between the signal that says what happened and the kill.
constexpr rlim_t k_cpu_grace_s = 5;

/// What the child says: one letter, then the exit code in four digits, then a message.
constexpr char k_returned = 'r';
constexpr char k_threw = 't';
constexpr std::size_t k_head_bytes = 5;

void send(int pipe, char kind, int code, std::string_view message) {
  std::string text = fmt::format("{}{:04}{}", kind, code, message.substr(0, k_message_bytes_max));
  std::string_view left = text;
  while (!left.empty()) {
    const ssize_t put = ::write(pipe, left.data(), left.size());
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return;  // the parent is gone
    left.remove_prefix(static_cast<std::size_t>(put));
  }
}

/// `grace`: what the hard limit, which kills without a word, allows beyond the soft one.
void set_limit(__rlimit_resource_t resource, rlim_t value, rlim_t grace = 0) {
  struct rlimit limit {};
  ::getrlimit(resource, &limit);
  limit.rlim_cur = std::min<rlim_t>(value, limit.rlim_max);
  limit.rlim_max = std::min<rlim_t>(value + grace, limit.rlim_max);
  ::setrlimit(resource, &limit);
}

[[noreturn]] void run_child(int pipe, const std::string& subject, const GuardLimits& limits,
                            const std::function<int()>& work) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  // A handler of the program's would only set a flag that is not read here.
  for (const int signal : {SIGINT, SIGTERM, SIGXCPU})
    std::signal(signal, SIG_DFL);
  set_limit(RLIMIT_CORE, 0);
  set_limit(RLIMIT_CPU, limits.cpu_s, k_cpu_grace_s);
#ifndef SLEIGHT_SANITIZED
  set_limit(RLIMIT_AS, limits.address_space_bytes);
#endif
  try {
    const int code = work();
    std::cout.flush();
    std::fflush(nullptr);
    send(pipe, k_returned, code, "");
  } catch (const base::Error& error) {
    send(pipe, k_threw, static_cast<int>(error.exit_code()), error.what());
  } catch (const std::bad_alloc&) {
    send(pipe, k_threw, static_cast<int>(base::ExitCode::bad_archive),
         fmt::format("{}: reading it takes more than {} bytes of memory", subject,
                     limits.address_space_bytes));
  } catch (const std::exception& error) {
    send(pipe, k_threw, static_cast<int>(base::ExitCode::bug), error.what());
  }
  ::_exit(0);
}

/// A child and the pipe from it; ends the child when it goes out of scope.
class Child {
 public:
  Child(pid_t id, int pipe) : id_(id), pipe_(pipe) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (!ended_) {
      ::kill(id_, SIGKILL);
      while (::waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
      }
    }
    ::close(pipe_);
  }

  /// Reads until the child closes the pipe. False when time runs out.
  bool read_all(std::chrono::steady_clock::time_point deadline, std::string& text) {
    std::array<char, 4096> buffer{};
    while (true) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
          deadline - std::chrono::steady_clock::now());
      if (left.count() <= 0) return false;
      struct pollfd watched {
        pipe_, POLLIN, 0
      };
      const int wait_ms = static_cast<int>(std::min<std::int64_t>(left.count(), 60'000));
      if (::poll(&watched, 1, wait_ms) <= 0) continue;
      const ssize_t got = ::read(pipe_, buffer.data(), buffer.size());
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return true;
      text.append(buffer.data(), static_cast<std::size_t>(got));
    }
  }

  /// Waits for the end. False when time runs out.
  bool wait(std::chrono::steady_clock::time_point deadline, int& status) {
    while (true) {
      const pid_t got = ::waitpid(id_, &status, WNOHANG);
      if (got == id_) {
        ended_ = true;
        return true;
      }
      if (got < 0 && errno != EINTR) return false;
      if (std::chrono::steady_clock::now() >= deadline) return false;
      ::poll(nullptr, 0, k_exit_poll_ms);
    }
  }

 private:
  pid_t id_;
  int pipe_;
  bool ended_ = false;
};

[[noreturn]] void refuse(const std::string& subject, const std::string& reason) {
  throw base::Error(base::ExitCode::bad_archive, fmt::format("{}: {}", subject, reason));
}

/// A message of a child that may be in others' hands, without what could steer a terminal.
std::string harmless(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return (c >= 0 && c < ' ' && c != '\n') || c == '\x7f'; }, '?');
  return text;
}

int outcome_of(const std::string& subject, const GuardLimits& limits, const std::string& message,
               int status) {
  // A child that a hostile file has taken over may say anything: only what fits the form counts.
  int code = -1;
  if (message.size() >= k_head_bytes) {
    std::from_chars(message.data() + 1, message.data() + k_head_bytes, code);
  }
  if (code >= 0 && message[0] == k_returned) return code;
  if (code >= 0 && message[0] == k_threw) {
    throw base::Error(static_cast<base::ExitCode>(code), harmless(message.substr(k_head_bytes)));
  }
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGINT || signal == SIGTERM) {
      throw base::Error(base::ExitCode::interrupted, fmt::format("{}: interrupted", subject));
    }
    // The reader of our stdout has enough, as `head` does: end as any filter would.
    if (signal == SIGPIPE) return k_exit_code_of_broken_pipe;
    if (signal == SIGXCPU) {
      refuse(subject, fmt::format("reading it takes more than {} s of processor time: the file is "
                                  "damaged or hostile",
                                  limits.cpu_s));
    }
    refuse(subject, fmt::format("the process that read it crashed ({}): the file is damaged or "
                                "hostile",
                                ::strsignal(signal)));
  }
  // The address sanitizer ends a process like this, and so may a library.
  refuse(subject, fmt::format("the process that read it ended early with code {}: the file is "
                              "damaged or hostile",
                              WEXITSTATUS(status)));
}

}  // namespace

int guarded(const std::string& subject, const GuardLimits& limits,
            const std::function<int()>& work) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw base::Error(fmt::format("{}: can't make a pipe: {}", subject, std::strerror(errno)));
  }
  // What is waiting in buffers would be printed by both processes.
  std::cout.flush();
  std::fflush(nullptr);
  const auto deadline = std::chrono::steady_clock::now() +
                        std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                            std::chrono::duration<double>(limits.timeout_s));
  const pid_t id = ::fork();
  if (id < 0) {
    const int reason = errno;
    ::close(ends[0]);
    ::close(ends[1]);
    throw base::Error(fmt::format("{}: can't fork: {}", subject, std::strerror(reason)));
  }
  if (id == 0) {
    ::close(ends[0]);
    run_child(ends[1], subject, limits, work);
  }
  ::close(ends[1]);
  Child child(id, ends[0]);
  std::string message;
  int status = 0;
  if (!child.read_all(deadline, message) || !child.wait(deadline, status)) {
    refuse(subject, fmt::format("reading it takes more than {} s: the file is damaged or hostile",
                                limits.timeout_s));
  }
  return outcome_of(subject, limits, message, status);
}

}  // namespace sleight::archive::hdf5
