#include "service/daemon/feeds.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace sleight::daemon {
namespace {

std::uint64_t wall_us() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

}  // namespace

Feeds::Feeds(const JobFolders& folders, const base::Clock& clock,
             std::function<void(jobs::JobId)> news)
    : folders_(folders), clock_(clock), news_(std::move(news)) {}

Feeds::Held& Feeds::held(jobs::JobId job) {
  const double now_s = clock_.now_s();
  auto at = feeds_.find(job);
  if (at == feeds_.end()) {
    at = feeds_.emplace(job, Held{.feed = JobFeed(folders_.run(job), wall_us())}).first;
    at->second.feed.read(true);
  }
  at->second.used_s = now_s;
  return at->second;
}

const JobFeed& Feeds::of(jobs::JobId job) {
  return held(job).feed;
}

const JobFeed& Feeds::read(jobs::JobId job, bool thoroughly) {
  JobFeed& feed = held(job).feed;
  if (feed.read(thoroughly)) news_(job);
  return feed;
}

void Feeds::watched(jobs::JobId job) {
  held(job).watched_until_s = clock_.now_s() + k_watched_for_s;
}

std::vector<jobs::JobId> Feeds::watched_now() {
  const double now_s = clock_.now_s();
  std::vector<jobs::JobId> watched;
  for (auto at = feeds_.begin(); at != feeds_.end();) {
    const Held& held = at->second;
    if (held.watched_until_s > now_s) {
      watched.push_back(at->first);
      ++at;
    } else if (held.used_s + k_feed_idle_s < now_s) {
      at = feeds_.erase(at);
    } else {
      ++at;
    }
  }
  return watched;
}

double Feeds::watch_every_s() const {
  const double now_s = clock_.now_s();
  const auto count = std::count_if(feeds_.begin(), feeds_.end(), [&](const auto& feed) {
    return feed.second.watched_until_s > now_s;
  });
  return count == 0 ? 0 : std::max(k_watched_s, k_watched_each_s * static_cast<double>(count));
}

}  // namespace sleight::daemon
