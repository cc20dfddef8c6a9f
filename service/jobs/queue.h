// The queue: jobs that could start now, by user. Among the jobs of one user the highest priority
// comes first, then the oldest; beside it stands the one that has waited longest.
//
// Thread safety: none.
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

  /// REQUIRES: it isn't there.
  void add(const Job& job);
  /// Whether it was there.
  bool remove(JobId job);
  bool has(JobId job) const { return entries_.contains(job); }
  bool empty() const { return entries_.empty(); }
  std::size_t size() const { return entries_.size(); }
  /// Those with jobs.
  const std::map<UserId, OfUser>& users() const { return users_; }
  /// From 1, k_place_max at most. REQUIRES: it is there.
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
