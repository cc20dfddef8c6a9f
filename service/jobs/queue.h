// Queue of the jobs that could start now. Each user's jobs are separate. One user's jobs are
// ordered by priority (highest first), then by age. The user's longest-waiting job can also be
// looked up. Thread safety: none.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "service/jobs/job.h"

namespace sleight::jobs {

class Queue {
 public:
  struct OfUser {
    std::set<std::pair<std::int64_t, JobId>> order;  ///< (-priority, job)
    std::set<std::pair<double, JobId>> by_wait;      ///< (queued since, job)
    JobId first() const { return order.begin()->second; }
    std::pair<double, JobId> longest() const { return *by_wait.begin(); }
  };

  /// REQUIRES: the job isn't in the queue.
  void add(const Job& job);
  /// Returns whether the job was in the queue.
  bool remove(JobId job);
  bool has(JobId job) const { return entries_.contains(job); }
  bool empty() const { return entries_.empty(); }
  std::size_t size() const { return entries_.size(); }
  const std::map<UserId, OfUser>& users() const { return users_; }
  /// Returns the job's position among the jobs of its user, from 1 to k_place_max. REQUIRES: the
  /// job is in the queue.
  std::uint64_t rank(JobId job) const;

 private:
  struct Entry {
    UserId user;
    std::int64_t minus_priority = 0;
    double since_s = 0;
  };
  std::map<JobId, Entry> entries_;
  std::map<UserId, OfUser> users_;
};

}  // namespace sleight::jobs
