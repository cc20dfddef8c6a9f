// The settings of the machine of jobs, each with its unit and what it decides. Limits are of a
// user; 0 is none.
//
// Thread safety: values.
#pragma once

#include <cstdint>
#include <map>

#include "service/jobs/job.h"

namespace sleight::jobs {

struct Limits {
  std::uint64_t jobs = 20'000;    ///< that are not over
  std::uint32_t cores = 0;        ///< at a time
  double core_hours_per_day = 0;  ///< as many at once, and a slice more; they flow back evenly
  std::uint64_t disk_bytes = 0;   ///< of all its jobs' folders
};

struct Options {
  Limits limits{};  ///< of whoever has none of its own
  std::map<UserId, Limits> limits_of{};

  // Whose turn it is
  double half_life_s = 3600;  ///< of the core-seconds that a user has had
  /// What a user's running jobs will have had so much later counts as had: so two users that are
  /// equal don't get all cores one after the other.
  double horizon_s = 10;
  /// A user that waits and has nothing running for so long is next; and a user's job that has
  /// waited longest, once in so long, is before its user's others.
  double patience_s = 3600;

  // When a job makes room
  double slice_s_min = 10;            ///< a job has its cores for so long at least,
  double slice_per_cost = 20;         ///< and so many times what its last restart cost,
  double slice_uncommitted_s = 60;    ///< and, before its first commit, so long, doubled with each
                                      ///< turn that ended without one
  double restart_cost_guess_s = 0.5;  ///< of a job whose restart hasn't been measured
  double stop_again_s = 10;           ///< a job that doesn't stop is asked again,
  double stop_now_after_s = 600;      ///< and ended after so long

  // After a death
  double back_off_first_s = 1;  ///< doubles with each further one
  double back_off_last_s = 300;
  double steady_s = 600;         ///< an attempt that has lived so long begins the back-off anew
  std::uint32_t deaths_max = 5;  ///< without a commit between: failed

  // Of the backend
  double look_after_launch_s = 5;  ///< if nothing is heard
  double look_every_s = 30;        ///< likewise of a running job
  std::uint32_t unbegun_max = 5;   ///< launches of one attempt, none of which began

  double disk_resume_factor =
      1.25;  ///< what was held for the disk goes on above reserve times this
  double limit_resume_factor = 0.9;  ///< of a limit: what was held for it goes on below

  // How long finished jobs are kept
  double keep_s = 30.0 * 86400;
  std::uint64_t keep_bytes = 200'000'000'000;  ///< of all finished jobs that nobody pinned
  double announce_s = 3.0 * 86400;             ///< between the announcement and the deletion

  double save_every_s = 60;  ///< what running jobs have used is saved
};

/// The farthest back-off has doubled so often.
inline constexpr std::uint32_t k_doublings_max = 20;
/// Places in the queue are counted up to here: nobody reads larger ones, and counting costs.
inline constexpr std::uint64_t k_place_max = 100;

}  // namespace sleight::jobs
