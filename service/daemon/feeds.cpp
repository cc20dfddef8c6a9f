#include "service/daemon/feeds.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/base/error.h"

namespace sleight::daemon {
namespace {

/// Maximum numbered events per reading.
constexpr std::size_t k_read_max = 1000;

std::uint64_t wall_us() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

}  // namespace

JobFeed::JobFeed(std::string run_folder, std::uint64_t first_mark)
    : folder_(std::move(run_folder)), told_(folder_), mark_(first_mark) {}

bool JobFeed::read(bool thoroughly) {
  bool is_new = false;
  trouble_.clear();
  try {
    while (true) {
      std::vector<events::RunEvent> events =
          thoroughly ? told_.rest(k_read_max) : told_.next(k_read_max);
      const auto numbered = std::count_if(events.begin(), events.end(),
                                          [](const auto& event) { return event.number > 0; });
      is_new = is_new || !events.empty();
      for (events::RunEvent& event : events)
        take(std::move(event));
      if (static_cast<std::size_t>(numbered) < k_read_max) return is_new;
    }
  } catch (const base::Error& failure) {
    // The run has no store yet, or the disk failed. The next reading tries again.
    trouble_ = failure.what();
  }
  return is_new;
}

void JobFeed::take(events::RunEvent event) {
  if (const auto* progress = std::get_if<events::Progress>(&event.what)) progress_ = *progress;
  if (event.number == 0) {
    Marked& newest = newest_[std::string(events::kind_of(event))];
    newest = {.mark = ++mark_, .event = std::move(event)};
    return;
  }
  last_number_ = event.number;
  held_.push_back(std::move(event));
  if (held_.size() > k_held_max) held_.pop_front();
}

JobFeed::News JobFeed::after(std::uint64_t after, std::uint64_t mark, std::size_t count_max) const {
  News news{.mark = mark_};
  if (after < last_number_) {
    const bool is_held = !held_.empty() && held_.front().number <= after + 1;
    if (is_held) {
      const auto begin =
          held_.begin() + static_cast<std::ptrdiff_t>(after + 1 - held_.front().number);
      const auto count =
          std::min<std::ptrdiff_t>(held_.end() - begin, static_cast<std::ptrdiff_t>(count_max));
      news.events.assign(begin, begin + count);
    } else {
      for (events::RunEvent& event : store::events_told(folder_, after + 1, count_max))
        if (event.number > 0) news.events.push_back(std::move(event));
    }
    news.is_all = !news.events.empty() && news.events.back().number == last_number_;
  }
  // If a mark is above this feed's mark, it comes from another daemon.
  const std::uint64_t covered = mark > mark_ ? 0 : mark;
  for (const auto& [kind, marked] : newest_)
    if (marked.mark > covered) news.events.push_back(marked.event);
  return news;
}

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
