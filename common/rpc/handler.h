// The interface of the service's calls. The daemon implements it.
//
// The server (server.h) decodes a call, checks it against the limits of service.h and passes it to
// the handler, on the loop's thread. Each call comes with a Reply. The handler answers the Reply at
// once, or stores it and answers later, for example when a change is durable.
//
// Watching is pull-based. The server queries the handler for events that a watcher lacks, and
// answers as soon as it gets events. The daemon calls Server::news(job) when the job may have new
// events. After reading an answer, the watcher calls again. So a slow watcher receives every
// numbered event, but only the newest unnumbered ones. The service needs no queue for watchers.
//
// Invariants
//   1. A Reply is answered at most once. If a Reply is destroyed without an answer, the call is
//      refused as a bug of the service.
//   2. A handler must accept anything that a client can send, such as ids that don't exist or texts
//      that aren't requests. Sizes and counts are within service.h's limits, and enumerations in
//      requests are never `unknown`.
//   3. The caller's token allows the call (see the table in service_calls.cpp).
//   4. The user of a call is the peer's uid, as the kernel reports it. Over TCP, the user of a call
//      is the user of the peer's token.
//
// Thread safety: everything happens on the loop's thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.h"
#include "common/rpc/service.h"

namespace sleight::rpc {

struct Caller {
  std::uint32_t user = 0;  ///< uid
  std::int64_t pid = 0;    ///< for logs, never for decisions; 0: remote
  std::string address{};   ///< peer's TCP address, "192.0.2.7:50312"; empty: local
  std::string token_id{};  ///< token used to log in; empty: Unix socket
  Scopes scopes = Scopes::all();
  std::uint32_t token_jobs_max = 0;  ///< see TokenAsk
  std::uint32_t token_cores_max = 0;
};

struct Nothing {
  bool operator==(const Nothing&) const = default;
};

/// The pending answer to a call. Movable, not copyable.
template <class T>
class Reply {
 public:
  using Answer = base::Result<T, Refusal>;
  using Send = std::function<void(Answer)>;

  /// `send` is called exactly once, at the latest when the Reply is destroyed.
  explicit Reply(Send send) : send_(std::move(send)) {}
  Reply(Reply&& other) noexcept : send_(std::exchange(other.send_, nullptr)) {}
  Reply& operator=(Reply&& other) noexcept {
    if (this != &other) {
      drop();
      send_ = std::exchange(other.send_, nullptr);
    }
    return *this;
  }
  Reply(const Reply&) = delete;
  Reply& operator=(const Reply&) = delete;
  ~Reply() { drop(); }

  /// REQUIRES: the Reply has not been answered.
  void answer(T value) { take()(Answer(std::move(value))); }
  void refuse(Refusal refusal) { take()(Answer(std::move(refusal))); }
  void give(Answer answer) { take()(std::move(answer)); }

 private:
  Send take() {
    CHECK(send_ != nullptr);
    return std::exchange(send_, nullptr);
  }
  void drop() {
    if (send_) {
      take()(Answer(Refusal{.kind = RefusalKind::bug,
                            .sentence = "The service did not answer this call.",
                            .what_to_do = "Try again, or see the service's log."}));
    }
  }
  Send send_;
};

struct AuditLine {
  std::string call{};
  std::string of{};       ///< the target: "17", "g5"; empty: nothing to name
  std::string outcome{};  ///< "done", or the reason for failure
  std::string made{};     ///< the result: "17 18"; empty: nothing to name
};

/// Called for each audited call when the call is answered.
using Audit = std::function<void(const Caller&, const AuditLine&)>;

/// Authenticates peers over TCP.
class Authority {
 public:
  virtual ~Authority() = default;
  /// Returns the token's user. A refusal does not reveal what is wrong with the token.
  virtual base::Result<Caller, Refusal> login(const std::string& token,
                                              const std::string& address) = 0;
  /// Returns whether a session may continue: its token is neither revoked nor expired. The server
  /// calls this function at each call and several times per second.
  virtual bool lets_go_on(const Caller& caller) = 0;
};

/// A job's events and state changes that a watcher lacks.
struct Batch {
  std::vector<StateChange> changes{};  ///< consecutive, from WatchPoint::change + 1 on
  /// Numbered events, consecutive from WatchPoint::event + 1. The list may also contain unnumbered
  /// events: for each kind, the newest one, if the watcher's mark does not cover it.
  std::vector<events::RunEvent> events{};
  std::uint64_t mark = 0;  ///< covers this batch's unnumbered events
  /// True if the job is settled and this batch completes the watcher's numbered events. False if
  /// the batch was truncated because of its size.
  bool settled = false;

  bool empty() const { return changes.empty() && events.empty() && !settled; }
};

/// A file being fetched. The object lives until the client releases it or disconnects.
class Source {
 public:
  virtual ~Source() = default;
  /// Returns the same value at every call.
  virtual FileView view() const = 0;
  /// Answers with `bytes` bytes from `offset` on. REQUIRES: the range is within the file's size,
  /// and bytes <= k_piece_bytes_max. The file's content must not change.
  virtual void read(std::uint64_t offset, std::size_t bytes, Reply<base::Bytes> reply) = 0;
};

/// Opens a file on disk whose digest is `sha256`. The file stays open, so it may be replaced or
/// removed during the fetch. Throws base::Error if the file can't be opened.
std::unique_ptr<Source> open_source(const std::string& path, std::string name, std::string sha256);

struct Fetched {
  std::vector<std::unique_ptr<Source>> files{};  ///< at most k_fetch_files_max, sorted by name
  bool has_more = false;                         ///< if true, repeat with `after` = last name
};

class Handler {
 public:
  virtual ~Handler() = default;

  virtual void submit(const Caller&, Submission, Reply<Submitted>) = 0;
  virtual void list(const Caller&, ListAsk, Reply<JobPage>) = 0;
  /// Answers with the job's history.
  virtual void status(const Caller&, JobId, Reply<JobView>) = 0;
  /// Returns the news that a watcher lacks, with at most `events_max` events. The server calls this
  /// function often, so an empty result must be cheap.
  virtual base::Result<Batch, Refusal> events_after(const Caller&, const WatchPoint&,
                                                    std::size_t events_max) = 0;
  virtual void logs(const Caller&, LogAsk, Reply<LogPiece>) = 0;

  virtual void change(const Caller&, ChangeAsk, Reply<std::vector<Touched>>) = 0;
  virtual void fetch(const Caller&, FetchAsk, Reply<Fetched>) = 0;

  /// After the answer, the server fills in the numbers of connections and watchers.
  virtual void info(const Caller&, Reply<ServerView>) = 0;
  /// Starts no more jobs and stops running jobs cleanly. Answered at once.
  virtual void drain(const Caller&, Reply<Nothing>) = 0;
  /// Ends the daemon; jobs keep running. Answered before the daemon exits.
  virtual void stop(const Caller&, Reply<Nothing>) = 0;

  virtual void create_token(const Caller&, TokenAsk, Reply<TokenView>) = 0;
  virtual void list_tokens(const Caller&, Reply<std::vector<TokenView>>) = 0;
  virtual void revoke_token(const Caller&, std::string id, Reply<TokenView>) = 0;
};

}  // namespace sleight::rpc
