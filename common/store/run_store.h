// The run store: the truth of a run. A SQLite database into which every scan's result
// goes once, under its logical key (chain, replica, scan); archives are derived from it.
//
// On disk it is the folder `<archive>.run`, with `store.sqlite` and the lock (run_lock.h) in it.
//
// Invariants
//   1. What committed() has counted survives kill -9 of any process and loss of power.
//   2. A key's first result stays: a doubled or late one changes nothing.
//   3. A store belongs to one request and one results version; every session that writes takes a
//      new epoch, and a writer of an older epoch is refused (fencing).
//   4. Of each replica, the scans from its first, mostly 0, to next_scan-1 are present without a
//      gap, and the state after the last of them; all of a unit becomes visible in one transaction.
//   5. Every row carries a checksum: what a disk or a person changed is refused when it is read.
//   6. On a network disk a commit counts only if the run's lock was still this process's after it.
//   7. A session that ends in order, or by an error, leaves how it ended (sessions.h); one without
//      that runs, or died.
//   8. Events of the run are numbered from 1 without a gap, in the order in which they are put, and
//      each is committed with or after all results that were put before it (told_events.h). A
//      session's end is one of them.
// Thread safety: put, flush and committed may be called from any thread; the rest from one.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/events/run_end.h"
#include "common/plan/unit.h"
#include "common/store/database.h"
#include "common/store/group_commit.h"
#include "common/store/put_events.h"
#include "common/store/run_lock.h"
#include "common/store/scan_rows.h"
#include "common/store/shared_database.h"

namespace sleight::store {

/// Of the tables; a store of another format is refused.
inline constexpr std::int64_t k_store_format = 6;

/// Whose results a store holds.
struct RunIdentity {
  std::string identity_text;    ///< the part of the normalised request that decides the chains
  std::string request_text;     ///< the whole normalised request of this session
  std::string results_version;  ///< of the program: decides whether it may go on
  std::string program_version;  ///< base::version(): for people
  std::uint32_t chains = 0;
};

/// Where a replica goes on.
struct ReplicaProgress {
  plan::ReplicaKey replica;
  std::uint64_t next_scan = 0;
  base::Bytes state;  ///< before next_scan, in the world's encoding
};

class RunStore {
 public:
  /// Opens or makes the store in a folder, under a new epoch. Throws base::Error(conflict) when it
  /// belongs to another request or results version. REQUIRES: the caller holds the folder's
  /// RunLock, which is borrowed;
  /// null only where it is no lease (run_lock.h).
  RunStore(const std::string& folder, const RunIdentity& identity, RunLock* lock = nullptr);
  /// Commits what was put, if it can; failures are not told: flush() first.
  ~RunStore();

  std::uint64_t epoch() const { return epoch_; }

  /// What earlier sessions stored, by replica in order; empty for a new run. Throws base::Error
  /// when the store is damaged, as replay does.
  std::vector<ReplicaProgress> progress();
  /// Visits every stored scan of a replica in order, in batches, for a plan to catch up; records
  /// come without state and outcome. Throws base::Error when what is stored has been changed.
  void replay(plan::ReplicaKey replica, const ReplayVisit& visit);
  /// The same of all replicas, the one that is least far first (scan_rows.h).
  void replay_all(const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                           std::span<const plan::ScanRecord>)>& visit);

  /// Takes a result to be committed soon; throws the failure of an earlier commit: a full disk, or
  /// base::Error(conflict) once another session has taken a newer epoch (fencing).
  void put(plan::UnitResult result);
  /// Returns when all that was put is committed; throws as put does.
  void flush();
  /// How far earlier sessions have told the run's events.
  const ToldFrontier& told() const { return told_; }
  /// Takes events to be numbered and committed soon, after all results that were put before, and
  /// up to which results all is then told. Throws as put does.
  void put(PutEvents events);
  /// Sets what hears of events, with their numbers, as soon as they are committed, in the thread
  /// that commits. On return nothing that was set before is called any more.
  using Told = std::function<void(std::span<const events::RunEvent>)>;
  void on_told(Told told);
  /// Commits what was put and records how the session ended, under the store's epoch whatever
  /// `end.epoch` says; throws as put does. A session that failed is recorded so even where what was
  /// put last can't be committed. Returns the number of the end as an event. Nothing may be put or
  /// flushed afterwards.
  std::uint64_t close(events::RunEnd end);
  /// Scans committed in this session.
  std::uint64_t committed() const;

  /// For readers of this process, in any thread: a connection of their own, which does not see what
  /// isn't committed, or on a network disk the writer's. REQUIRES: it goes before the store does.
  std::shared_ptr<SharedDatabase> to_read();

  static std::string database_path(const std::string& folder) { return folder + "/store.sqlite"; }

 private:
  void refuse_if_lock_is_lost() const;
  void create_or_check(const RunIdentity& identity);
  void take_epoch(const std::optional<std::string>& last, const RunIdentity& identity);
  void read_told();
  void commit(GroupCommit::Group& group);
  void insert_event(Statement& row, const events::RunEvent& event) const;
  void set_told(const ToldFrontier& reached);
  void refuse_if_fenced(Statement& current_epoch) const;
  void set_session(const std::string& end);
  void insert(const plan::UnitResult& result);

  RunLock* lock_;
  std::shared_ptr<SharedDatabase> connection_;
  Database& database_;  ///< the connection's, for turns
  std::uint64_t salt_ = 0;
  std::uint64_t epoch_ = 0;
  std::string program_version_;
  std::uint64_t scans_before_ = 0;
  ToldFrontier told_;             ///< by earlier sessions
  std::uint64_t last_event_ = 0;  ///< number of the last one that is committed
  std::mutex telling_;            ///< of on_told_
  Told on_told_;
  struct Writer;
  std::unique_ptr<Writer> writer_;
};

}  // namespace sleight::store
