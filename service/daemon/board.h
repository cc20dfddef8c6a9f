// The board has the durable state of all jobs. Clients see only this state. The machine of jobs may
// be ahead of the board by changes that are still being saved. Thread safety: one thread.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "service/daemon/job_store.h"
#include "service/jobs/job.h"

namespace sleight::daemon {

/// A job and what is known about its request, without the request's text.
struct Posted {
  jobs::Job job{};
  StoredRequest asked{};      ///< without its text
  std::uint64_t changes = 0;  ///< number of its newest change
};

class Board {
 public:
  Board() = default;
  explicit Board(const StoredJobs& stored);

  /// Applies a durable save. Returns the changed jobs.
  std::vector<jobs::JobId> take(const Save& save);

  /// Null: the job doesn't exist or is being deleted.
  const Posted* find(jobs::JobId job) const;
  const std::map<jobs::JobId, Posted>& all() const { return posted_; }
  /// Returns the group's jobs, in order. Empty: there is no such group.
  std::vector<jobs::JobId> group(jobs::GroupId group) const;
  /// Returns whether a job ever had this id.
  bool was_there(jobs::JobId job) const { return job.value > 0 && job.value < next_id_; }

 private:
  std::map<jobs::JobId, Posted> posted_;
  std::map<jobs::GroupId, std::set<jobs::JobId>> groups_;
  std::uint64_t next_id_ = 1;
};

}  // namespace sleight::daemon
