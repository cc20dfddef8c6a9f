#include "service/keeper/keeper_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "common/base/error.h"
#include "common/base/file_system.h"
#include "service/keeper/command.h"

namespace sleight::keeper {
namespace {

std::string path_in(const std::string& folder) {
  return folder + "/" + k_lock_name;
}

constexpr std::string_view k_mark_begin = "begun.";

std::string mark_in(const std::string& folder, std::uint32_t attempt) {
  return fmt::format("{}/{}{}", folder, k_mark_begin, attempt);
}

struct flock whole_file() {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

[[noreturn]] void fail_at(const std::string& path) {
  throw base::Error(fmt::format("{}: {}", path, std::strerror(errno)));
}

}  // namespace

std::optional<KeeperLock> KeeperLock::take(const std::string& folder) {
  const std::string path = path_in(folder);
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (descriptor < 0) fail_at(path);
  KeeperLock lock(descriptor);
  struct flock wanted = whole_file();
  if (::fcntl(descriptor, F_OFD_SETLK, &wanted) == 0) return lock;
  if (errno == EAGAIN || errno == EACCES) return std::nullopt;
  fail_at(path);
}

KeeperLock::~KeeperLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

KeeperLock::KeeperLock(KeeperLock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

bool KeeperLock::mark_begun(const std::string& folder, std::uint32_t attempt) {
  const std::string path = mark_in(folder, attempt);
  // With O_EXCL, only one process succeeds, even on network disks.
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0 && errno == EEXIST) return false;
  if (descriptor < 0) fail_at(path);
  ::close(descriptor);
  base::PosixFileSystem files;
  for (const std::string& name : files.names_in(folder)) {
    if (name.starts_with(k_mark_begin) && folder + "/" + name != path)
      files.remove(folder + "/" + name);
  }
  return true;
}

bool KeeperLock::has_begun(const std::string& folder, std::uint32_t attempt) {
  return base::PosixFileSystem().exists(mark_in(folder, attempt));
}

bool KeeperLock::is_held(const std::string& folder) {
  const std::string path = path_in(folder);
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (descriptor < 0 && errno == ENOENT) return false;
  if (descriptor < 0) fail_at(path);
  struct flock asked = whole_file();
  const int answer = ::fcntl(descriptor, F_OFD_GETLK, &asked);
  const int error = errno;
  ::close(descriptor);
  errno = error;
  if (answer != 0) fail_at(path);
  return asked.l_type != F_UNLCK;
}

}  // namespace sleight::keeper
