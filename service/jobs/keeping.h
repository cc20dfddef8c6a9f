// How long finished jobs are stored. An unpinned job is deleted keep_s after its end. If finished
// jobs use more than keep_bytes, the oldest jobs are deleted earlier. The announcement of
// a deletion precedes it by announce_s. Pinning, extending or resuming a job withdraws the
// announcement.
//
// All times are service times. So jobs don't age while no daemon is up, nor when the wall clock
// jumps.
//
// Thread safety: none.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <utility>

#include "service/jobs/job.h"
#include "service/jobs/options.h"

namespace sleight::jobs {

class Keeping {
 public:
  /// Borrows the options.
  explicit Keeping(const Options& options) : options_(options) {}

  /// Adds a job that is over and not pinned. REQUIRES: before the job's values change, the caller
  /// removes it.
  void add(const Job& job);
  void remove(const Job& job);

  /// Returns the next job to announce, and the time of its deletion.
  std::optional<std::pair<JobId, double>> next_to_announce(double now_s) const;
  /// Returns the next job to delete now.
  std::optional<JobId> next_to_delete(double now_s) const;
  /// If nothing changes, next_to_announce() or next_to_delete() returns a job at this time.
  std::optional<double> next_s() const;

 private:
  const Options& options_;
  std::set<std::pair<double, JobId>> unsaid_;  ///< (over since, job)
  std::set<std::pair<double, JobId>> said_;    ///< (to be deleted at, job)
  std::uint64_t bytes_unsaid_ = 0;
};

}  // namespace sleight::jobs
