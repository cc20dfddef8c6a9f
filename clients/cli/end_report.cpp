#include "clients/cli/end_report.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>

#include "common/base/check.h"
#include "common/base/error.h"

namespace sleight::cli {

EndReport::EndReport(const std::string& path, Missing missing) {
  if (path.empty()) return;
  // Don't block: the run must not wait for a supervisor that doesn't read.
  descriptor_ = ::open(path.c_str(), O_WRONLY | O_APPEND | O_NONBLOCK | O_CLOEXEC | O_NOFOLLOW);
  if (descriptor_ < 0 && missing == Missing::tells_nothing) return;
  if (descriptor_ < 0) {
    const std::string reason = errno == ENXIO ? "no process is reading it" : std::strerror(errno);
    throw base::Error(base::ExitCode::usage, fmt::format("--end-report: {}: {}", path, reason));
  }
  struct stat file {};
  if (::fstat(descriptor_, &file) != 0 || !S_ISFIFO(file.st_mode)) {
    ::close(descriptor_);
    throw base::Error(
        base::ExitCode::usage,
        fmt::format("--end-report: {}: not a named pipe; create one with mkfifo", path));
  }
  base::set_bug_listener({.heard = &EndReport::tell_bug, .context = this});
}

EndReport::~EndReport() {
  if (descriptor_ < 0) return;
  base::set_bug_listener({});
  ::close(descriptor_);
}

void EndReport::tell(const events::RunEnd& end) {
  if (descriptor_ < 0 || has_told_.exchange(true)) return;
  const std::string line = events::to_line(end);
  // A line of this length is written completely or not at all. If a pipe has no reader, writing to
  // it must not end the process.
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  const ssize_t written = ::write(descriptor_, line.data(), line.size());
  static_cast<void>(written);
  std::signal(SIGPIPE, before);
}

int EndReport::watch(const std::function<int()>& work) {
  try {
    const int code = work();
    if (code != 0) {
      tell({.end = events::End::failed,
            .exit_code = static_cast<base::ExitCode>(code),
            .words = "the log has the reasons"});
    }
    return code;
  } catch (const std::exception& error) {
    tell(events::end_by(error));
    throw;
  }
}

void EndReport::tell_bug(void* self, const std::string& place, const std::string& words) {
  static_cast<EndReport*>(self)->tell(
      {.end = events::End::bug, .exit_code = base::ExitCode::bug, .words = words, .place = place});
}

}  // namespace sleight::cli
