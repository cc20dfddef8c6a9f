#include "service/jobs/queue.h"

#include "common/base/check.h"
#include "service/jobs/options.h"

namespace sleight::jobs {

void Queue::add(const Job& job) {
  const Entry entry{.user = job.user,
                    .minus_priority = -std::int64_t{job.priority},
                    .since_s = job.queued_since_s};
  CHECK(entries_.emplace(job.id, entry).second);
  OfUser& user = users_[job.user];
  user.order.emplace(entry.minus_priority, job.id);
  user.by_wait.emplace(entry.since_s, job.id);
}

bool Queue::remove(JobId job) {
  const auto found = entries_.find(job);
  if (found == entries_.end()) return false;
  const Entry& entry = found->second;
  const auto user = users_.find(entry.user);
  user->second.order.erase({entry.minus_priority, job});
  user->second.by_wait.erase({entry.since_s, job});
  if (user->second.order.empty()) users_.erase(user);
  entries_.erase(found);
  return true;
}

std::uint64_t Queue::rank(JobId job) const {
  const Entry& entry = entries_.at(job);
  const OfUser& user = users_.at(entry.user);
  std::uint64_t rank = 0;
  for (const auto& [minus_priority, other] : user.order) {
    if (++rank == k_place_max || other == job) break;
  }
  return rank;
}

}  // namespace sleight::jobs
