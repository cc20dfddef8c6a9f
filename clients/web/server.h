// Serves a page and its data over HTTP/1.1 to one person's browser, on this machine's loopback.
//
// Loopback is shared: other users of the host reach the port, and so do pages of other servers in
// the person's own browser. So each request passes a guard (guard.h), and what those that don't can
// cost is bounded by ServerLimits:
//   1. A head that is too long, or not whole in time, is refused (431, 408) and its connection
//   closed. A
//      body is read only once its head has passed the guard.
//   2. A connection has one request at a time; what is sent behind it waits in the system's
//   buffers.
//   3. Bodies of all requests together hold at most `bodies_bytes_max`; one beyond it is answered
//   503.
//      Where answers that are being read hold more than `answers_bytes_max`, the connection that
//      has been reading longest is closed.
//   4. Where there are too many connections, one that has shown no cookie and waits longest makes
//      room; where there is none, the new one is answered 503.
//   5. A stream of events that leaves more than `stream_bytes_max` unread is closed. The browser
//      connects again, and has the newest event of each name then.
//
// The handler is called on a few threads of its own, so that a slow answer holds up no other until
// all of them are busy. Files of the page, events and refusals don't need these threads. An
// exception of a handler is answered 500, without its words, which go to `complain`.
//
// No socket is inherited by a process that is started meanwhile.
//
// Thread safety: all functions may be called from any thread, but `stop` and the destructor not
// from the handler or `complain`, which are called on several threads at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "clients/web/ask.h"
#include "clients/web/static_files.h"

namespace sleight::web {

struct ServerLimits {
  std::size_t connections_max = 64;
  std::size_t streams_max = 16;             ///< of events, among the connections
  std::size_t head_bytes_max = 16U << 10U;  ///< at least 4 kB
  std::size_t body_bytes_max = 4U << 20U;   ///< of one request
  std::size_t bodies_bytes_max = 32U << 20U;
  std::size_t answers_bytes_max = 256U << 20U;  ///< content that several are sent counts for each
  std::size_t stream_bytes_max = 4U << 20U;
  double head_s_max = 10;  ///< from its connection or the answer before; so an idle one is closed
  double body_s_max = 30;
  double write_s_max = 30;       ///< for each 256 kB of an answer, and each event, to be read
  double linger_s_max = 2;       ///< for a refused peer to read why
  double idle_grace_s = 0.5;     ///< a younger connection need not make room
  double stream_comment_s = 15;  ///< between comments by which both sides know of each other
};

struct ServerOptions {
  std::uint16_t port = 0;  ///< 0: one that is free
  /// As browsers call this server beyond 127.0.0.1:PORT and localhost:PORT: "localhost:8080" of
  /// `ssh -L 8080:localhost:PORT`.
  std::vector<std::string> hosts{};
  /// What browsers that were let in show, as keys.h makes it; empty: a new one. A server that comes
  /// back with the same one and port needs no new link.
  std::string secret{};
  std::string events_path = "/api/events";
  /// Where a browser that is not let in is told to look.
  std::string way_in =
      "Open the link that the program printed; each link authorizes one browser. If the link was "
      "already used, get a new one from the program, or restart it.";
  /// Asks for one of these names, and for "/", are answered by it; may be null.
  std::shared_ptr<const StaticFiles> files{};
  std::size_t threads = 4;  ///< of the handler
  ServerLimits limits{};
  std::function<void(const std::string&)> complain{};
};

/// For tests.
struct ServerCounts {
  std::size_t connections = 0;
  std::size_t streams = 0;
  std::size_t bodies_bytes = 0;   ///< of requests that come in or are being answered
  std::size_t answers_bytes = 0;  ///< of answers that are being read
  std::uint64_t closed = 0;       ///< connections that were closed by a limit, of all time
  std::uint64_t asks = 0;         ///< that passed the guard, of all time
};

class Server {
 public:
  using Handler = std::function<Answer(const Ask&)>;

  /// Listens and answers from here on. Throws base::Error where it can't: ExitCode::conflict where
  /// the port is taken.
  Server(ServerOptions options, Handler handler);
  /// As stop().
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::uint16_t port() const;
  /// What a browser is to open: http://127.0.0.1:PORT/?token=..., which lets in once. The newest
  /// one, whether it was used or not.
  std::string link() const;
  /// Another one; earlier ones hold, the latest eight of them.
  std::string new_link();

  /// An event for all streams. REQUIRES: a name without control characters. Data may have several
  /// lines.
  void publish(const std::string& event, const std::string& data);

  /// Closes all connections and waits for handlers that are at work.
  void stop();

  ServerCounts counts() const;

  struct Impl;  ///< of server_impl.h

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace sleight::web
