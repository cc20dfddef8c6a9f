#include "service/jobs/keeping.h"

#include <algorithm>

#include "common/base/check.h"

namespace sleight::jobs {

void Keeping::add(const Job& job) {
  if (job.remove_at_s) {
    CHECK(said_.emplace(*job.remove_at_s, job.id).second);
  } else {
    CHECK(unsaid_.emplace(job.over_since_s, job.id).second);
    bytes_unsaid_ += job.disk_bytes;
  }
}

void Keeping::remove(const Job& job) {
  if (job.remove_at_s) {
    CHECK_EQ(said_.erase({*job.remove_at_s, job.id}), 1U);
  } else {
    CHECK_EQ(unsaid_.erase({job.over_since_s, job.id}), 1U);
    bytes_unsaid_ -= job.disk_bytes;
  }
}

std::optional<std::pair<JobId, double>> Keeping::next_to_announce(double now_s) const {
  if (unsaid_.empty()) return std::nullopt;
  const auto [over_since_s, job] = *unsaid_.begin();
  const double old_s = over_since_s + options_.keep_s;
  if (bytes_unsaid_ <= options_.keep_bytes && now_s < old_s - options_.announce_s)
    return std::nullopt;
  // Leave the whole time between announcement and deletion, even if the daemon was down or keep_s
  // was reduced.
  const bool is_for_bytes = bytes_unsaid_ > options_.keep_bytes;
  const double earliest_s = now_s + options_.announce_s;
  return std::pair(job, is_for_bytes ? earliest_s : std::max(old_s, earliest_s));
}

std::optional<JobId> Keeping::next_to_delete(double now_s) const {
  if (said_.empty() || said_.begin()->first > now_s) return std::nullopt;
  return said_.begin()->second;
}

std::optional<double> Keeping::next_s() const {
  std::optional<double> next;
  if (!said_.empty()) next = said_.begin()->first;
  if (!unsaid_.empty()) {
    const double old_s = unsaid_.begin()->first + options_.keep_s - options_.announce_s;
    next = next ? std::min(*next, old_s) : old_s;
  }
  return next;
}

}  // namespace sleight::jobs
