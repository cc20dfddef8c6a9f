// How long finished jobs are kept. One is deleted when it has been over for keep_s, or when those
// that are over hold more than keep_bytes, the oldest first; but not while it is pinned, and not
// before announce_s after that was said. To pin, extend or resume one takes what was said back.
//
// Time is service time: while no daemon is up, and when the wall clock jumps, nothing grows old.
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

  /// A job that is over and not pinned, as it is; before it changes it is taken out.
  void add(const Job& job);
  void remove(const Job& job);

  /// The next job to say it of, with the time at which it is to be deleted.
  std::optional<std::pair<JobId, double>> next_to_announce(double now_s) const;
  /// The next one to delete now.
  std::optional<JobId> next_to_delete(double now_s) const;
  /// When one of these has something to say, if nothing changes.
  std::optional<double> next_s() const;

 private:
  const Options& options_;
  std::set<std::pair<double, JobId>> unsaid_;  ///< (over since, job)
  std::set<std::pair<double, JobId>> said_;    ///< (to be deleted at, job)
  std::uint64_t bytes_unsaid_ = 0;
};

}  // namespace sleight::jobs
