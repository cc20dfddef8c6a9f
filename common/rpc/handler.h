// A service's side of the calls, which the daemon implements.
//
// The server (server.h) decodes a call, checks it against the limits of service.h and hands it to
// the handler, on the loop's thread. Each call comes with a Reply, which may be answered at once,
// or kept and answered later: when the change is durable, say.
//
// Watching is pulled. The server asks for what a watcher lacks, and answers as soon as there is
// something; the daemon says Server::news(job) when there may be more. The watcher asks again when
// it has read the answer. So a slow watcher gets all that is numbered and only the newest of what
// is not, and nothing waits for it in the service.
//
// Invariants
//   1. A Reply is answered at most once; one that is dropped refuses the call as a bug of ours.
//   2. A handler may be told of anything that a client can write: ids that don't exist, texts that
//      are no request. Sizes and counts are within service.h's limits, and enumerations in requests
//      are never `unknown`.
//   3. A caller's token allows the call (service_calls.cpp has the table).
//   4. The user of a call is the uid that the kernel says the peer has; over TCP the one of the
//      token that the peer has shown.
//
// Thread safety: all on the loop's thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.h"
#include "common/rpc/service.h"

namespace sleight::rpc {

struct Caller {
  std::uint32_t user = 0;  ///< uid
  std::int64_t pid = 0;    ///< for logs; never to decide by; 0: of another machine
  std::string address{};   ///< of a peer over TCP, "192.0.2.7:50312"; empty: of this machine
  std::string token_id{};  ///< that it was let in by; empty: a Unix socket's
  Scopes scopes = Scopes::all();
  std::uint32_t token_jobs_max = 0;   ///< as in TokenAsk
  std::uint32_t token_cores_max = 0;  ///< likewise
};

struct Nothing {
  bool operator==(const Nothing&) const = default;
};

/// An answer that is owed. Moves, does not copy.
template <class T>
class Reply {
 public:
  using Answer = base::Result<T, Refusal>;
  using Send = std::function<void(Answer)>;

  /// `send` is called once, at the latest when the reply is dropped.
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

  /// REQUIRES: was not answered before.
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

/// A line of the audit log.
struct AuditLine {
  std::string call{};
  std::string of{};       ///< what was asked for: "17", "g5"; empty: nothing to name
  std::string outcome{};  ///< "done", or why not
  std::string made{};     ///< what came of it: "17 18"; empty: nothing to name
};

/// Hears of each audited call when it is answered.
using Audit = std::function<void(const Caller&, const AuditLine&)>;

/// Who lets peers in over TCP.
class Authority {
 public:
  virtual ~Authority() = default;
  /// Whose the token is. The refusal tells nobody what is wrong with it.
  virtual base::Result<Caller, Refusal> login(const std::string& token,
                                              const std::string& address) = 0;
  /// Whether a session that was let in may go on: its token is neither revoked nor expired. Asked
  /// at each call, and some times a second.
  virtual bool lets_go_on(const Caller& caller) = 0;
};

/// What a watcher of a job lacks.
struct Batch {
  std::vector<StateChange> changes{};  ///< consecutive, from WatchPoint::change + 1 on
  /// Numbered ones consecutive from WatchPoint::event + 1 on; of the others at most the newest of
  /// each kind that `mark` does not cover, anywhere between them.
  std::vector<events::RunEvent> events{};
  std::uint64_t mark = 0;  ///< covers what is unnumbered here
  /// The job is settled, and with this batch the watcher has all that is numbered. A batch that is
  /// cut short for its size is not.
  bool settled = false;

  bool empty() const { return changes.empty() && events.empty() && !settled; }
};

/// A file that is being fetched. Lives until the client lets go of it or leaves.
class Source {
 public:
  virtual ~Source() = default;
  /// The same at every call.
  virtual FileView view() const = 0;
  /// Answers `bytes` bytes from `offset` on, all within the file's size; bytes <=
  /// k_piece_bytes_max. The file's content does not change.
  virtual void read(std::uint64_t offset, std::size_t bytes, Reply<base::Bytes> reply) = 0;
};

/// A file on the disk, read where it is asked for; it is held open, so it may be replaced or
/// removed meanwhile. `sha256` is its digest. Throws base::Error where it can't be opened.
std::unique_ptr<Source> open_source(const std::string& path, std::string name, std::string sha256);

struct Fetched {
  std::vector<std::unique_ptr<Source>> files{};  ///< at most k_fetch_files_max, by name
  bool has_more = false;                         ///< ask again with `after` of the last name
};

class Handler {
 public:
  virtual ~Handler() = default;

  virtual void submit(const Caller&, Submission, Reply<Submitted>) = 0;
  virtual void list(const Caller&, ListAsk, Reply<JobPage>) = 0;
  /// With its history.
  virtual void status(const Caller&, JobId, Reply<JobView>) = 0;
  /// What a watcher lacks, at most `events_max` events; empty where it lacks nothing. Asked often:
  /// an empty answer must cost little.
  virtual base::Result<Batch, Refusal> events_after(const Caller&, const WatchPoint&,
                                                    std::size_t events_max) = 0;
  virtual void logs(const Caller&, LogAsk, Reply<LogPiece>) = 0;

  virtual void change(const Caller&, ChangeAsk, Reply<std::vector<Touched>>) = 0;
  virtual void fetch(const Caller&, FetchAsk, Reply<Fetched>) = 0;

  /// The server fills in connections and watchers.
  virtual void info(const Caller&, Reply<ServerView>) = 0;
  /// Starts nothing more and stops what runs in order; answered at once.
  virtual void drain(const Caller&, Reply<Nothing>) = 0;
  /// Ends the daemon; jobs run on. Answered before it ends.
  virtual void stop(const Caller&, Reply<Nothing>) = 0;

  virtual void create_token(const Caller&, TokenAsk, Reply<TokenView>) = 0;
  virtual void list_tokens(const Caller&, Reply<std::vector<TokenView>>) = 0;
  virtual void revoke_token(const Caller&, std::string id, Reply<TokenView>) = 0;
};

}  // namespace sleight::rpc
