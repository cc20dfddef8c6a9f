// Serves a page and its data over HTTP/1.1 to one person's browser, on this machine's loopback
// address.
//
// Other users of the host can reach loopback, and so can pages of other servers in the person's
// browser. So each request must pass a guard (guard.h), and ServerLimits bound the cost of requests
// that don't pass:
//
// 1. A head that is too long or too slow is refused (431, 408), and its connection closed. A
//    body is read only after its head has passed the guard.
// 2. A connection has one request at a time; further requests wait in the system's buffers.
// 3. Bodies of all requests together use at most `bodies_bytes_max`; a request beyond this limit
//    gets the answer 503. If answers being sent use more than `answers_bytes_max`, the connection
//    that has been receiving longest is closed.
// 4. If there are too many connections, the one that waits longest without having shown a valid
//    cookie is closed. If no connection may be closed, the new one gets the answer 503.
// 5. A stream of events with more than `stream_bytes_max` unread bytes is closed. The browser
//    reconnects and then receives the newest event of each name.
//
// The handler has a few separate threads, so a slow answer blocks other answers only when all of
// these threads are busy. The page's files, events and refusals don't need these threads. If a
// handler throws, the answer is 500 without the exception's message, which goes to `complain`.
//
// Processes started while the server runs inherit no socket.
//
// Thread safety: all functions may be called from any thread, except that the handler and
// `complain` must not call `stop` or the destructor. The handler and `complain` are called on
// several threads at once.
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
  std::size_t streams_max = 16;             ///< streams of events; they also count as connections
  std::size_t head_bytes_max = 16U << 10U;  ///< at least 4 kB
  std::size_t body_bytes_max = 4U << 20U;   ///< per request
  std::size_t bodies_bytes_max = 32U << 20U;
  std::size_t answers_bytes_max = 256U << 20U;  ///< shared content counts once per connection
  std::size_t stream_bytes_max = 4U << 20U;
  double head_s_max = 10;  ///< since the connection or last answer; also when idle
  double body_s_max = 30;
  double write_s_max = 30;       ///< per 256 kB of an answer, and per event
  double linger_s_max = 2;       ///< for a refused peer to read the reason
  double idle_grace_s = 0.5;     ///< younger connections are not closed to make room
  double stream_comment_s = 15;  ///< between comments, by which both sides detect a lost connection
};

struct ServerOptions {
  std::uint16_t port = 0;  ///< 0: any free port
  /// Further addresses of this server for browsers, besides 127.0.0.1:PORT and localhost:PORT.
  /// Example: "localhost:8080" for `ssh -L 8080:localhost:PORT`.
  std::vector<std::string> hosts{};
  /// The secret in authorized browsers' cookies (keys.h); empty: a new one. After a restart with
  /// the same secret and port, open pages need no new link.
  std::string secret{};
  std::string events_path = "/api/events";
  /// Advice for a person whose browser isn't authorized.
  std::string way_in =
      "Open the link that the program printed; each link works in one browser. If the link was "
      "already used, get a new one from the program, or restart it.";
  /// Answers GET requests for "/" and the files' names; may be null.
  std::shared_ptr<const StaticFiles> files{};
  std::size_t threads = 4;  ///< for the handler
  ServerLimits limits{};
  std::function<void(const std::string&)> complain{};
};

/// For tests.
struct ServerCounts {
  std::size_t connections = 0;
  std::size_t streams = 0;
  std::size_t bodies_bytes = 0;   ///< of requests that are arriving or being answered
  std::size_t answers_bytes = 0;  ///< of answers that are being sent
  std::uint64_t closed = 0;       ///< connections closed by a limit since the start
  std::uint64_t asks = 0;         ///< requests that passed the guard since the start
};

class Server {
 public:
  using Handler = std::function<Answer(const Ask&)>;

  /// Starts to listen and answer. Throws base::Error if it cannot: ExitCode::conflict if the port
  /// is in use.
  Server(ServerOptions options, Handler handler);
  /// Calls stop().
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::uint16_t port() const;
  /// The newest link for a browser, used or not: http://127.0.0.1:PORT/?token=... Each link works
  /// in one browser.
  std::string link() const;
  /// Creates a new link. The latest eight unused links stay valid.
  std::string new_link();

  /// Sends an event to all streams. Data may have several lines. REQUIRES: `event` has no control
  /// characters.
  void publish(const std::string& event, const std::string& data);

  /// Closes all connections and waits for running handlers.
  void stop();

  ServerCounts counts() const;

  struct Impl;  ///< in server_impl.h

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace sleight::web
