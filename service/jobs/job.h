// A job is a submitted direction request and its current status. Jobs are stored and shown in this
// form.
//
// States:
//            ┌──────────────── ended early, died, yielded ───────────────┐
//            ▼                                                           │
//   submit: queued ──▶ starting ──▶ running ──▶ yielding (asked to stop) ┤
//            ▲ │                       │                                 ├─▶ done
//   resumed: │ ▼ held by its user      └──── held: something is missing  ├─▶ failed
//           held ◀───────────────────────────────────────────────────────┴─▶ cancelled.
//
// An attempt is the n-th start of a job's program, n from 1. The attempt is open from its Launch
// until its end is known. While an attempt is open, and only then, the job is starting, running or
// yielding.
//
// There are two clocks. The suffix `_s` means service time: how many seconds a daemon of this state
// folder was up. Service time begins at 0 and resumes after a restart. Decisions use no other time.
// `wall` means the machine's wall clock in seconds since 1970, for display only.
//
// Thread safety: values.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/ids.h"

namespace sleight::jobs {

/// Job id: positive and never reused. Written as 17.
using JobId = base::Id<struct JobTag, std::uint64_t>;
/// Group of jobs submitted together with `--set sampler.seed=1..20`. Written as g5; 0: none.
using GroupId = base::Id<struct GroupTag, std::uint64_t>;
/// A uid of this machine.
using UserId = base::Id<struct UserTag, std::uint32_t>;
/// The n-th start of a job's program, from 1; 0: none yet.
using Attempt = base::Id<struct AttemptTag, std::uint64_t>;

enum class State { queued, starting, running, yielding, held, done, failed, cancelled };

/// Why a job is in its state. Brackets list the states that a job with this reason can have.
enum class Reason {
  submitted,           ///< [queued]
  resumed,             ///< [yielding, queued] by its user
  extended,            ///< [queued] its request was extended
  its_turn,            ///< [starting]
  began,               ///< [running]
  found_running,       ///< [running] by a daemon that started after the attempt
  others_wait,         ///< [yielding, queued] its slice is over
  wider,               ///< [yielding, queued] restarts with more cores
  less_room,           ///< [yielding, queued] the machine has fewer cores or less memory
  draining,            ///< [yielding, queued] the server is being drained
  stopped_by_itself,   ///< [queued] clean stop or time limit that the machine didn't request
  died,                ///< [queued] waits for its next start; [failed] five deaths without a commit
  hold_asked,          ///< [yielding, held] until its user resumes the job
  cancel_asked,        ///< [yielding, cancelled]
  disk_low,            ///< [yielding, held] less disk space is free than the server's reserve
  disk_full,           ///< [held] the program found no room to write
  limit_core_hours,    ///< [yielding, held] the user's limit
  limit_bytes,         ///< [yielding, held] the user's limit
  backend_away,        ///< [held] nothing can be started
  other_results,       ///< [held] the run has another results version than the programs
  finished,            ///< [done]
  gave_up,             ///< [done] with fewer solutions than requested; [failed] with none
  no_draws,            ///< [failed] all scans were made before the burn-in ended
  simulation_failed,   ///< [failed] under --strict
  taken_away,          ///< [queued] the batch system took its cores; starts again
  cancelled_outside,   ///< [held] cancelled in the batch system
  went_on,             ///< [queued] the cause of the hold is gone
  bug,                 ///< [failed] a check failed twice at one place with no commit in between
  refused_by_program,  ///< [failed] the request or an archive is invalid; a restart would fail too
};

std::string_view name_of(State state);
std::string_view name_of(Reason reason);
std::optional<State> state_of(std::string_view name);
std::optional<Reason> reason_of(std::string_view name);

/// Returns whether the job is done, failed or cancelled. Its state then changes only if somebody
/// requests it.
constexpr bool is_over(State state) {
  return state == State::done || state == State::failed || state == State::cancelled;
}
/// Returns whether an attempt is open.
constexpr bool is_active(State state) {
  return state == State::starting || state == State::running || state == State::yielding;
}

/// Resources that a job would like to have. Results don't depend on wishes.
struct Wishes {
  std::uint32_t cores = 0;         ///< maximum; 0: whatever is free
  std::uint32_t ranks = 0;         ///< MPI ranks, each with its own core; 0: no MPI
  std::uint64_t memory_bytes = 0;  ///< per process, cache included

  std::uint32_t processes() const { return ranks == 0 ? 1 : ranks; }
  std::uint64_t memory_of_all() const { return memory_bytes * processes(); }
  bool operator==(const Wishes&) const = default;
};

/// A run's progress, as the run reports it.
struct Counts {
  std::uint64_t scans = 0;                          ///< committed, over all chains
  std::uint64_t found = 0;                          ///< by a search
  std::uint64_t solutions = 0;                      ///< independent ones among the draws
  std::map<std::string, std::uint64_t> failures{};  ///< of simulations, by kind
  bool operator==(const Counts&) const = default;
};

/// How the run's last session ended. The names are those of events::End. `none`: the session died
/// unrecorded.
enum class EndKind {
  none,
  finished,
  gave_up,
  no_draws,
  time_limit,
  stop_requested,
  simulation_failed,
  failed,
  bug
};
std::string_view name_of(EndKind kind);
std::optional<EndKind> end_kind_of(std::string_view name);

struct Job {
  JobId id;
  UserId user;
  std::string client_key{};  ///< makes its submit idempotent; empty: none
  std::string content{};     ///< digest of what was submitted under client_key
  std::string name{};
  GroupId group{};
  std::int32_t priority = 0;  ///< among its user's jobs, higher first
  Wishes wishes{};
  bool pinned = false;         ///< not deleted until unpinned
  std::uint64_t revision = 1;  ///< of its request; incremented by each extend
  bool is_leaving = false;     ///< deleted, except for its folder

  State state = State::queued;
  Reason reason = Reason::submitted;
  std::string words{};  ///< for people: what happened and what to do

  Attempt attempt{};                   ///< the newest
  std::uint64_t attempt_revision = 0;  ///< revision that the newest attempt runs
  std::uint32_t cores = 0;             ///< given to the open attempt
  double attempt_begin_s = 0;          ///< service time of its launch
  Counts counts{};                     ///< newest reported
  std::uint64_t scans_at_attempt = 0;  ///< committed when the newest attempt was launched
  std::string results_version{};       ///< of its run; empty: unknown

  std::uint32_t deaths = 0;          ///< in a row, without a commit between
  std::uint64_t scans_at_death = 0;  ///< committed at the last death
  std::uint32_t back_offs = 0;       ///< starts in a row that failed or were refused
  std::string bug_place{};           ///< where a check failed last: "file.cpp:12"
  std::uint64_t scans_at_bug = 0;    ///< committed when that check failed
  std::uint32_t fruitless = 0;       ///< turns in a row without a commit
  double next_start_s = 0;           ///< earliest next start
  double start_cost_s = 0;           ///< measured, from launch to first commit; 0: not measured yet
  double stop_cost_s = 0;            ///< measured, from stop request to end

  double core_seconds = 0;       ///< used, over all attempts
  std::uint64_t disk_bytes = 0;  ///< of its folder

  EndKind end = EndKind::none;  ///< of its last session that left a record
  std::string digest{};         ///< of its newest archive
  double queued_since_s = 0;
  double over_since_s = 0;
  std::optional<double> remove_at_s{};  ///< announced time of its deletion

  double submitted_wall = 0;
  double began_wall = 0;       ///< start of its first attempt; 0: none yet
  double over_wall = 0;        ///< 0: not over
  double changed_wall = 0;     ///< its last change of state
  double next_start_wall = 0;  ///< approximate; 0: the job waits only for its turn
  double remove_wall = 0;      ///< approximate; 0: no deletion announced

  bool operator==(const Job&) const = default;
};

/// One line of `status --history`.
struct Change {
  JobId id;
  State from = State::queued;  ///< equal to `to` at the submit and if only the reason changed
  State to = State::queued;
  Reason reason = Reason::submitted;
  Attempt attempt{};
  double wall = 0;
  std::string words{};
  bool operator==(const Change&) const = default;
};

/// A user's past use of cores. It decides whose turn it is.
struct Usage {
  UserId user;
  double at_s = 0;              ///< service time of the next two values
  double share_core_s = 0;      ///< core-seconds, decayed with the half-life of the queue
  double allowance_core_s = 0;  ///< of its core-hours, used up; refills evenly over a day
  bool operator==(const Usage&) const = default;
};

}  // namespace sleight::jobs
