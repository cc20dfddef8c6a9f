// The feeds of jobs. A feed caches a job's newest run events: lists of jobs show progress, and
// watchers get all kinds of events. A feed is created on demand and dropped after a time without
// use.
//
// The run writes its events into its folder (common/store/told_events.h), and the feed follows
// them. If a watcher needs older events than the feed holds, they are read from the folder. So the
// feed's size is bounded, and nothing depends on its contents.
//
// Each unnumbered event gets a mark. So a watcher gets the newest event of each kind only once. A
// feed's first mark is the wall clock in microseconds. So if a feed is created later, even by
// another daemon, its marks are usually higher. For an unknown mark, a feed returns the newest
// event of every kind.
//
// While a run is active, its job's feed reads the run's events. While somebody watches the job, the
// feed reads more often. The daemon polls a watched run's log every k_watched_s, because network
// disks don't notify it of changes. A poll checks an open file's size, which takes a few
// microseconds.
//
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/events/run_event.h"
#include "common/store/told_events.h"
#include "service/daemon/job_folder.h"

namespace sleight::daemon {

class JobFeed {
 public:
  /// Maximum numbered events held.
  static constexpr std::size_t k_held_max = 1024;

  JobFeed(std::string run_folder, std::uint64_t first_mark);

  /// Reads new events and returns whether there were any. `thoroughly` also reads the store,
  /// because the log may lack events. If the folder can't be read, there are no new events.
  bool read(bool thoroughly);

  /// Contains at most `count_max` numbered events, from `after` + 1 on. If a kind's newest
  /// unnumbered event is newer than `mark`, it follows.
  struct News {
    std::vector<events::RunEvent> events{};
    std::uint64_t mark = 0;
    bool is_all = true;  ///< no numbered event is left out
  };
  News after(std::uint64_t after, std::uint64_t mark, std::size_t count_max) const;

  const std::optional<events::Progress>& progress() const { return progress_; }
  /// Why the last reading failed. Empty: it didn't.
  const std::string& trouble() const { return trouble_; }

 private:
  struct Marked {
    std::uint64_t mark = 0;
    events::RunEvent event;
  };
  void take(events::RunEvent event);

  std::string folder_;
  store::ToldEvents told_;
  std::deque<events::RunEvent> held_{};                  ///< numbered, consecutive, the newest last
  std::map<std::string, Marked, std::less<>> newest_{};  ///< by kind
  std::optional<events::Progress> progress_{};
  std::uint64_t last_number_ = 0;  ///< of the newest numbered event; 0: none
  std::string trouble_{};
  std::uint64_t mark_;
};

/// Interval at which watched runs are polled: k_watched_each_s times the number of watched runs,
/// but at least k_watched_s.
inline constexpr double k_watched_s = 0.02;
inline constexpr double k_watched_each_s = 0.0002;
/// After a request for its events, a job counts as watched for this time. If there is no news for
/// 20 s, the request returns and the client repeats it.
inline constexpr double k_watched_for_s = 30;
/// If a job doesn't run, its feed is dropped this long after its last use.
inline constexpr double k_feed_idle_s = 60;

class Feeds {
 public:
  /// `news` is called for a job when its feed has found new events, whichever function read them.
  Feeds(const JobFolders& folders, const base::Clock& clock, std::function<void(jobs::JobId)> news);

  /// Returns the job's feed. The first call creates and reads the feed.
  const JobFeed& of(jobs::JobId job);
  /// Returns the job's feed after reading it again.
  const JobFeed& read(jobs::JobId job, bool thoroughly);
  /// Marks the job as watched for k_watched_for_s.
  void watched(jobs::JobId job);
  void drop(jobs::JobId job) { feeds_.erase(job); }

  /// Returns the watched jobs; drops unused feeds.
  std::vector<jobs::JobId> watched_now();
  /// Returns the interval at which watched jobs are polled. 0: no job is watched.
  double watch_every_s() const;

 private:
  struct Held {
    JobFeed feed;
    double used_s = 0;
    double watched_until_s = 0;
  };
  Held& held(jobs::JobId job);

  const JobFolders& folders_;
  const base::Clock& clock_;
  std::function<void(jobs::JobId)> news_;
  std::map<jobs::JobId, Held> feeds_;
};

}  // namespace sleight::daemon
