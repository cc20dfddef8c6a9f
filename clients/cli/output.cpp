#include "clients/cli/output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <system_error>

namespace sleight::cli {
namespace {

[[noreturn]] void fail_results(const std::string& reason) {
  // The reader has gone. Libraries may have the signal ignored that else says so.
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
  // Where a write fails the reason is known, not at the end.
  std::cout.exceptions(std::ios::badbit);
  try {
    code = work();
  } catch (const std::system_error& error) {
    // The formatting library throws when a print fails, and so does the stream.
    const int reason = errno;
    if (std::ferror(stdout) == 0) throw;
    // A signal came while a reader kept us waiting.
    if (error.code() == std::errc::interrupted)
      return static_cast<int>(base::ExitCode::interrupted);
    fail_results(std::strerror(reason));
  }
  // Of what was interrupted some may be lost, and its exit code says so.
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
    // The lowest free number is this one. Opened the wrong way round: uses of it fail.
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
  throw base::Error(base::ExitCode::usage,
                    fmt::format("{}: this is the archive itself; give another output", output));
}

}  // namespace sleight::cli
