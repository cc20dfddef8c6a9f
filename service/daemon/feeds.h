// The feeds of jobs (job_feed.h): made when somebody asks, dropped when nobody has for long.
//
// A job's feed is read when its run goes on, often while it is watched. Disks that tell of changes
// don't do so over a network, so a watched run's log is looked at every k_watched_s: an open file
// and its size, a few microseconds.
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

/// A watched run is looked at so often, and less often where there are many.
inline constexpr double k_watched_s = 0.02;
inline constexpr double k_watched_each_s = 0.0002;
/// A job counts as watched so long after somebody asked for its events: a watch without news is
/// answered after 20 s and asked again.
inline constexpr double k_watched_for_s = 30;
/// Feeds of jobs that don't run are dropped so long after they were used.
inline constexpr double k_feed_idle_s = 60;

class Feeds {
 public:
  /// `news` hears of each job whose feed has something new, whoever had it read.
  Feeds(const JobFolders& folders, const base::Clock& clock, std::function<void(jobs::JobId)> news);

  /// The job's, made and read if need be.
  const JobFeed& of(jobs::JobId job);
  /// The same, read now (job_feed.h).
  const JobFeed& read(jobs::JobId job, bool thoroughly);
  /// From now on for k_watched_for_s the job is watched.
  void watched(jobs::JobId job);
  void drop(jobs::JobId job) { feeds_.erase(job); }

  /// Those that are watched now; drops what nobody used.
  std::vector<jobs::JobId> watched_now();
  /// How long until the next look at them; 0: none is watched.
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
