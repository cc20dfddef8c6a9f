// Inputs and outputs of the machine of jobs. The daemon maps these messages to processes, folders,
// sockets and rows of the job store.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "service/jobs/job.h"

namespace sleight::jobs {

/// The caller's value. The machine returns this value unchanged with the answer.
using Token = std::uint64_t;

// Inputs

/// The current time. `now_s` is a monotonic clock with any origin; `wall` is the wall clock, which
/// may jump. The daemon sends a Tick before every other input and at next_tick_s().
struct Tick {
  double now_s = 0;
  double wall = 0;
};

/// The daemon has restored the whole job store. Sent once after a restart, before other inputs.
struct Began {};

/// Resources that the machine may use. No job starts before the first Room.
struct Room {
  std::uint32_t cores = 0;
  std::uint64_t memory_bytes = 0;
  std::uint64_t disk_free_bytes = 0;
  std::uint64_t disk_reserve_bytes = 0;  ///< below this nothing starts, and jobs are held
};

/// While drain is on, no job starts. Running jobs stop cleanly and are queued.
struct Drain {
  bool on = false;
};

/// Reports whether attempts' programs can start, and which results version they have (empty:
/// unknown).
struct BackendNote {
  bool is_there = true;
  std::string results_version{};
};

/// This message doesn't have the request's text. The daemon stores the text with this step's Save.
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

/// The counterparts of rpc::ChangeKind.
enum class AskKind { cancel, hold, resume, extend, remove, pin, unpin, set_priority };

struct Ask {
  Token token = 0;
  UserId user;
  bool is_operator = false;  ///< may change other users' jobs
  JobId job;
  AskKind kind = AskKind::cancel;
  std::int32_t priority = 0;  ///< of set_priority
};

/// The backend doesn't have the attempt: no keeper runs, and the folder has no record of this
/// attempt or a newer one. The attempt may still begin.
struct NeverBegan {};
/// A batch system has queued the attempt. The attempt will begin by itself and uses no cores yet.
struct Pending {
  std::string words{};  ///< why it waits there: "Slurm job 812 waits: Priority"
};
/// A keeper holds the attempt.
struct Running {
  Counts counts{};
  /// Seconds from the attempt's launch to its first commit. Empty: no commit yet.
  std::optional<double> first_commit_after_s{};
  std::uint64_t disk_bytes = 0;
  std::string results_version{};  ///< of its run; empty: unknown
};
/// Why a program couldn't continue, as far as the daemon found out.
enum class Hindrance {
  none,
  disk_full,
  other_results,
  store_damaged  ///< the run store is unreadable, so any further attempt would fail too
};
/// What a batch system, or somebody through it, did to the attempt without the machine's request.
enum class Outside {
  nothing,
  taken,     ///< it had to make room, or its machine was lost
  cancelled  ///< by hand
};
/// The attempt and all its processes ended, and its record has an end.
struct Ended {
  EndKind kind = EndKind::none;
  int exit_code = 0;
  int signal = 0;
  Hindrance hindrance = Hindrance::none;
  std::string digest{};
  std::string words{};    ///< of the run
  std::string place{};    ///< of a failed check
  std::string log_end{};  ///< its last 50 lines
  std::string repeat{};   ///< command that repeats the failure
  Counts counts{};
  std::optional<double> first_commit_after_s{};
  std::uint64_t disk_bytes = 0;
  std::string results_version{};
  Outside outside = Outside::nothing;
  std::string outside_words{};  ///< "Slurm job 812: PREEMPTED"
};
/// The keeper and the program were killed: no keeper holds the folder, and the record has no end.
struct Died {
  std::string words{};
  std::string log_end{};
  std::string repeat{};
  Counts counts{};
  std::uint64_t disk_bytes = 0;
  Outside outside = Outside::nothing;
};
/// The backend couldn't find out.
struct Unknown {
  std::string words{};  ///< why; shown while the attempt is awaited
};

/// What the backend observed of a job, by itself or after a Look. `attempt` comes from the folder's
/// record. In a NeverBegan, Pending or Unknown, it is the attempt of the Look.
struct Sight {
  JobId job;
  Attempt attempt;
  std::variant<NeverBegan, Pending, Running, Ended, Died, Unknown> seen;
};

/// The attempt's keeper holds the folder.
struct Launched {
  JobId job;
  Attempt attempt;
};
/// The launch couldn't start a keeper. If another keeper holds the folder, the launch has not
/// failed.
struct LaunchFailed {
  JobId job;
  Attempt attempt;
  bool is_backend_away = false;  ///< else the job itself is the cause
  Hindrance hindrance = Hindrance::none;
  std::string words{};
};

/// After a Remove: the job's folder no longer exists.
struct Removed {
  JobId job;
};

using Input = std::variant<Tick, Began, Room, Drain, BackendNote, Submit, Ask, Sight, Launched,
                           LaunchFailed, Removed>;

// Effects, in the order in which the daemon must carry them out

/// A transaction. A Save must be durable before the daemon carries out the step's other effects. A
/// step has at most one Save, which is its first effect.
struct Save {
  std::vector<Job> jobs{};        ///< in their current state
  std::vector<Change> changes{};  ///< appended to the history
  std::vector<JobId> erased{};    ///< deleted with their histories
  std::vector<Usage> usages{};
  double clock_s = 0;         ///< service time
  std::uint64_t next_id = 1;  ///< of the next job
};

/// Start a keeper for the attempt. If `revision` is newer than the folder's, rewrite the folder's
/// request first. The same attempt may be launched repeatedly.
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

/// Report the attempt's state as a Sight.
struct Look {
  JobId job;
  Attempt attempt;
};

enum class RefusalKind {
  not_found,
  not_allowed,
  key_in_use,  ///< with different content
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

/// Answers a Submit or an Ask with the job or the refusal.
struct Answer {
  Token token = 0;
  JobId job{};
  bool is_new = false;  ///< the submit created the job
  std::optional<Refusal> refusal{};
};

/// Delete the job's folder, if it exists.
struct Remove {
  JobId job;
};

/// If nobody pins the job, it will be deleted at about this time.
struct Announce {
  JobId job;
  UserId user;
  double wall = 0;
};

using Effect = std::variant<Save, Launch, Stop, Look, Answer, Remove, Announce>;

}  // namespace sleight::jobs
