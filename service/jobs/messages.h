// What goes into the machine of jobs and what comes out of it. All of it is logical: processes,
// folders, sockets and the job store's rows are the daemon's.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "service/jobs/job.h"

namespace sleight::jobs {

/// Given back with the answer; the machine only carries it.
using Token = std::uint64_t;

// Inputs

/// Time has come to here: a monotonic clock, which begins anywhere and doesn't go back, and the
/// wall clock, which may jump. The daemon ticks before what it has heard, and at next_tick_s().
struct Tick {
  double now_s = 0;
  double wall = 0;
};

/// All that the job store had is there: first after a restart, once.
struct Began {};

/// What the machine may use. Nothing starts before the first.
struct Room {
  std::uint32_t cores = 0;
  std::uint64_t memory_bytes = 0;
  std::uint64_t disk_free_bytes = 0;
  std::uint64_t disk_reserve_bytes = 0;  ///< below this nothing starts, and jobs are held
};

/// On: nothing starts, and what runs is stopped in order. The jobs stay, queued.
struct Drain {
  bool on = false;
};

/// The programs that are started: whether they can be now, and of which results version they are
/// (empty: not known).
struct BackendNote {
  bool is_there = true;
  std::string results_version{};
};

/// The text itself goes with the Save of this step into the job store: it is never read here.
struct Submit {
  Token token = 0;
  UserId user;
  std::string client_key{};  ///< empty: each submit is a new job
  std::string content{};     ///< a digest of request and options
  std::string name{};
  GroupId group{};
  std::int32_t priority = 0;
  Wishes wishes{};
};

/// As rpc::ChangeKind has them.
enum class AskKind { cancel, hold, resume, extend, remove, pin, unpin, set_priority };

struct Ask {
  Token token = 0;
  UserId user;
  bool is_operator = false;  ///< may ask of others' jobs
  JobId job;
  AskKind kind = AskKind::cancel;
  std::int32_t priority = 0;  ///< of set_priority
};

/// The backend hasn't got the attempt: no keeper, and its folder has no record of this attempt or a
/// newer one. It may be that it begins yet.
struct NeverBegan {};
/// A batch system has the attempt in its queue: it will begin by itself, and uses nothing yet.
struct Pending {
  std::string words{};  ///< why it waits there: "Slurm job 812 waits: Priority"
};
/// A keeper has it.
struct Running {
  Counts counts{};
  /// Seconds from its launch to its first commit in this attempt, if there was one.
  std::optional<double> first_commit_after_s{};
  std::uint64_t disk_bytes = 0;
  std::string results_version{};  ///< of its run; empty: not known
};
/// Why a program couldn't go on, where the daemon could tell.
enum class Hindrance {
  none,
  disk_full,
  other_results,
  store_damaged  ///< what the run had stored can't be read: no attempt would get further
};
/// What a batch system, or somebody by its means, did to an attempt that we had not asked for.
enum class Outside {
  nothing,
  taken,     ///< it had to make room, or its machine was lost
  cancelled  ///< by hand
};
/// It is gone, with all its processes, and its record has an end.
struct Ended {
  EndKind kind = EndKind::none;
  int exit_code = 0;
  int signal = 0;
  Hindrance hindrance = Hindrance::none;
  std::string digest{};
  std::string words{};    ///< of the run
  std::string place{};    ///< of a failed check
  std::string log_end{};  ///< its last 50 lines
  std::string repeat{};   ///< the command that repeats it
  Counts counts{};
  std::optional<double> first_commit_after_s{};
  std::uint64_t disk_bytes = 0;
  std::string results_version{};
  Outside outside = Outside::nothing;
  std::string outside_words{};  ///< "Slurm job 812: PREEMPTED"
};
/// Nobody holds its folder, and its record has no end: keeper and program were killed.
struct Died {
  std::string words{};
  std::string log_end{};
  std::string repeat{};
  Counts counts{};
  std::uint64_t disk_bytes = 0;
  Outside outside = Outside::nothing;
};
/// The backend can't say.
struct Unknown {
  std::string words{};  ///< why, for whoever waits for the attempt to begin
};

/// What the backend sees of a job; unasked, or after a Look. `attempt` is that of the folder's
/// record; for NeverBegan, Pending and Unknown the one that was asked about.
struct Sight {
  JobId job;
  Attempt attempt;
  std::variant<NeverBegan, Pending, Running, Ended, Died, Unknown> seen;
};

/// The keeper of the attempt holds the folder.
struct Launched {
  JobId job;
  Attempt attempt;
};
/// Its keeper couldn't be started, by this launch: nothing of it will begin. (A keeper that finds
/// its folder taken is no such failure.)
struct LaunchFailed {
  JobId job;
  Attempt attempt;
  bool is_backend_away = false;  ///< else something of this job
  Hindrance hindrance = Hindrance::none;
  std::string words{};
};

/// The folder of a Remove is gone.
struct Removed {
  JobId job;
};

using Input = std::variant<Tick, Began, Room, Drain, BackendNote, Submit, Ask, Sight, Launched,
                           LaunchFailed, Removed>;

// Effects, in the order in which they are to be carried out

/// To be durable, as one transaction, before any other effect of its step is carried out or
/// answered. At most one a step, its first effect.
struct Save {
  std::vector<Job> jobs{};        ///< as they are now
  std::vector<Change> changes{};  ///< appended to the history
  std::vector<JobId> erased{};    ///< with their histories
  std::vector<Usage> usages{};
  double clock_s = 0;         ///< service time
  std::uint64_t next_id = 1;  ///< of the next job
};

/// Start a keeper for the attempt, by rewriting the request where the revision is newer than that
/// of the folder. The same attempt may come again.
struct Launch {
  JobId job;
  Attempt attempt;
  std::uint64_t revision = 1;
  std::uint32_t cores = 1;
  std::uint32_t ranks = 0;
  std::uint64_t memory_bytes = 0;  ///< of each process
};

enum class StopHow { in_order, now };
struct Stop {
  JobId job;
  Attempt attempt;
  StopHow how = StopHow::in_order;
};

/// Say what is seen of it.
struct Look {
  JobId job;
  Attempt attempt;
};

enum class RefusalKind {
  not_found,
  not_allowed,
  key_in_use,  ///< with other content
  over_limit,
  too_large,  ///< for this machine
  wrong_state,
};
std::string_view name_of(RefusalKind kind);

struct Refusal {
  RefusalKind kind = RefusalKind::not_found;
  std::string sentence{};
  std::string what_to_do{};
};

/// To a Submit or an Ask: the job, or why not.
struct Answer {
  Token token = 0;
  JobId job{};
  bool is_new = false;  ///< of a submit: the job was made by it
  std::optional<Refusal> refusal{};
};

/// Delete the job's folder, if it is there.
struct Remove {
  JobId job;
};

/// The job will be deleted at about this time, unless it is pinned.
struct Announce {
  JobId job;
  UserId user;
  double wall = 0;
};

using Effect = std::variant<Save, Launch, Stop, Look, Answer, Remove, Announce>;

}  // namespace sleight::jobs
