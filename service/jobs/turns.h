// Whose turn it is, with how many cores, and who makes room: the rules as pure functions of values.
//
// Shares. The users with something to run, u of them, have a claim to an equal part of the cores
// each: s = cores / u. Space comes first: where each user can have its share at the same time, jobs
// of several run side by side and nobody is stopped. Time comes second: where shares can't be had
// in whole cores, jobs take turns in slices.
//
// The next job. A user that waited patience_s with nothing running, the longest first; else the
// user with the least decayed core-seconds, what its running jobs will soon have had included; then
// priority, then age. Of that user its first job: by priority, then age; but the one that has
// waited longest, where that is over patience_s, once in so long.
//
//   hand_out:
//     while there is a next job:
//       need = its user's share, or what the job must and can have
//       if fewer cores are free than need: those that come after it and have had their slice stop,
//         of users above their share, or of any where the job couldn't start else
//       if need will be free when these have stopped: wait
//       else if it can start: it gets what is free, less the shares of other users that wait
//       else: wait, and nothing overtakes it
//
// Cores that are free while nobody waits: a job that was given fewer than it wishes is stopped and
// started wider, if by the work that it has had so far, taken for the work that is left, it saves
// slice_per_cost times what its restart costs. A user below its share with such a job, beside one
// above its share that has had more, gets its share by both being stopped.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "service/jobs/job.h"
#include "service/jobs/options.h"

namespace sleight::jobs {

/// A running job, as the rules see it.
struct RunningJob {
  JobId id;
  UserId user;
  std::int32_t priority = 0;
  std::uint32_t cores = 0;
  std::uint32_t cores_wished = 0;  ///< most that it can use here and its user may have
  std::uint64_t memory_bytes = 0;
  bool has_had_slice = false;
  double restart_cost_s = 0;
  double core_seconds = 0;  ///< that it has had
};

struct NextJob {
  JobId id;
  UserId user;
  std::int32_t priority = 0;
  bool is_overdue = false;  ///< its user has waited for patience_s
  bool is_turn = false;     ///< it has waited longest of its user's
};

/// Users with something to run share the cores.
struct Shares {
  std::uint32_t cores = 0;
  std::uint64_t users = 1;
  double each() const { return static_cast<double>(cores) / static_cast<double>(users); }
};

struct Need {
  std::uint32_t cores_min = 1;  ///< to start at all
  std::uint32_t cores = 1;      ///< its user's share, or what it can use
  std::uint32_t cores_wished = 1;
  std::uint64_t memory_bytes = 0;
};

/// What a job needs and can use. `had` is the cores that its user has and keeps.
Need need_of(const Job& job, const Shares& shares, std::uint32_t had, std::uint32_t cores_max);

/// How many of the free cores a job gets, `others_claim` being what waiting users' shares are.
/// REQUIRES: need.cores_min <= free.
std::uint32_t cores_given(const Need& need, std::uint32_t free, std::uint64_t others_claim);

/// How long a job has its cores before it may be stopped for others.
double slice_s(const Job& job, const Options& options);
double restart_cost_s(const Job& job, const Options& options);

/// Whether to start the job wider is worth its restart.
bool is_worth_widening(const RunningJob& job, std::uint32_t cores, const Options& options);

/// Whether `next` comes before the running job, once that one has stopped. Both users' standings
/// are in core-seconds (Accounts::standing_core_s).
bool comes_before(const NextJob& next, double next_standing, const RunningJob& running,
                  double running_standing, const Options& options);

}  // namespace sleight::jobs
