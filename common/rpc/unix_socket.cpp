#include "common/rpc/unix_socket.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/base/file_system.h"

namespace sleight::rpc {
namespace {

constexpr int k_waiting_max = 1024;  // accept queue; the system may limit it further

std::string reason() {
  return std::system_category().message(errno);
}

class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return value_; }
  int take() { return std::exchange(value_, -1); }

 private:
  int value_;
};

sockaddr_un address_of(int folder, const std::string& path) {
  const std::string name = path.substr(path.rfind('/') + 1);  // npos + 1 is 0
  const std::string way = fmt::format("/proc/self/fd/{}/{}", folder, name);
  sockaddr_un address = {};
  if (name.empty() || way.size() >= sizeof address.sun_path)
    throw base::Error(fmt::format("{}: the file name is empty or too long for a socket", path));
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, way.c_str(), way.size() + 1);
  return address;
}

int open_folder_of(const std::string& path) {
  return ::open(base::directory_of(path).c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
}

int make_socket() {
  const int descriptor = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (descriptor < 0) throw base::Error("can't create a socket: " + reason());
  return descriptor;
}

const sockaddr* as_address(const sockaddr_un& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

}  // namespace

// The socket starts to listen under a temporary name and is then renamed. So a client never finds a
// socket that is accessible to everybody or does not listen yet. A stale socket is replaced
// atomically.
ListeningSocket::ListeningSocket(const std::string& path, std::optional<gid_t> group)
    : path_(path) {
  const auto fail = [&](const std::string& what) {
    return base::Error(fmt::format("the service can't listen at {}: {}: {}", path, what, reason()));
  };
  const auto there = connect_to(path);
  if (there) ::close(there.value());
  if (there || there.error() == Unconnected::busy) {
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("a server already listens at {}; see `sleight server status`", path));
  }
  struct stat before = {};
  if (::lstat(path.c_str(), &before) == 0 && !S_ISSOCK(before.st_mode)) {
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("{}: the path exists but is not a socket; choose another path", path));
  }
  const Descriptor folder(open_folder_of(path));
  if (folder.get() < 0) throw fail("can't open its folder");
  Descriptor socket(make_socket());
  const std::string beside = fmt::format("{}.{}", path, ::getpid());
  ::unlink(beside.c_str());
  const sockaddr_un address = address_of(folder.get(), beside);
  if (::bind(socket.get(), as_address(address), sizeof address) != 0)
    throw fail("can't bind the socket");
  struct stat seen = {};
  if (group && ::chown(beside.c_str(), static_cast<uid_t>(-1), *group) != 0) {
    const auto error = fail(
        "can't assign the socket to its group; the daemon's user must be a member of the group");
    ::unlink(beside.c_str());
    throw error;
  }
  const mode_t mode = S_IRUSR | S_IWUSR | (group ? S_IRGRP | S_IWGRP : 0U);
  if (::chmod(beside.c_str(), mode) != 0 || ::listen(socket.get(), k_waiting_max) != 0 ||
      ::lstat(beside.c_str(), &seen) != 0 || ::rename(beside.c_str(), path.c_str()) != 0) {
    const auto error = fail("can't set up the socket");
    ::unlink(beside.c_str());
    throw error;
  }
  device_ = seen.st_dev;
  inode_ = seen.st_ino;
  descriptor_ = socket.take();
}

ListeningSocket::~ListeningSocket() {
  struct stat seen = {};
  if (::lstat(path_.c_str(), &seen) == 0 && seen.st_dev == device_ && seen.st_ino == inode_)
    ::unlink(path_.c_str());
  ::close(descriptor_);
}

base::Result<int, Unconnected> connect_to(const std::string& path) {
  const Descriptor folder(open_folder_of(path));
  if (folder.get() < 0) {
    if (errno == ENOENT || errno == ENOTDIR) return Unconnected::nobody;
    throw base::Error(fmt::format("can't connect to {}: {}", path, reason()));
  }
  Descriptor socket(make_socket());
  const sockaddr_un address = address_of(folder.get(), path);
  if (::connect(socket.get(), as_address(address), sizeof address) == 0) return socket.take();
  // ECONNREFUSED means that no process listens, or that the file is not a socket.
  if (errno == ENOENT || errno == ECONNREFUSED) return Unconnected::nobody;
  if (errno == EAGAIN) return Unconnected::busy;
  if (errno == EACCES) {
    throw base::Error(base::ExitCode::not_allowed,
                      fmt::format("this user may not use the server at {}; ask the server's "
                                  "operator to add you to its group",
                                  path));
  }
  throw base::Error(fmt::format("can't connect to {}: {}", path, reason()));
}

Peer peer_of(int descriptor) {
  ucred credentials = {};
  socklen_t length = sizeof credentials;
  if (::getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &credentials, &length) != 0)
    throw base::Error("can't determine the user of a connection: " + reason());
  return {.user = credentials.uid, .pid = credentials.pid};
}

}  // namespace sleight::rpc
