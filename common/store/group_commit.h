// Commits results in groups on a thread of its own, so that computing never waits for the disk: a
// group is closed after 50 ms or 4 MB, whichever comes first.
//
// Invariants
//   1. Results are committed in the order in which they were put, and events with or after all
//      results that were put before them.
//   2. committed() counts scans, not prior draws, whose commit has returned: only these may be
//   reported as done.
//   3. After a commit has failed nothing more is written; the failure comes out of the next put or
//      flush, in the caller's thread.
//   4. The thread starts with the first result: until then the process may fork safely.
// Thread-safe. A result lost before its commit is computed again, to the same bits.
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

/// A group waits this long for company.
inline constexpr double k_group_wait_s = 0.050;
/// A group of this size is committed at once.
inline constexpr std::size_t k_group_bytes = 4U << 20U;
/// put blocks while this much waits for the disk: a stalled disk must not fill the memory.
inline constexpr std::size_t k_queue_bytes_max = 64U << 20U;

class GroupCommit {
 public:
  /// What is committed together.
  struct Group {
    std::vector<plan::UnitResult> results;
    std::vector<PutEvents> events;
  };
  using Commit = std::function<void(Group&)>;

  /// `commit` makes a group durable or throws; it is called from one thread.
  explicit GroupCommit(Commit commit);
  /// As end().
  ~GroupCommit();
  GroupCommit(const GroupCommit&) = delete;
  GroupCommit& operator=(const GroupCommit&) = delete;

  /// Commits what was put, but can't report a failure: call flush before. When it returns, `commit`
  /// is not called any more. Nothing may be put afterwards.
  void end();

  void put(plan::UnitResult result);
  void put(PutEvents events);
  /// Returns when everything put so far is committed.
  void flush();
  /// Scans committed since construction.
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
  std::uint64_t put_ = 0;  ///< results and lots of events
  std::uint64_t committed_ = 0;
  std::uint64_t committed_scans_ = 0;
  std::size_t flushing_ = 0;  ///< callers that wait in flush
  bool ending_ = false;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace sleight::store
