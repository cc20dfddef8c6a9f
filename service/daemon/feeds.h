// The feeds of jobs (job_feed.h). A feed is created on demand and dropped after a time without use.
//
// While a run is active, its job's feed reads the run's events. While somebody watches the job, the
// feed reads more often. The daemon polls a watched run's log every k_watched_s, because network
// disks don't notify it of changes. A poll checks an open file's size, which takes a few
// microseconds.
//
// Thread safety: one thread.
#pragma once

#include <functional>
#include <map>

#include "common/base/clock.h"
#include "service/daemon/job_feed.h"
#include "service/daemon/job_folder.h"

namespace sleight::daemon {

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
  /// Returns the job's feed after reading it again (job_feed.h).
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
