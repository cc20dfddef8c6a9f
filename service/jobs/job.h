// A job: a direction request that somebody submitted, and what has become of it. These are the
// values that the job store keeps and that people are shown.
//
//            ┌──────────────── ended early, died, yielded ───────────────┐
//            ▼                                                           │
//   submit: queued ──▶ starting ──▶ running ──▶ yielding (asked to stop) ┤
//            ▲ │                       │                                 ├─▶ done
//   gone on: │ ▼ held by its user      └──── held: something is missing  ├─▶ failed
//           held ◀───────────────────────────────────────────────────────┴─▶ cancelled
//
// An attempt is the n-th start of a job's program, n from 1. It is open from its Launch until it is
// known how it came to an end; a job is starting, running or yielding exactly while one is open.
//
// Two clocks. `_s` is service time: seconds for which some daemon of this state folder was up; it
// begins at 0, goes on where it was after a restart, and decides. `wall` is seconds since 1970 as
// the machine's clock says them; people are shown it, and nothing is decided by it.
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

/// Positive, never given again. People write 17.
using JobId = base::Id<struct JobTag, std::uint64_t>;
/// Jobs that were submitted as one, by `--set sampler.seed=1..20`; 0: none. People write g5.
using GroupId = base::Id<struct GroupTag, std::uint64_t>;
/// A uid of this machine.
using UserId = base::Id<struct UserTag, std::uint32_t>;
/// The n-th start of a job's program, from 1; 0: none yet.
using Attempt = base::Id<struct AttemptTag, std::uint64_t>;

enum class State { queued, starting, running, yielding, held, done, failed, cancelled };

/// Why a job is in its state. Each belongs to the states in brackets.
enum class Reason {
  submitted,           ///< [queued]
  resumed,             ///< [yielding, queued] its user said so
  extended,            ///< [queued] its request asks for more now
  its_turn,            ///< [starting]
  began,               ///< [running]
  found_running,       ///< [running] by a daemon that began after it
  others_wait,         ///< [yielding, queued] its slice is over
  wider,               ///< [yielding, queued] goes on with more cores
  less_room,           ///< [yielding, queued] the machine has less cores or memory than before
  draining,            ///< [yielding, queued] the server is being drained
  stopped_by_itself,   ///< [queued] in order, or at its own time limit, and we hadn't asked
  died,                ///< [queued] waits for its next start; [failed] five times without a commit
  hold_asked,          ///< [yielding, held] goes on when its user says so
  cancel_asked,        ///< [yielding, cancelled]
  disk_low,            ///< [yielding, held] less is free than the server's reserve
  disk_full,           ///< [held] it found no room to write
  limit_core_hours,    ///< [yielding, held] of its user
  limit_bytes,         ///< [yielding, held] of its user
  backend_away,        ///< [held] nothing can be started
  other_results,       ///< [held] the programs are of another results version than its run
  finished,            ///< [done]
  gave_up,             ///< [done] with less than was asked for; [failed] with nothing
  no_draws,            ///< [failed] the burn-in hadn't ended when all scans were made
  simulation_failed,   ///< [failed] under --strict
  taken_away,          ///< [queued] the batch system took its place, and it goes on elsewhere
  cancelled_outside,   ///< [held] somebody cancelled its attempt in the batch system
  went_on,             ///< [queued] what it was held for is no longer so
  bug,                 ///< [failed] a check failed twice at one place without a commit between
  refused_by_program,  ///< [failed] the request, an archive: it would be refused again
};

std::string_view name_of(State state);
std::string_view name_of(Reason reason);
std::optional<State> state_of(std::string_view name);
std::optional<Reason> reason_of(std::string_view name);

/// Done, failed or cancelled: nothing happens to it unless somebody asks.
constexpr bool is_over(State state) {
  return state == State::done || state == State::failed || state == State::cancelled;
}
/// An attempt is open.
constexpr bool is_active(State state) {
  return state == State::starting || state == State::running || state == State::yielding;
}

/// What a job would like. Results depend on none of it.
struct Wishes {
  std::uint32_t cores = 0;         ///< at most so many; 0: what is free
  std::uint32_t ranks = 0;         ///< of mpirun, each with a core of its own; 0: no MPI
  std::uint64_t memory_bytes = 0;  ///< of each process: its cache and what it needs beside

  std::uint32_t processes() const { return ranks == 0 ? 1 : ranks; }
  std::uint64_t memory_of_all() const { return memory_bytes * processes(); }
  bool operator==(const Wishes&) const = default;
};

/// How a run stands, as it says itself.
struct Counts {
  std::uint64_t scans = 0;                          ///< committed, over all chains
  std::uint64_t found = 0;                          ///< by a search
  std::uint64_t solutions = 0;                      ///< independent ones, in proportion
  std::map<std::string, std::uint64_t> failures{};  ///< of simulations, by kind
  bool operator==(const Counts&) const = default;
};

/// How its last session came to an end, as far as it matters here: see events::End, whose names
/// these are. `none`: it left no record, so it died.
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
  std::string client_key{};  ///< that makes its submit idempotent; empty: none
  std::string content{};     ///< a digest of what was submitted under that key
  std::string name{};
  GroupId group{};
  std::int32_t priority = 0;  ///< among the jobs of its user, higher first
  Wishes wishes{};
  bool pinned = false;         ///< kept until somebody deletes it
  std::uint64_t revision = 1;  ///< of its request; each extend makes a new one
  bool is_leaving = false;     ///< deleted: only its folder is still to go

  State state = State::queued;
  Reason reason = Reason::submitted;
  std::string words{};  ///< what people are told: what happened and what to do

  Attempt attempt{};                   ///< the newest
  std::uint64_t attempt_revision = 0;  ///< that it was launched with
  std::uint32_t cores = 0;             ///< that it was given; counted while the attempt is open
  double attempt_begin_s = 0;          ///< service time of its launch
  Counts counts{};                     ///< newest heard
  std::uint64_t scans_at_attempt = 0;  ///< committed when the newest attempt was launched
  std::string results_version{};       ///< of its run; empty: not known yet

  std::uint32_t deaths = 0;          ///< in a row, without a commit between
  std::uint64_t scans_at_death = 0;  ///< committed at the last death
  std::uint32_t back_offs = 0;       ///< starts in a row that failed or were refused
  std::string bug_place{};           ///< where a check failed last: "file.cpp:12"
  std::uint64_t scans_at_bug = 0;    ///< committed then
  std::uint32_t fruitless = 0;       ///< turns in a row that ended without a commit
  double next_start_s = 0;           ///< not before
  double start_cost_s = 0;           ///< measured, from launch to first commit; 0: not yet
  double stop_cost_s = 0;            ///< measured, from the asking to the end

  double core_seconds = 0;       ///< that it had cores for, over all attempts
  std::uint64_t disk_bytes = 0;  ///< of its folder

  EndKind end = EndKind::none;  ///< of its last session that left a record
  std::string digest{};         ///< of its newest archive
  double queued_since_s = 0;
  double over_since_s = 0;
  std::optional<double> remove_at_s{};  ///< it has been said that it will be deleted then

  double submitted_wall = 0;
  double began_wall = 0;       ///< its first attempt; 0: not yet
  double over_wall = 0;        ///< 0: it isn't
  double changed_wall = 0;     ///< its last change of state
  double next_start_wall = 0;  ///< about; 0: nothing but its turn is waited for
  double remove_wall = 0;      ///< about; 0: nothing has been said

  bool operator==(const Job&) const = default;
};

/// One line of `status --history`.
struct Change {
  JobId id;
  State from =
      State::queued;  ///< the same as `to` at the submit, and where only the reason changed
  State to = State::queued;
  Reason reason = Reason::submitted;
  Attempt attempt{};
  double wall = 0;
  std::string words{};
  bool operator==(const Change&) const = default;
};

/// What a user has had, which decides whose turn it is.
struct Usage {
  UserId user;
  double at_s = 0;              ///< service time for which the next two hold
  double share_core_s = 0;      ///< core-seconds, decayed with the half-life of the queue
  double allowance_core_s = 0;  ///< of its core-hours, used up; what a day allows flows back evenly
  bool operator==(const Usage&) const = default;
};

}  // namespace sleight::jobs
