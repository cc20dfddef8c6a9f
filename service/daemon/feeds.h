// The feeds of jobs (job_feed.h): created on demand, dropped after a time without use.
//
// A job's feed reads its run's events while the run is active, and frequently while somebody
// watches the job. Network disks don't notify of changes, so the daemon polls a watched run's log
// every k_watched_s. A poll checks an open file's size, which takes a few microseconds.
//
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>

#include "common/base/clock.h"
#include "service/daemon/job_feed.h"
#include "service/daemon/job_folder.h"

namespace sleight::daemon {

/// Interval of polls of watched runs: k_watched_each_s per watched run, but at least k_watched_s.
inline constexpr double k_watched_s = 0.02;
inline constexpr double k_watched_each_s = 0.0002;
/// A job counts as watched for this time after a request for its events. A watch without news
/// returns after 20 s, and the client repeats it.
inline constexpr double k_watched_for_s = 30;
/// Feeds of jobs that don't run are dropped this long after their last use.
inline constexpr double k_feed_idle_s = 60;

class Feeds {
 public:
  /// `news` is called for each job whose feed has found new events, whichever function read them.
  Feeds(const JobFolders& folders, const base::Clock& clock, std::function<void(jobs::JobId)> news);

  /// Returns the job's feed, which is created and read on first use.
  const JobFeed& of(jobs::JobId job);
  /// Returns the job's feed after reading it again (job_feed.h).
  const JobFeed& read(jobs::JobId job, bool thoroughly);
  /// Marks the job as watched for k_watched_for_s.
  void watched(jobs::JobId job);
  void drop(jobs::JobId job) { feeds_.erase(job); }

  /// Returns the watched jobs; drops unused feeds.
  std::vector<jobs::JobId> watched_now();
  /// Returns the interval of polls of the watched jobs. 0: no job is watched.
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
