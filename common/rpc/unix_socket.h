// The listening end and the connecting end of a Unix socket, as file descriptors.
//
// A socket's path may exceed the system's limit of 107 bytes, because these functions use a path
// relative to the folder's descriptor.
//
// Thread safety: free functions; a ListeningSocket belongs to one thread.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/result.h"

namespace sleight::rpc {

class ListeningSocket {
 public:
  /// Creates the socket. The socket's mode is 0600, or 0660 if `group` is given. If a server is
  /// already listening there, throws base::Error with ExitCode::conflict.
  explicit ListeningSocket(const std::string& path, std::optional<gid_t> group = {});
  /// Closes the socket. Removes its file, unless the file now belongs to another socket.
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

enum class Unconnected : std::uint8_t {
  nobody,  ///< no socket, or nobody listens
  busy,    ///< the system's accept queue is full
};

/// Returns a connected descriptor, non-blocking and closed by exec. Throws base::Error for other
/// failures.
base::Result<int, Unconnected> connect_to(const std::string& path);

struct Peer {
  std::uint32_t user = 0;
  std::int64_t pid = 0;
};

/// Returns the peer process as the kernel reports it. Throws base::Error.
Peer peer_of(int descriptor);

}  // namespace sleight::rpc
