// A Unix socket's two ends, as file descriptors.
//
// A socket's path may be longer than the 107 bytes that the system takes: it is reached through
// its folder's descriptor.
//
// Thread safety: free functions, and a resource that belongs to one thread.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/result.h"

namespace sleight::rpc {

/// A listening socket, and its name in the file system.
class ListeningSocket {
 public:
  /// Mode 0600; with a group 0660 and that group's. Throws base::Error: ExitCode::conflict where a
  /// server listens there.
  explicit ListeningSocket(const std::string& path, std::optional<gid_t> group = {});
  /// Closes it, and removes the name if it is still this socket's.
  ~ListeningSocket();
  ListeningSocket(const ListeningSocket&) = delete;
  ListeningSocket& operator=(const ListeningSocket&) = delete;

  int descriptor() const { return descriptor_; }

 private:
  std::string path_;
  int descriptor_ = -1;
  dev_t device_ = 0;
  ino_t inode_ = 0;
};

/// Why there is no connection.
enum class Unconnected : std::uint8_t {
  nobody,  ///< no socket there, or one that nobody listens at
  busy,    ///< more wait to be accepted than the system takes
};

/// A connected descriptor, non-blocking and closed by exec. Throws base::Error for other reasons.
base::Result<int, Unconnected> connect_to(const std::string& path);

struct Peer {
  std::uint32_t user = 0;
  std::int64_t pid = 0;
};

/// Whose process has the other end, as the kernel says. Throws base::Error.
Peer peer_of(int descriptor);

}  // namespace sleight::rpc
