#include "service/daemon/board.h"

#include <utility>

namespace sleight::daemon {

Board::Board(const StoredJobs& stored) : next_id_(stored.next_id) {
  for (const jobs::Job& job : stored.jobs) {
    Posted& posted = posted_[job.id];
    posted.job = job;
    if (const auto count = stored.change_counts.find(job.id); count != stored.change_counts.end())
      posted.changes = count->second;
    if (job.group.value > 0) groups_[job.group].insert(job.id);
  }
  for (const StoredRequest& request : stored.requests) {
    if (const auto at = posted_.find(request.job); at != posted_.end()) at->second.asked = request;
  }
}

std::vector<jobs::JobId> Board::take(const Save& save) {
  std::set<jobs::JobId> touched;
  for (const jobs::Job& job : save.jobs.jobs) {
    posted_[job.id].job = job;
    if (job.group.value > 0) groups_[job.group].insert(job.id);
    touched.insert(job.id);
  }
  for (const jobs::Change& change : save.jobs.changes) {
    ++posted_[change.id].changes;
    touched.insert(change.id);
  }
  for (const StoredRequest& request : save.requests) {
    StoredRequest asked = request;
    asked.text.clear();
    posted_[request.job].asked = std::move(asked);
  }
  for (const jobs::JobId id : save.jobs.erased) {
    const auto at = posted_.find(id);
    if (at == posted_.end()) continue;
    const jobs::GroupId group = at->second.job.group;
    if (const auto of = groups_.find(group); of != groups_.end()) {
      of->second.erase(id);
      if (of->second.empty()) groups_.erase(of);
    }
    posted_.erase(at);
    touched.insert(id);
  }
  next_id_ = save.jobs.next_id;
  return {touched.begin(), touched.end()};
}

const Posted* Board::find(jobs::JobId job) const {
  const auto at = posted_.find(job);
  return at == posted_.end() || at->second.job.is_leaving ? nullptr : &at->second;
}

std::vector<jobs::JobId> Board::group(jobs::GroupId group) const {
  std::vector<jobs::JobId> jobs;
  const auto at = groups_.find(group);
  if (at == groups_.end()) return jobs;
  for (const jobs::JobId id : at->second)
    if (find(id) != nullptr) jobs.push_back(id);
  return jobs;
}

}  // namespace sleight::daemon
