// Decides which job is next, how many cores it gets, and which running jobs make room.
//
// Shares. If users have something to run, each has a claim to an equal share of the cores. If all
// users can have their shares at the same time, their jobs run side by side. If the shares aren't
// whole cores, jobs take turns in slices.
//
// The next job. If a user has waited patience_s and has no running job, the user is next. If there
// are several such users, the one that has waited longest is next. If there is no such user, the
// user with the fewest decayed core-seconds is next. Core-seconds that the user's running jobs will
// use soon also count. If users are equal, their jobs' priority decides, then their jobs' age. The
// user's first job is the one with the highest priority, then the oldest. But once per patience_s,
// the user's longest-waiting job comes first if it has waited for patience_s.
//
// While there is a next job, hand_out() does this:
//   1. The job needs its user's share of cores, but at least its minimum and at most what it can
//      use.
//   2. If fewer cores are free, stop running jobs that have had their slice and come after the next
//      job. Jobs of users above their share are stopped first. Other jobs are stopped only if the
//      next job couldn't start otherwise.
//   3. If enough will be free when these jobs have stopped, wait.
//   4. Otherwise, if the job can start, give it the free cores that remain after the shares of
//      other waiting users.
//   5. Otherwise, wait. No other job may start first.
//
// If nobody waits for free cores, a running job gets them if it wishes more cores. For this, the
// job is stopped and restarted, but only if the time saved is at least slice_per_cost times the
// restart's cost. The estimate assumes that the remaining work equals the work so far. If the job's
// user is below its share, the job can also get another user's cores. The other user must be above
// its share and have used more. One job of each of the two users is then stopped.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>

#include "service/jobs/job.h"
#include "service/jobs/options.h"

namespace sleight::jobs {

/// The data of a running job that the rules need.
struct RunningJob {
  JobId id;
  UserId user;
  std::int32_t priority = 0;
  std::uint32_t cores = 0;
  std::uint32_t cores_wished = 0;  ///< maximum that the job can use here within its user's limit
  std::uint64_t memory_bytes = 0;
  bool has_had_slice = false;
  double restart_cost_s = 0;
  double core_seconds = 0;  ///< used so far
};

struct NextJob {
  JobId id;
  UserId user;
  std::int32_t priority = 0;
  bool is_overdue = false;  ///< its user has waited for patience_s
  bool is_turn = false;     ///< it goes first because it has waited longest
};

/// Number of cores, and of users that share them.
struct Shares {
  std::uint32_t cores = 0;
  std::uint64_t users = 1;
  double each() const { return static_cast<double>(cores) / static_cast<double>(users); }
};

struct Need {
  std::uint32_t cores_min = 1;  ///< minimum to start
  std::uint32_t cores = 1;      ///< its user's share, or what it can use
  std::uint32_t cores_wished = 1;
  std::uint64_t memory_bytes = 0;
};

/// Returns the resources that a job needs and can use. `had`: cores that its user already has and
/// won't give up.
Need need_of(const Job& job, const Shares& shares, std::uint32_t had, std::uint32_t cores_max);

/// Returns how many free cores a job gets. `others_claim`: sum of the shares of other waiting
/// users. REQUIRES: need.cores_min <= free.
std::uint32_t cores_given(const Need& need, std::uint32_t free, std::uint64_t others_claim);

/// Returns how long a job keeps its cores before it can be stopped for other jobs.
double slice_s(const Job& job, const Options& options);
double restart_cost_s(const Job& job, const Options& options);

/// Returns whether additional cores would save enough time to justify a restart.
bool is_worth_widening(const RunningJob& job, std::uint32_t cores, const Options& options);

/// Returns whether `next` would precede the running job if that job were stopped and queued. Both
/// standings are core-seconds (Accounts::standing_core_s).
bool comes_before(const NextJob& next, double next_standing, const RunningJob& running,
                  double running_standing, const Options& options);

}  // namespace sleight::jobs
