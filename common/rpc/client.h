// A client's side of the calls: each waits for its answer.
//
// A call whose connection breaks is repeated over a new one (a repeated call changes nothing more,
// service.h). `watch` and `fetch` go on over lost connections and killed daemons until the
// service has been away for too long: a watcher sees every numbered event once and in order, and a
// fetched file is whole or not there.
//
// A service of another machine is called over TLS, by a token. Nothing is sent before its
// certificate has been checked: it is the one that is known of it, or an authority vouches for it
// and for the host's name.
//
// Exceptions, all base::Error or RefusedError:
//   NoServer       none listens, or it went away and did not come back
//   NotTrusted     its certificate is not the one that is known, or nobody vouches for it
//   RefusedError   the service refused the call
//   base::Error    the service does not answer in time; a file of ours can't be written
//
// Thread safety: a Client belongs to the thread that made it, which runs no Loop; `interrupt` may
// be called from anywhere, signal handlers included.
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

/// Its words say how to start a server.
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
  double call_s_max = 30;      ///< for an answer; fetch's first one has no limit
  double first_wait_s = 0.05;  ///< before the first attempt to connect again; doubles
  double wait_s_max = 2;
  double away_s_max = 600;  ///< `watch` and `fetch` give a service up that is away for so long
};

/// A service that is reached over TLS.
struct RemoteService {
  access::ServerAddress address{};
  std::string token{};
  /// The service's own, as PEM (certificates.h), or those of authorities that vouch for it; empty:
  /// one that the system trusts does.
  std::string certificate{};
  /// That `certificate` is for where it is the service's own; empty: it is an authority's.
  std::string own_name{};
};

/// A Unix socket's path, or a service of another machine.
using ServicePlace = std::variant<std::string, RemoteService>;

/// One thing that happened to a watched job.
struct WatchedEvent {
  JobId job{};
  std::uint64_t number = 0;                 ///< 0: unnumbered
  std::string line{};                       ///< as run_event.h writes it, without its newline
  std::optional<events::RunEvent> event{};  ///< none: a newer service's, for which we have no type
};

/// Hears of watched jobs. Each function returns whether to go on.
class WatchSink {
 public:
  virtual ~WatchSink() = default;
  virtual bool changed(JobId job, const StateChange& change) = 0;
  virtual bool happened(const WatchedEvent& event) = 0;
  /// The job has ended, and all its events have been told.
  virtual bool settled(JobId) { return true; }
  /// The job can't be watched (any more): deleted, or never there. The others go on.
  virtual bool refused(JobId job, const Refusal& refusal) = 0;
  /// The connection is lost, and is tried again; `words` say why.
  virtual bool lost(const std::string& /*words*/) { return true; }
  virtual bool found_again() { return true; }
};

enum class Waited : std::uint8_t {
  settled,      ///< all that was asked for came
  stopped,      ///< by the sink
  interrupted,  ///< by interrupt()
};

/// How a fetch goes. Returns whether to go on; what has come stays for the next attempt.
using FetchProgress = std::function<bool(const FileView& file, std::uint64_t bytes)>;

/// Looks at a fetched file, by its path, before it takes its place: it came as the service has it,
/// but that may be damaged. Throws base::Error to refuse it: it is removed, its place untouched.
using FetchCheck = std::function<void(const std::string& path)>;

/// What becomes of another file that lies at a fetched one's place, also one that came there while
/// it was fetched.
enum class AtItsPlace : std::uint8_t {
  replaced,
  kept,  ///< and the fetch fails: base::Error, conflict
};

struct FetchedFiles {
  Waited how = Waited::settled;
  std::vector<std::string> paths{};  ///< of the files that are whole
};

class Client {
 public:
  /// Connects with the first call.
  explicit Client(ServicePlace place, ClientOptions options = {});
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Connects, and shows the token where there is one. Other calls do it by themselves.
  void enter();
  Submitted submit(const Submission& submission);
  JobPage list(const ListAsk& ask);
  JobView status(JobId job);
  LogPiece logs(const LogAsk& ask);
  std::vector<Touched> change(const ChangeAsk& ask);
  ServerView info();
  void drain();
  void stop();
  /// `ask.token` is drawn by the caller, so that a repeated call makes no second one.
  TokenView create_token(const TokenAsk& ask);
  std::vector<TokenView> tokens();
  TokenView revoke_token(const std::string& id);

  /// Until all are settled or refused; each from its point on. REQUIRES: no job twice, at most
  /// k_watch_jobs_max.
  Waited watch(const std::vector<WatchPoint>& points, WatchSink& sink);
  /// From an event's number on (1: all), and all changes of state.
  Waited watch(JobId job, std::uint64_t from_number, WatchSink& sink);

  /// The one file of this ask as `path`: written beside it, checked and renamed. A part that an
  /// earlier attempt left is gone on with where the service has the same file still.
  FetchedFiles fetch_file(FetchAsk ask, const std::string& path, const FetchProgress& progress = {},
                          const FetchCheck& check = {}, AtItsPlace other = AtItsPlace::replaced);
  /// All files of this ask into a folder, which is made, under their own names.
  FetchedFiles fetch_folder(FetchAsk ask, const std::string& folder,
                            const FetchProgress& progress = {},
                            AtItsPlace other = AtItsPlace::replaced);

  /// Makes a watch or fetch that is going on, or the next one, return.
  void interrupt();

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

/// A key for a Submission, from the system's random numbers.
std::string random_key();

}  // namespace sleight::rpc
