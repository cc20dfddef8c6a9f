// The client's side of the service's calls. Each call waits for its answer.
//
// If a call's connection breaks, the client reconnects and repeats the call. Repeating a call has
// no further effect (service.h). `watch` and `fetch` continue after a connection is lost or a
// daemon is killed. If the service is away for too long, `watch` and `fetch` fail. A watcher
// receives every numbered event once and in order. A fetched file is complete or absent.
//
// A service on another machine is called over TLS, with a token. Before the client sends anything,
// it checks the server's certificate. Either the certificate equals the stored one, or an authority
// vouches for the certificate and the host's name.
//
// Exceptions, all base::Error or RefusedError:
//
//   NoServer       no server listens, or the server went away and did not return
//   NotTrusted     the certificate is not the known one, or no authority vouches for it
//   RefusedError   the service refused the call
//   base::Error    the service does not answer in time, or a local file can't be written
//
// Thread safety: a Client belongs to the thread that made it, which must not run a Loop.
// `interrupt` may be called from any thread and from signal handlers.
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/access/server_address.h"
#include "common/base/error.h"
#include "common/rpc/service.h"

namespace sleight::rpc {

/// The message explains how to start a server.
class NoServer : public base::Error {
 public:
  using base::Error::Error;
};

class NotTrusted : public base::Error {
 public:
  using base::Error::Error;
};

class RefusedError : public std::runtime_error {
 public:
  explicit RefusedError(Refusal refusal)
      : std::runtime_error(refusal.sentence), refusal_(std::move(refusal)) {}
  const Refusal& refusal() const { return refusal_; }

 private:
  Refusal refusal_;
};

struct ClientOptions {
  double call_s_max = 30;      ///< limit for an answer; none for fetch's first answer
  double first_wait_s = 0.05;  ///< before the first reconnect; doubles
  double wait_s_max = 2;
  double away_s_max = 600;  ///< `watch` and `fetch` fail after this time without a server
};

/// A service reached over TLS.
struct RemoteService {
  access::ServerAddress address{};
  std::string token{};
  /// PEM of the service's own certificate (certificates.h), or PEM of the authorities that vouch
  /// for the service. Empty: the system's trusted authorities.
  std::string certificate{};
  /// If `certificate` is the service's own: the host name in it. Empty: it is an authority's.
  std::string own_name{};
};

/// A Unix socket's path, or a service on another machine.
using ServicePlace = std::variant<std::string, RemoteService>;

struct WatchedEvent {
  JobId job{};
  std::uint64_t number = 0;                 ///< 0: unnumbered
  std::string line{};                       ///< JSON as in run_event.h, without a newline
  std::optional<events::RunEvent> event{};  ///< empty: type unknown here, from a newer service
};

/// Receives news of watched jobs. Each function returns whether to continue watching.
class WatchSink {
 public:
  virtual ~WatchSink() = default;
  virtual bool changed(JobId job, const StateChange& change) = 0;
  virtual bool happened(const WatchedEvent& event) = 0;
  /// Called when the job has ended and all its events have been delivered.
  virtual bool settled(JobId) { return true; }
  /// Called if the job was deleted or never existed. Watching the other jobs continues.
  virtual bool refused(JobId job, const Refusal& refusal) = 0;
  /// Called when the connection is lost and the client tries to reconnect. `words` give the reason.
  virtual bool lost(const std::string& /*words*/) { return true; }
  virtual bool found_again() { return true; }
};

enum class Waited : std::uint8_t {
  settled,  ///< everything requested has arrived
  stopped,  ///< by the sink
  interrupted,
};

/// Receives a fetch's progress and returns whether to continue. If the function returns false, the
/// received bytes are stored for the next attempt.
using FetchProgress = std::function<bool(const FileView& file, std::uint64_t bytes)>;

/// Checks a received file at `path` before the file is moved to its place. The service's own copy
/// may be damaged. Throws base::Error to refuse the file. A refused file is removed. Its place
/// isn't changed.
using FetchCheck = std::function<void(const std::string& path)>;

/// What happens if another file is already at a fetched file's place, or appears there during the
/// fetch.
enum class AtItsPlace : std::uint8_t {
  replaced,
  kept,  ///< the fetch fails (base::Error, conflict) if the contents differ
};

struct FetchedFiles {
  Waited how = Waited::settled;
  std::vector<std::string> paths{};  ///< paths of the complete files
};

class Client {
 public:
  /// Connects on the first call.
  explicit Client(ServicePlace place, ClientOptions options = {});
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Connects, and logs in if there is a token. Other calls connect automatically.
  void enter();
  Submitted submit(const Submission& submission);
  JobPage list(const ListAsk& ask);
  JobView status(JobId job);
  LogPiece logs(const LogAsk& ask);
  std::vector<Touched> change(const ChangeAsk& ask);
  ServerView info();
  void drain();
  void stop();
  /// The caller draws `ask.token`, so that a repeated call creates no second token.
  TokenView create_token(const TokenAsk& ask);
  std::vector<TokenView> tokens();
  TokenView revoke_token(const std::string& id);

  /// Watches each job from its WatchPoint until all jobs are settled or refused. REQUIRES: at most
  /// k_watch_jobs_max different jobs.
  Waited watch(const std::vector<WatchPoint>& points, WatchSink& sink);
  /// Watches one job. The sink gets all state changes, and the events from number `from_number` on
  /// (1: all).
  Waited watch(JobId job, std::uint64_t from_number, WatchSink& sink);

  /// Fetches the only file of `ask`: writes a temporary file, checks it and renames it to `path`.
  /// If an earlier attempt received a part and the service still has the same file, continues from
  /// that part.
  FetchedFiles fetch_file(FetchAsk ask, const std::string& path, const FetchProgress& progress = {},
                          const FetchCheck& check = {}, AtItsPlace other = AtItsPlace::replaced);
  /// Fetches all files of `ask` into `folder`, under their own names. Creates the folder if it is
  /// missing.
  FetchedFiles fetch_folder(FetchAsk ask, const std::string& folder,
                            const FetchProgress& progress = {},
                            AtItsPlace other = AtItsPlace::replaced);

  /// Makes the current or next watch or fetch return.
  void interrupt();

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

/// Draws a key for a Submission from the system's random numbers.
std::string random_key();

}  // namespace sleight::rpc
