// What a service and its clients say to each other, as plain values.
//
// The schema common/schema/service.capnp is the specification of the calls; these are its structs
// for C++, and nothing outside common/rpc sees Cap'n Proto. handler.h is a service's side of the
// calls, client.h a client's.
//
// Invariants
//   1. A call that is repeated changes nothing more: submissions carry the client's key, and all
//   that
//      a call sets is absolute. So a client may repeat a call whose answer was lost.
//   2. Text that people see is whole sentences without control characters, and names nothing of the
//      service's insides.
//   3. Values that a newer program sends are kept apart from wrong ones: enumerations have
//   `unknown`.
//
// Times are seconds since 1970 of the service's wall clock, and serve people alone.
//
// Thread safety: values.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/ids.h"
#include "common/events/run_event.h"
#include "common/request/diagnostic.h"

namespace sleight::rpc {

using JobId = base::Id<struct JobTag, std::uint64_t>;      ///< from 1; people write 17
using GroupId = base::Id<struct GroupTag, std::uint64_t>;  ///< from 1; people write g5

// ------------------------------------------------------------------------------------- refusals

enum class RefusalKind : std::uint8_t {
  unknown,      ///< a newer service's
  not_found,    ///< no such job, group, recording or call
  not_allowed,  ///< another user's
  bad_request,  ///< of which `diagnostics` are the places, where it is a request's text
  conflict,     ///< not in this state; the key belongs to another submission
  limit,        ///< of a user or of the service: too many, too large
  busy,         ///< now; the same call may succeed later
  gone,         ///< was there and is deleted
  environment,  ///< the disk is full, the backend is away
  bug,          ///< the service failed; its log has more
};
inline constexpr std::size_t k_refusal_kinds = 10;

/// "not_found", and so on.
std::string_view name_of(RefusalKind kind);

struct Refusal {
  RefusalKind kind = RefusalKind::bug;
  std::string sentence{};    ///< what is the matter
  std::string what_to_do{};  ///< may be empty
  /// Of a submission's text, as `sleight check` has them; `file` is the request's name.
  std::vector<request::Diagnostic> diagnostics{};
  bool operator==(const Refusal&) const = default;
};

// ------------------------------------------------------------------------------------ submitting

/// One for the system that runs a job, as Slurm's partition.
struct JobOption {
  std::string name{};
  std::string value{};
  bool operator==(const JobOption&) const = default;
};

/// What one job is to do and may use.
struct JobAsk {
  std::string name{};     ///< for people; empty: the service takes the request's world
  std::string request{};  ///< the text (TOML), overrides applied; never a path
  std::optional<std::uint32_t> cores{};  ///< a wish; none: what is free
  std::uint32_t ranks = 0;               ///< of mpirun; 0: one process, no MPI
  std::uint64_t memory_bytes = 0;        ///< of the caches of all processes; 0: the default
  std::int32_t priority = 0;             ///< among one user's jobs: higher ones first
  bool strict = false;                   ///< a failed simulation ends the job
  std::vector<JobOption> options{};      ///< at most k_options_max, each name once
  bool operator==(const JobAsk&) const = default;
};

struct Submission {
  /// Drawn at random by the client, at most k_key_bytes_max: a submission with a key that the
  /// service knows of this user answers what the first one did, and submits nothing.
  std::string key{};
  /// A single one is a job of its own; several are a group, and all are taken or none.
  std::vector<JobAsk> jobs{};
  bool is_group = false;  ///< also of a single one, as with --set sampler.seed=1..1
  bool operator==(const Submission&) const = default;
};

struct Submitted {
  std::vector<JobId> jobs{};  ///< in the submission's order
  std::optional<GroupId> group{};
  bool was_known = false;  ///< by its key
  bool operator==(const Submitted&) const = default;
};

/// A job, or all jobs of a group.
struct Target {
  std::optional<JobId> job{};
  std::optional<GroupId> group{};  ///< REQUIRES: exactly one of the two
  static Target of(JobId id) { return {.job = id}; }
  static Target of(GroupId id) { return {.group = id}; }
  bool operator==(const Target&) const = default;
};

// ------------------------------------------------------------------------------------------ jobs

enum class JobState : std::uint8_t {
  unknown,  ///< a newer service's
  queued,
  starting,
  running,
  yielding,
  held,
  done,
  failed,
  cancelled,
};
inline constexpr std::size_t k_job_states = 9;

/// "queued", and so on.
std::string_view name_of(JobState state);
std::optional<JobState> job_state_of(std::string_view name);

/// Nothing comes after these, unless the job is extended or resumed.
constexpr bool is_settled(JobState state) {
  return state == JobState::done || state == JobState::failed || state == JobState::cancelled;
}

/// A job's changes are numbered from 1 without a gap, and durable before anybody is told.
struct StateChange {
  std::uint64_t number = 0;
  double time_s = 0;
  JobState state = JobState::unknown;
  std::string reason{};  ///< in words
  std::uint64_t attempt = 0;
  bool operator==(const StateChange&) const = default;
};

/// Solutions, apart by what they are: what a search built, and a chain's independent ones.
struct SolutionCounts {
  std::uint64_t found = 0;
  std::uint64_t found_wanted = 0;  ///< 0: none are asked for
  std::uint64_t in_proportion = 0;
  std::uint64_t in_proportion_wanted = 0;
  bool operator==(const SolutionCounts&) const = default;
};

struct FailureCount {
  std::string simulation{};  ///< the kind's name (plan/failure.h)
  std::uint64_t count = 0;
  bool operator==(const FailureCount&) const = default;
};

struct JobView {
  JobId id{};
  std::optional<GroupId> group{};
  std::uint32_t user = 0;  ///< uid
  std::string name{};
  std::string world{};
  JobState state = JobState::unknown;
  std::string reason{};       ///< of the state, in words
  std::uint64_t place = 0;    ///< in the queue, from 1; 0: it is not in it
  std::string not_yet{};      ///< why it does not run yet, and from when it might
  std::uint64_t attempt = 0;  ///< the newest start's number; 0: none so far
  std::int32_t priority = 0;
  std::optional<std::uint32_t> cores_wanted{};
  std::uint32_t cores = 0;  ///< that it has now
  std::uint32_t ranks = 0;
  std::uint64_t memory_bytes = 0;
  bool strict = false;
  bool pinned = false;  ///< kept whatever the rule says

  std::uint64_t scans_done = 0;   ///< committed
  std::uint64_t scans_total = 0;  ///< 0 where the stop rule can't tell
  SolutionCounts solutions{};
  std::vector<FailureCount> failures{};
  double simulations_per_s = 0;
  std::optional<double> left_s{};            ///< until it ends, by scans
  std::optional<double> solutions_left_s{};  ///< until it has the solutions that it wants

  double core_s = 0;  ///< processor time of all attempts
  double submitted_s = 0;
  double started_s = 0;     ///< the first time; 0: not yet
  double ended_s = 0;       ///< 0: not yet
  std::uint64_t bytes = 0;  ///< of its folder
  double deleted_at_s = 0;  ///< announced; 0: not announced
  std::string digest{};     ///< of the newest archive's content; empty: none
  std::string results_version{};
  std::string end_words{};                    ///< what the run said at its end
  std::vector<std::string> last_log_lines{};  ///< of a failed job, k_last_log_lines at most
  std::string repeat_command{};               ///< of a failed job: what repeats it
  std::vector<StateChange> history{};         ///< of `status` alone; the newest, oldest first
  bool operator==(const JobView&) const = default;
};

/// Which jobs; all that is given must hold.
struct ListAsk {
  std::optional<GroupId> group{};
  std::optional<std::uint32_t> user{};  ///< none: all that the caller may see
  std::vector<JobState> states{};       ///< empty: any
  std::string name_part{};              ///< empty: any
  bool oldest_first = false;
  std::uint32_t count = 100;  ///< at most k_page_jobs_max are given
  std::string cursor{};       ///< of the page before; empty: the first page
  bool operator==(const ListAsk&) const = default;
};

struct JobPage {
  std::vector<JobView> jobs{};  ///< without histories
  std::string cursor{};         ///< of the next page; empty: this is the last
  std::uint64_t total = 0;      ///< that match, of all pages
  bool operator==(const JobPage&) const = default;
};

/// What became of a job that a call named, by itself or by its group.
struct Touched {
  JobId job{};
  JobState state = JobState::unknown;  ///< after the call
  std::string words{};                 ///< "stops at the next scan"
  bool operator==(const Touched&) const = default;
};

enum class ExtendBy : std::uint8_t { unknown, scans, rounds, solutions, odds };

/// A longer [stop] of the normalised request, absolute; `odds` is its relative error.
struct Extension {
  ExtendBy by = ExtendBy::unknown;
  double to = 0;  ///< whole but of odds
  bool operator==(const Extension&) const = default;
};

/// How a job is changed.
enum class ChangeKind : std::uint8_t {
  unknown,  ///< a newer client's
  cancel,   ///< stops in order and ends, with the archive of what it has
  hold,     ///< stops in order, until `resume`
  resume,   ///< queued again: a held, failed or cancelled job
  extend,   ///< a longer [stop]; queued again if it had ended
  erase,    ///< deleted with all that it has; one that has not ended is refused
  pin,      ///< kept whatever the rule for finished jobs says
  unpin,
  set_priority,
};
inline constexpr std::size_t k_change_kinds = 9;

/// "cancel", and so on.
std::string_view name_of(ChangeKind kind);

struct ChangeAsk {
  Target target{};
  ChangeKind kind = ChangeKind::unknown;
  Extension extension{};      ///< of extend
  std::int32_t priority = 0;  ///< of set_priority
  bool operator==(const ChangeAsk&) const = default;
};

// ---------------------------------------------------------------------------------------- watching

/// How much of a job a watcher has.
struct WatchPoint {
  JobId job{};
  std::uint64_t event = 0;   ///< number of the last numbered event that it has
  std::uint64_t change = 0;  ///< likewise of the state changes
  /// The service's own mark of what is unnumbered, from the batch before; 0: nothing was seen. A
  /// service that does not know it sends the newest.
  std::uint64_t mark = 0;
  bool operator==(const WatchPoint&) const = default;
};

// -------------------------------------------------------------------------------------------- logs

/// Either the last lines, or bytes from an offset on. Offsets count all bytes that the job has
/// logged; the service keeps the newest.
struct LogAsk {
  JobId job{};
  std::optional<std::uint64_t> from{};  ///< none: the last `lines`
  std::uint32_t lines = 50;
  std::uint32_t bytes_max = 256U << 10U;  ///< at most k_log_bytes_max are given
  bool operator==(const LogAsk&) const = default;
};

struct LogPiece {
  std::uint64_t first =
      0;  ///< offset of the first byte; beyond what was asked for where that is lost
  std::string text{};
  std::uint64_t end = 0;  ///< of the log as it is now
  bool is_over = false;   ///< nothing will come after `end`
  bool operator==(const LogPiece&) const = default;
};

// ---------------------------------------------------------------------------------------- fetching

enum class FetchKind : std::uint8_t {
  unknown,
  archive,        ///< the newest
  so_far,         ///< one made now of all that is committed
  recordings,     ///< of kept animations, by `ids`
  failure_files,  ///< that `sleight replay` repeats
};

struct FetchAsk {
  JobId job{};
  FetchKind kind = FetchKind::archive;
  std::vector<std::uint64_t> ids{};  ///< of recordings; at most k_fetch_ids_max
  std::string after{};               ///< the files that come after this name; empty: the first ones
  /// Hexadecimal, of the file that the client has a part of; a service that still has it gives it.
  std::string sha256_wanted{};
  bool operator==(const FetchAsk&) const = default;
};

/// A file as it is announced.
struct FileView {
  std::string name{};  ///< a plain file name
  std::uint64_t size = 0;
  std::string sha256{};  ///< of its bytes, hexadecimal
  bool operator==(const FileView&) const = default;
};

// ------------------------------------------------------------------------------------------ tokens

/// What a session by a token may do, as bits. Each includes nothing of the others.
enum class Scope : std::uint8_t {
  unknown = 0,  ///< a newer program's
  read = 1,     ///< list, status, watch, logs, fetch, info
  submit = 2,
  manage = 4,   ///< change
  operate = 8,  ///< drain and stop, of a user who may
};
inline constexpr Scope k_scopes[] = {Scope::read, Scope::submit, Scope::manage, Scope::operate};

/// "read", and so on.
std::string_view name_of(Scope scope);
std::optional<Scope> scope_of(std::string_view name);

struct Scopes {
  std::uint8_t bits = 0;
  bool has_unknown = false;  ///< of a message: something that this program does not know

  static constexpr Scopes all() { return {.bits = 15}; }
  constexpr bool has(Scope scope) const { return (bits & static_cast<std::uint8_t>(scope)) != 0; }
  constexpr void add(Scope scope) {
    bits = static_cast<std::uint8_t>(bits | static_cast<std::uint8_t>(scope));
  }
  bool operator==(const Scopes&) const = default;
};

struct TokenAsk {
  std::string token{};                      ///< whole, drawn by the client (token_text.h)
  std::string name{};                       ///< for people
  std::optional<std::uint32_t> for_user{};  ///< uid; none: the caller's own
  Scopes scopes{};
  double valid_s = 0;           ///< 0: for ever
  std::uint32_t jobs_max = 0;   ///< of this token's, that have not ended; 0: as its user
  std::uint32_t cores_max = 0;  ///< of one of its jobs; 0: as its user
  bool operator==(const TokenAsk&) const = default;
};

struct TokenView {
  std::string id{};
  std::string name{};
  std::uint32_t user = 0;
  Scopes scopes{};
  double created_s = 0;
  double expires_s = 0;      ///< 0: never
  bool has_expired = false;  ///< was seen to: a clock that is set back revives none
  double revoked_s = 0;      ///< 0: it is not
  double last_used_s = 0;    ///< 0: never
  std::string last_from{};
  std::uint32_t jobs_max = 0;
  std::uint32_t cores_max = 0;
  bool operator==(const TokenView&) const = default;
};

// ------------------------------------------------------------------------------------------ server

struct NamedLimit {
  std::string name{};
  std::string value{};  ///< in words: "16 cores", "10 GB"
  bool operator==(const NamedLimit&) const = default;
};

struct StateCount {
  JobState state = JobState::unknown;
  std::uint64_t count = 0;
  bool operator==(const StateCount&) const = default;
};

struct ServerView {
  std::string version{};
  std::string results_version{};
  std::string state_folder{};
  std::int64_t pid = 0;
  double up_s = 0;
  bool draining = false;
  std::string backend{};  ///< "local", "slurm", or a program's path
  std::uint32_t cores = 0;
  std::uint32_t cores_used = 0;
  std::uint64_t memory_bytes = 0;
  std::uint64_t memory_used_bytes = 0;
  std::uint64_t disk_free_bytes = 0;
  std::uint64_t disk_reserve_bytes = 0;
  std::string keeping_rule{};  ///< how long finished jobs are kept, in words
  std::vector<NamedLimit> limits{};
  std::vector<StateCount> counts{};
  std::uint32_t connections = 0;
  std::uint32_t watchers = 0;
  std::string address{};      ///< where it listens over TCP; empty: nowhere
  std::string fingerprint{};  ///< of its certificate there
  bool operator==(const ServerView&) const = default;
};

// ------------------------------------------------------------------------------------------ limits

inline constexpr std::size_t k_key_bytes_max = 64;
inline constexpr std::size_t k_name_bytes_max = 256;
inline constexpr std::size_t k_request_bytes_max = 1U << 20U;     ///< of one job's text
inline constexpr std::size_t k_submission_bytes_max = 3U << 20U;  ///< of all texts together
inline constexpr std::size_t k_submission_jobs_max = 1000;
inline constexpr std::size_t k_page_jobs_max = 500;
inline constexpr std::size_t k_watch_jobs_max = 1000;  ///< in one watch
inline constexpr std::size_t k_batch_events_max = 256;
inline constexpr std::size_t k_log_bytes_max = 512U << 10U;
inline constexpr std::size_t k_last_log_lines = 50;
inline constexpr std::size_t k_fetch_ids_max = 10'000;
inline constexpr std::size_t k_fetch_files_max = 64;  ///< of one call
inline constexpr std::size_t k_piece_bytes_max = 1U << 20U;
/// Longer texts of views lose their end, and longer lists their last: an answer stays readable.
inline constexpr std::size_t k_text_bytes_max = 64U << 10U;
inline constexpr std::size_t k_history_max = 1000;
inline constexpr std::size_t k_options_max = 32;        ///< of a job, for the system that runs it
inline constexpr std::size_t k_option_bytes_max = 256;  ///< of a name or a value
inline constexpr std::size_t k_tokens_max = 1000;       ///< of a user, and as many in an answer
/// No uid: what the system takes for "unchanged".
inline constexpr std::uint32_t k_no_user = UINT32_MAX;
inline constexpr double k_token_s_max = 3650.0 * 86400;

/// Whether a fetched file may be called so: a name in a folder, not hidden, without control
/// characters, at most k_name_bytes_max long.
bool is_file_name(std::string_view name);

}  // namespace sleight::rpc
