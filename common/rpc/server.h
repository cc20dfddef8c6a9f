// Listens on a Unix socket, and over TLS where that is asked for, and hands calls to a Handler.
//
// Peers are not trusted. Whatever they send or leave unread, what the server holds for all of them
// together is bounded by ServerLimits, and the others are served:
//   1. A message that is too large, or nested too deeply, ends its connection; so does one that is
//      not whole in time, and an answer that is not read in time.
//   2. A connection has at most `calls_max` calls at once; more are refused. While its peer leaves
//      answers unread, nothing more is read from it.
//   3. Where the messages and answers of all connections exceed `held_bytes_max`, the connection
//      that has kept them longest is ended.
//   4. Where there are too many connections, the one that has been idle longest makes room; if none
//      has been for `idle_grace_s`, the new one is closed.
//   5. Over TLS a peer is a stranger until it has shown a token. Strangers have `login_s_max` for
//      handshake and login, messages of `stranger_bytes_max`, and one try; there are at most
//      `strangers_max` of them, apart from the others: where there are more, the one that has been
//      there longest makes room, as in 4. A session ends as soon as its token does.
// An ended connection costs a client nothing: it connects again (client.h).
//
// What goes wrong is answered as a Refusal; an exception of a handler as a bug, without its words,
// which go to `complain`.
//
// Thread safety: all on the loop's thread.
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
  std::size_t calls_max = 16;  ///< of one connection, unanswered
  std::size_t message_bytes_max = 4U << 20U;
  std::size_t held_bytes_max = 64U << 20U;  ///< messages that come in, and answers not yet read
  std::size_t sources_max = 128;            ///< files that one connection is fetching
  double idle_grace_s = 0.5;
  double message_s_max = 30;  ///< for a message to come in whole, and for an answer to be read
  /// A watch without news is answered after so long, so that both sides know of each other.
  double watch_s_max = 20;
  std::size_t strangers_max = 64;
  std::size_t stranger_bytes_max = 16U << 10U;
  double login_s_max = 10;
};

struct ServerOptions {
  ServerLimits limits{};
  std::function<void(const std::string&)> complain{};
  std::optional<std::uint32_t> group{};  ///< may use the socket, beside its owner
  /// Called until the last reply is gone, which may be after the server.
  Audit audit{};
};

/// For `server status`, and for tests of the limits.
struct ServerCounts {
  std::size_t connections = 0;
  std::size_t watchers = 0;  ///< watch calls that wait for news
  std::size_t held_bytes = 0;
  std::size_t strangers = 0;   ///< over TLS, that nobody knows yet
  std::uint64_t accepted = 0;  ///< of all time, as are the following
  std::uint64_t ended = 0;     ///< connections that the server ended, by a limit
  std::uint64_t calls = 0;
};

class Server {
 public:
  /// Listens from here on. The socket is its owner's alone (0600), or also a group's (0660): whose
  /// a call is, is what the kernel says of its peer. A file left by a server that is gone is
  /// replaced; throws base::Error with ExitCode::conflict where one listens, and with
  /// ExitCode::environment where the socket can't be made. `handler` and `loop` must outlive it.
  Server(Loop& loop, const std::string& socket_path, Handler& handler, ServerOptions options = {});
  /// Ends all connections and removes the socket.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Listens over TLS too, 1.2 or newer, for peers that `authority` knows. Returns where: port 0
  /// takes any that is free. Throws base::Error as the constructor, and where the certificate or
  /// its key is no good. Once. `authority` must outlive the server.
  access::ServerAddress listen(const access::ServerAddress& address, const access::Keypair& keypair,
                               Authority& authority);

  /// A job may have something new for its watchers. Costs little where nobody watches it.
  void news(JobId job);

  ServerCounts counts() const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace sleight::rpc
