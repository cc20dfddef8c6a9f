// The job store of a simulated daemon. Saves are atomic. The store outlives the daemon. Not
// thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "service/jobs/jobs.h"

namespace sleight::jobs::simulated {

class SimStore {
 public:
  void apply(const Save& save) {
    for (const Job& job : save.jobs)
      jobs_[job.id] = job;
    for (const Change& change : save.changes)
      histories_[change.id].push_back(change);
    for (const JobId id : save.erased) {
      jobs_.erase(id);
      histories_.erase(id);
    }
    for (const Usage& usage : save.usages)
      usages_[usage.user] = usage;
    clock_s_ = save.clock_s;
    next_id_ = save.next_id;
  }

  Restored restored() const {
    Restored all{.clock_s = clock_s_, .next_id = next_id_};
    for (const auto& [id, job] : jobs_)
      all.jobs.push_back(job);
    for (const auto& [user, usage] : usages_)
      all.usages.push_back(usage);
    return all;
  }

  const Job* find(JobId id) const {
    const auto found = jobs_.find(id);
    return found == jobs_.end() ? nullptr : &found->second;
  }
  const std::map<JobId, Job>& jobs() const { return jobs_; }
  double clock_s() const { return clock_s_; }

 private:
  std::map<JobId, Job> jobs_;
  std::map<JobId, std::vector<Change>> histories_;
  std::map<UserId, Usage> usages_;
  double clock_s_ = 0;
  std::uint64_t next_id_ = 1;
};

}  // namespace sleight::jobs::simulated
