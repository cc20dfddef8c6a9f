// The run store: a SQLite database that contains every scan's result once. Its key is logical:
// (chain, replica, scan). Archives are derived from it.
//
// On disk the store is the folder `<archive>.run` with `store.sqlite` and the lock (run_lock.h).
//
// Invariants
//   1. The scans counted by committed() survive kill -9 of any process and power loss.
//   2. A key's first result stays: a doubled or late result changes nothing.
//   3. A store belongs to one request and one results version. Every session that writes takes a
//      new epoch, and writers of older epochs are refused (fencing).
//   4. A replica's scans are present without gaps, from its first (usually 0) to next_scan-1. The
//      state after the last of these scans is present too. All scans of a unit become visible in
//      one transaction.
//   5. Every row has a checksum. Reading refuses a row that a disk or a person changed.
//   6. On a network disk a commit counts only if this process still holds the run's lock
//      afterwards.
//   7. If a session ends cleanly or by an error, it records how it ended (sessions.h). A session
//      without that record is running or died.
//   8. Events are numbered from 1 without gaps, in the order of put(). An event is never committed
//      before the results that were put before it (told_events.h). A session's end is an event.
// Thread safety: `put`, `flush` and `committed` may be called from any thread, and all other
// functions from one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
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

/// Version of the tables. Stores of other versions are refused.
inline constexpr std::int64_t k_store_format = 6;

struct RunIdentity {
  std::string identity_text;    ///< the part of the normalised request that determines the chains
  std::string request_text;     ///< this session's whole normalised request
  std::string results_version;  ///< a different version can't resume the run
  std::string program_version;  ///< base::version(), for display
  std::uint32_t chains = 0;
};

/// The scan and the state from which a replica continues.
struct ReplicaProgress {
  plan::ReplicaKey replica;
  std::uint64_t next_scan = 0;
  base::Bytes state;  ///< before next_scan, in the world's encoding
};

class RunStore {
 public:
  /// Opens or creates the store in a folder, with a new epoch. Throws base::Error(conflict) if the
  /// store belongs to another request or results version. Borrows `lock`, which may be null if the
  /// folder needs no lease (run_lock.h). REQUIRES: the caller holds the folder's RunLock.
  RunStore(const std::string& folder, const RunIdentity& identity, RunLock* lock = nullptr);
  /// Commits pending results if possible. Doesn't report failures, so call flush() first.
  ~RunStore();

  std::uint64_t epoch() const { return epoch_; }

  /// Returns what earlier sessions stored, ordered by replica; empty for a new run. Throws
  /// base::Error if the store is damaged. So does replay.
  std::vector<ReplicaProgress> progress();
  /// Visits all stored scans of a replica, in order and in batches. A plan catches up by them.
  /// Records lack state and outcome. Throws base::Error if the stored rows were changed.
  void replay(plan::ReplicaKey replica, const ReplayVisit& visit);
  /// Visits the scans of all replicas. The replica that is furthest behind is visited first
  /// (scan_rows.h).
  void replay_all(const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                           std::span<const plan::ScanRecord>)>& visit);

  /// Queues a result for committing. If an earlier commit failed, throws its failure, such as a
  /// full disk. If another session has taken a newer epoch (fencing), the failure is
  /// base::Error(conflict).
  void put(plan::UnitResult result);
  /// Waits until all queued results are committed. Throws like put.
  void flush();
  /// Returns the progress of event numbering in earlier sessions.
  const ToldFrontier& told() const { return told_; }
  /// Queues events, and the frontier that these events reach. The events are numbered and committed
  /// after all results that were put before. Throws like put.
  void put(PutEvents events);
  /// Sets the listener. Right after a commit, the committing thread passes the numbered events to
  /// the listener. Once on_told returns, the previous listener is not called any more.
  using Told = std::function<void(std::span<const events::RunEvent>)>;
  void on_told(Told told);
  /// Commits queued results and records how the session ended. The record has the store's epoch;
  /// `end.epoch` is ignored. Throws like put. A failure is recorded even if the last results can't
  /// be committed. Returns the event number of the end. REQUIRES: no put or flush follows.
  std::uint64_t close(events::RunEnd end);
  std::uint64_t committed() const;

  /// Returns a database for this process's readers, in any thread. Usually the database is a
  /// separate connection, which sees only committed rows. On a network disk, the database is the
  /// writer's connection. REQUIRES: the database is released before the store is destroyed.
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
  Database& database_;  ///< the connection's database, used within turns
  std::uint64_t salt_ = 0;
  std::uint64_t epoch_ = 0;
  std::string program_version_;
  std::uint64_t scans_before_ = 0;
  ToldFrontier told_;  ///< by earlier sessions
  std::uint64_t last_event_ = 0;
  std::mutex telling_;  ///< guards on_told_
  Told on_told_;
  struct Writer;
  std::unique_ptr<Writer> writer_;
};

}  // namespace sleight::store
