#include "service/daemon/state_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "common/base/error.h"

namespace sleight::daemon {

StateLock::StateLock(const std::string& state) {
  const std::string path = state + "/lock";
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor_ < 0) throw base::Error(fmt::format("{}: {}", path, std::strerror(errno)));
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    std::array<char, 32> text{};
    const ssize_t count = ::pread(descriptor_, text.data(), text.size() - 1, 0);
    ::close(descriptor_);
    const std::string holder(text.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
    throw base::Error(base::ExitCode::conflict,
                      fmt::format("{}: another server has this folder{}; `sleight server status` "
                                  "shows it",
                                  state, holder.empty() ? "" : ": process " + holder));
  }
  const std::string process = std::to_string(::getpid());
  if (::ftruncate(descriptor_, 0) != 0 ||
      ::pwrite(descriptor_, process.data(), process.size(), 0) < 0) {
    // The number serves people alone: on a full disk the lock holds without it.
  }
}

StateLock::~StateLock() {
  ::close(descriptor_);
}

}  // namespace sleight::daemon
