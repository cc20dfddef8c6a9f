// Listens on a Unix socket, optionally also over TLS, and passes calls to a Handler.
//
// Peers are not trusted. Whatever a peer sends or leaves unread, other peers are still served.
// ServerLimits bounds what the server stores for all peers together:
//   1. A connection ends if a message is too large, too deeply nested, or not complete in time, or
//      if the peer does not read an answer in time.
//   2. A connection has at most `calls_max` calls at once; further calls are refused. While its
//      peer leaves answers unread, the server reads nothing more from the connection.
//   3. If the messages and answers of all connections exceed `held_bytes_max`, the server ends the
//      connection that has held its bytes longest.
//   4. If there are too many connections, the server ends the one that has been idle longest. If
//      none has been idle for `idle_grace_s`, the new connection is closed.
//   5. Over TLS a peer is a stranger until it has shown a token. A stranger has `login_s_max` for
//      handshake and login, messages of at most `stranger_bytes_max`, and one try. There are at
//      most `strangers_max` strangers. Strangers are counted apart from other connections. If there
//      are too many strangers, a new one replaces the oldest. If the oldest connected less than
//      `idle_grace_s` ago, the new stranger is refused. A session ends as soon as its token is
//      revoked or expires.
// Ending a connection does a client no harm, because the client reconnects (client.h).
//
// Errors are answered as a Refusal. If a handler throws, the call is refused as a bug. `complain`
// receives the exception's message, the client doesn't.
//
// Thread safety: everything happens on the loop's thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/access/certificates.h"
#include "common/rpc/handler.h"
#include "common/rpc/loop.h"

namespace sleight::rpc {

struct ServerLimits {
  std::size_t connections_max = 512;
  std::size_t calls_max = 16;  ///< unanswered calls per connection
  std::size_t message_bytes_max = 4U << 20U;
  std::size_t held_bytes_max = 64U << 20U;  ///< messages being received and answers not yet read
  std::size_t sources_max = 128;            ///< files being fetched per connection
  double idle_grace_s = 0.5;
  double message_s_max = 30;  ///< to receive a message, or to have an answer read
  /// A watch without news is answered after this time, so that both sides notice a lost connection.
  double watch_s_max = 20;
  std::size_t strangers_max = 64;
  std::size_t stranger_bytes_max = 16U << 10U;
  double login_s_max = 10;
};

struct ServerOptions {
  ServerLimits limits{};
  std::function<void(const std::string&)> complain{};
  std::optional<std::uint32_t> group{};  ///< group that may use the socket besides its owner
  /// `audit` may be called until the last reply is destroyed, even after the server's destruction.
  Audit audit{};
};

struct ServerCounts {
  std::size_t connections = 0;
  std::size_t watchers = 0;  ///< watch calls that wait for news
  std::size_t held_bytes = 0;
  std::size_t strangers = 0;   ///< TLS connections that have not logged in
  std::uint64_t accepted = 0;  ///< since the start, like the following counts
  std::uint64_t ended = 0;     ///< connections ended by a limit
  std::uint64_t calls = 0;
};

class Server {
 public:
  /// Starts listening. Only the socket's owner can use the socket (mode 0600). If ServerOptions has
  /// a group, its members can too (mode 0660). The kernel reports each peer's uid. Replaces the
  /// socket file of a server that has exited. If another server is listening, throws base::Error
  /// with ExitCode::conflict. If the socket can't be created, throws base::Error with
  /// ExitCode::environment. `handler` and `loop` must outlive the server.
  Server(Loop& loop, const std::string& socket_path, Handler& handler, ServerOptions options = {});
  /// Ends all connections and removes the socket.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Listens over TLS (1.2 or newer) too, for peers that `authority` accepts. Call at most once.
  /// Returns the address; port 0 chooses a free port. Throws base::Error as the constructor does,
  /// and if the certificate or its key is invalid. `authority` must outlive the server.
  access::ServerAddress listen(const access::ServerAddress& address, const access::Keypair& keypair,
                               Authority& authority);

  /// Call this when a job may have news for its watchers. Cheap if nobody watches the job.
  void news(JobId job);

  ServerCounts counts() const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace sleight::rpc
