// The jobs as they are durable: what people are told. The machine of jobs may be ahead by what is
// being saved.
//
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "service/daemon/job_store.h"
#include "service/jobs/job.h"

namespace sleight::daemon {

/// A job, and what is known of its request beside the text.
struct Posted {
  jobs::Job job{};
  StoredRequest asked{};      ///< without its text
  std::uint64_t changes = 0;  ///< number of its newest change
};

class Board {
 public:
  Board() = default;
  explicit Board(const StoredJobs& stored);

  /// What has become durable. Returns the jobs that it is about.
  std::vector<jobs::JobId> take(const Save& save);

  /// Null: there is no such job, or it is being deleted.
  const Posted* find(jobs::JobId job) const;
  const std::map<jobs::JobId, Posted>& all() const { return posted_; }
  /// In order; empty where there is no such group.
  std::vector<jobs::JobId> group(jobs::GroupId group) const;
  /// Whether an id was given to a job once.
  bool was_there(jobs::JobId job) const { return job.value > 0 && job.value < next_id_; }

 private:
  std::map<jobs::JobId, Posted> posted_;
  std::map<jobs::GroupId, std::set<jobs::JobId>> groups_;
  std::uint64_t next_id_ = 1;
};

}  // namespace sleight::daemon
