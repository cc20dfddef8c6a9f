// Commits results in groups on a separate thread, so that computing never waits for the disk. A
// group is closed after 50 ms or at 4 MB, whichever comes first.
//
// Invariants
//   1. Results are committed in the order of put(). An event is never committed earlier than the
//      results that were put before it.
//   2. committed() counts scans whose commit has returned. Prior draws don't count. Only committed
//      scans may be reported as done.
//   3. After a failed commit nothing more is written. The next put() or flush() throws the failure.
//   4. The thread starts with the first put(). Before the first put(), the process may fork safely.
// Thread-safe. Results lost before their commit are computed again, with the same bits.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "common/plan/unit.h"
#include "common/store/put_events.h"

namespace sleight::store {

/// How long a group waits for more entries.
inline constexpr double k_group_wait_s = 0.050;
/// A group of at least this size is committed at once.
inline constexpr std::size_t k_group_bytes = 4U << 20U;
/// If the queue has at least this size, put() blocks. So a stalled disk does not fill the memory.
inline constexpr std::size_t k_queue_bytes_max = 64U << 20U;

class GroupCommit {
 public:
  struct Group {
    std::vector<plan::UnitResult> results;
    std::vector<PutEvents> events;
  };
  using Commit = std::function<void(Group&)>;

  /// `commit` makes a group durable or throws. Only one thread calls `commit`.
  explicit GroupCommit(Commit commit);
  /// Like end().
  ~GroupCommit();
  GroupCommit(const GroupCommit&) = delete;
  GroupCommit& operator=(const GroupCommit&) = delete;

  /// Commits pending results. Doesn't report failures, so call flush() first. Afterwards `commit`
  /// is not called any more. REQUIRES: no put() follows.
  void end();

  void put(plan::UnitResult result);
  void put(PutEvents events);
  /// Waits until everything put so far is committed.
  void flush();
  std::uint64_t committed() const;

 private:
  template <class T>
  void put_into(std::vector<T> Group::*part, T what);
  void work();
  void rethrow_failure() const;

  Commit commit_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Group queue_;
  std::size_t queue_bytes_ = 0;
  std::uint64_t put_ = 0;  ///< number of put() calls
  std::uint64_t committed_ = 0;
  std::uint64_t committed_scans_ = 0;
  std::size_t flushing_ = 0;  ///< callers waiting in flush
  bool ending_ = false;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace sleight::store
