// Settings of the machine of jobs, each with its unit and effect. Limits apply per user; 0: no
// limit. Thread safety: values.
#pragma once

#include <cstdint>
#include <map>

#include "service/jobs/job.h"

namespace sleight::jobs {

struct Limits {
  std::uint64_t jobs = 20'000;    ///< that are not over
  std::uint32_t cores = 0;        ///< in use at the same time
  double core_hours_per_day = 0;  ///< refill evenly; can be used at once, plus one slice
  std::uint64_t disk_bytes = 0;   ///< of all its jobs' folders
};

struct Options {
  Limits limits{};  ///< default, for users without their own
  std::map<UserId, Limits> limits_of{};

  // Whose turn it is
  double half_life_s = 3600;  ///< of the core-seconds that a user has had
  /// The core-seconds that a user's running jobs will use within this time count as already used.
  /// Without this rule, two equal users would take turns, each with all cores.
  double horizon_s = 10;
  /// If a user has waited this long and has no running job, the user is next. If a user's
  /// longest-waiting job has waited this long, it precedes the user's other jobs once per
  /// patience_s.
  double patience_s = 3600;

  // When a job makes room
  double slice_s_min = 10;     ///< minimum time with its cores
  double slice_per_cost = 20;  ///< slice, in multiples of the last restart's cost
  double slice_uncommitted_s =
      60;  ///< minimum before the first commit; doubled after each turn without a commit
  double restart_cost_guess_s = 0.5;  ///< until a restart has been measured
  double stop_again_s = 10;           ///< interval of further clean stop requests
  double stop_now_after_s = 600;      ///< after this, the attempt is killed

  // After a death
  double back_off_first_s = 1;  ///< doubled each time
  double back_off_last_s = 300;
  double steady_s = 600;         ///< an attempt that lives this long resets the back-off
  std::uint32_t deaths_max = 5;  ///< consecutive, without a commit: failed

  // Looks at the backend
  double look_after_launch_s = 5;  ///< if no report arrives
  double look_every_s = 30;        ///< if a running job sends no report
  std::uint32_t unbegun_max = 5;   ///< launches of one attempt without a start

  double disk_resume_factor = 1.25;  ///< disk holds end at this times the reserve
  double limit_resume_factor = 0.9;  ///< limit holds end at this times the limit

  // Storage of finished jobs
  double keep_s = 30.0 * 86400;
  std::uint64_t keep_bytes = 200'000'000'000;  ///< of all finished, unpinned jobs
  double announce_s = 3.0 * 86400;             ///< between the announcement and the deletion

  double save_every_s = 60;  ///< interval of saving running jobs' use
};

/// A back-off or a slice is doubled at most this many times.
inline constexpr std::uint32_t k_doublings_max = 20;
/// Places in the queue are counted only up to this number, because counting costs time.
inline constexpr std::uint64_t k_place_max = 100;

}  // namespace sleight::jobs
