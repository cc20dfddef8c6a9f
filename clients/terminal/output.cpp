#include "clients/terminal/output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <system_error>

#include "common/request/text.h"

namespace sleight::terminal {
namespace {

[[noreturn]] void fail_results(const std::string& reason) {
  // The reader has closed the pipe. Raise SIGPIPE, which libraries may have ignored.
  if (errno == EPIPE) {
    std::signal(SIGPIPE, SIG_DFL);
    std::raise(SIGPIPE);
  }
  throw base::Error(fmt::format("can't write the results to standard output: {}", reason));
}

}  // namespace

void refuse_usage(const std::string& words) {
  throw base::Error(base::ExitCode::usage, words);
}

void flush_stdout() {
  if (std::fflush(stdout) != 0) fail_results(std::strerror(errno));
  if (std::ferror(stdout) != 0 || !std::cout) fail_results("an earlier write failed");
}

int with_results(const std::function<int()>& work) {
  int code = 0;
  // Make std::cout throw on a failed write, while the reason is known.
  std::cout.exceptions(std::ios::badbit);
  try {
    code = work();
  } catch (const std::system_error& error) {
    // Both the formatting library and the stream throw when a print fails.
    const int reason = errno;
    if (std::ferror(stdout) == 0) throw;
    // A signal arrived while waiting for a reader.
    if (error.code() == std::errc::interrupted)
      return static_cast<int>(base::ExitCode::interrupted);
    fail_results(std::strerror(reason));
  }
  // Interrupted output may be incomplete, and the exit code shows that.
  if (code == static_cast<int>(base::ExitCode::interrupted)) {
    std::fflush(stdout);
    return code;
  }
  flush_stdout();
  return code;
}

void occupy_standard_streams() {
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
    // open() returns the lowest free number, which is this stream's number. The stream is opened in
    // the wrong direction, so that every use of the stream fails.
    if (::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream) {
      throw base::Error("standard input, output or error is closed and /dev/null can't be opened");
    }
  }
}

void refuse_same_file(const std::string& archive, const std::string& output) {
  struct stat from {};
  struct stat to {};
  if (::stat(archive.c_str(), &from) != 0 || ::stat(output.c_str(), &to) != 0) return;
  if (from.st_dev != to.st_dev || from.st_ino != to.st_ino) return;
  throw base::Error(
      base::ExitCode::usage,
      fmt::format("{}: the output is the archive itself; choose another output", output));
}

std::string shown_on_one_line(std::string text) {
  while (!text.empty() && text.back() == '\n')
    text.pop_back();
  std::ranges::replace(text, '\n', ' ');
  return shown(text);
}

std::string shown(std::string_view text) {
  constexpr std::size_t k_characters_max = 1000;  // longer sentences of the service are cut
  return request::printable(text, k_characters_max);
}

void complain(std::string line) {
  std::ranges::replace_if(
      line, [](char c) { return (c >= 0 && c < ' ' && c != '\n' && c != '\t') || c == '\x7f'; },
      '?');
  std::fputs((line + "\n").c_str(), stderr);
}

EndsWithItsReader::EndsWithItsReader() : over_(::eventfd(0, EFD_CLOEXEC)) {
  if (over_ < 0) return;
  look_ = std::thread([over = over_] {
    // Leave signals to the main thread.
    sigset_t all;
    sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
    while (true) {
      pollfd looks[2] = {{.fd = STDOUT_FILENO, .events = 0, .revents = 0},
                         {.fd = over, .events = POLLIN, .revents = 0}};
      if (::poll(looks, 2, -1) < 0) continue;
      if (looks[1].revents != 0) return;
      // A vanished terminal is reported by SIGHUP instead.
      if ((looks[0].revents & POLLERR) == 0) return;
      std::signal(SIGPIPE, SIG_DFL);
      ::kill(::getpid(), SIGPIPE);
      return;
    }
  });
}

EndsWithItsReader::~EndsWithItsReader() {
  if (over_ < 0) return;
  const std::uint64_t one = 1;
  static_cast<void>(!::write(over_, &one, sizeof one));
  look_.join();
  ::close(over_);
}

}  // namespace sleight::terminal
