// Goal: if there are new events, watchers get one notification, even if another reader reads the
// events first.
#include "service/daemon/feeds.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/events/event_log.h"

namespace sleight::daemon {
namespace {

constexpr jobs::JobId k_watched_job{3};

TEST(Feeds, TellOfNewsWhoeverReadsThem) {
  std::string form = (std::filesystem::temp_directory_path() / "sleight-feeds-XXXXXX").string();
  const std::string state = ::mkdtemp(form.data());
  const JobFolders folders(state);
  std::filesystem::create_directories(folders.run(k_watched_job));
  events::EventLog log(folders.run(k_watched_job));
  const base::ManualClock clock;
  std::vector<jobs::JobId> news;
  Feeds feeds(folders, clock, [&](jobs::JobId job) { news.push_back(job); });
  const auto numbered = [](const JobFeed& feed) { return feed.after(0, 0, 10).events.size(); };
  for (const bool thoroughly : {false, true}) {
    feeds.watched(k_watched_job);
    log.append({.number = numbered(feeds.of(k_watched_job)) + 1,
                .what = events::Solution{.nth = 1, .in_proportion = true}});
    const std::size_t before = news.size();
    // This read is for a report of the run's progress, not for the watchers.
    EXPECT_EQ(numbered(feeds.read(k_watched_job, thoroughly)), thoroughly ? 2U : 1U);
    EXPECT_EQ(news.size(), before + 1);
    // A later read for the watchers finds nothing new.
    feeds.read(k_watched_job, false);
    EXPECT_EQ(news.size(), before + 1);
  }
  EXPECT_EQ(news, (std::vector<jobs::JobId>{k_watched_job, k_watched_job}));
  std::filesystem::remove_all(state);
}

}  // namespace
}  // namespace sleight::daemon
