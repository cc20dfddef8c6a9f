// The values that a service and its clients exchange.
//
// The schema common/schema/service.capnp specifies the calls. This header has the schema's structs
// as C++ values, so that no code outside common/rpc uses Cap'n Proto. handler.h has the service's
// side of the calls, and client.h the client's side.
//
// Invariants
//   1. Repeating a call has no further effect. A submission has a key that its client chose, and
//      all values that calls set are absolute. A client may therefore repeat a call whose answer
//      was lost.
//   2. Text for people consists of whole sentences without control characters, and doesn't mention
//      internals of the service.
//   3. Enumerations have the value `unknown`, for values that only a newer program knows.
//
// Times are seconds since 1970 by the service's wall clock. They are for display only.
//
// Thread safety: values.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/ids.h"
#include "common/events/run_event.h"
#include "common/request/diagnostic.h"

namespace sleight::rpc {

using JobId = base::Id<struct JobTag, std::uint64_t>;      ///< from 1; written 17
using GroupId = base::Id<struct GroupTag, std::uint64_t>;  ///< from 1; written g5

// ------------------------------------------------------------------------------------- refusals

enum class RefusalKind : std::uint8_t {
  unknown,
  not_found,    ///< no such job, group, recording or call
  not_allowed,  ///< belongs to another user
  bad_request,  ///< for a request's text with `diagnostics`
  conflict,     ///< wrong state, or the key of another submission
  limit,        ///< of the user or the service: too many or too large
  busy,         ///< temporary: the same call may succeed later
  gone,         ///< existed and was deleted
  environment,  ///< the disk is full, the backend is away
  bug,          ///< the service failed; see its log
};
inline constexpr std::size_t k_refusal_kinds = 10;

std::string_view name_of(RefusalKind kind);

struct Refusal {
  RefusalKind kind = RefusalKind::bug;
  std::string sentence{};    ///< what is wrong
  std::string what_to_do{};  ///< may be empty
  /// Errors in a submitted request, as `sleight check` reports them. `file` is the request's name.
  std::vector<request::Diagnostic> diagnostics{};
  bool operator==(const Refusal&) const = default;
};

// ------------------------------------------------------------------------------------ submitting

/// An option such as Slurm's partition, for the system that runs the job.
struct JobOption {
  std::string name{};
  std::string value{};
  bool operator==(const JobOption&) const = default;
};

struct JobAsk {
  std::string name{};                    ///< for people; empty: the request's world
  std::string request{};                 ///< TOML text with overrides applied, never a path
  std::optional<std::uint32_t> cores{};  ///< requested number; empty: all free cores
  std::uint32_t ranks = 0;               ///< MPI ranks; 0: one process, no MPI
  std::uint64_t memory_bytes = 0;        ///< for the caches of all processes; 0: the default
  std::int32_t priority = 0;             ///< among one user's jobs; higher runs first
  bool strict = false;                   ///< a failed simulation ends the job
  std::vector<JobOption> options{};      ///< at most k_options_max, each name once
  bool operator==(const JobAsk&) const = default;
};

struct Submission {
  /// Random key that the client draws; at most k_key_bytes_max bytes. If the user has already
  /// submitted jobs with this key, the service returns the first answer and submits nothing.
  std::string key{};
  /// Several jobs form a group. The service accepts either all jobs or none.
  std::vector<JobAsk> jobs{};
  bool is_group = false;  ///< true also for a group of one, as with --set sampler.seed=1..1
  bool operator==(const Submission&) const = default;
};

struct Submitted {
  std::vector<JobId> jobs{};  ///< in the submission's order
  std::optional<GroupId> group{};
  bool was_known = false;  ///< the key was used before
  bool operator==(const Submitted&) const = default;
};

struct Target {
  std::optional<JobId> job{};
  std::optional<GroupId> group{};  ///< REQUIRES: exactly one of job and group
  static Target of(JobId id) { return {.job = id}; }
  static Target of(GroupId id) { return {.group = id}; }
  bool operator==(const Target&) const = default;
};

// ------------------------------------------------------------------------------------------ jobs

enum class JobState : std::uint8_t {
  unknown,
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

std::string_view name_of(JobState state);
std::optional<JobState> job_state_of(std::string_view name);

/// Returns whether the state is final. Only extending or resuming the job changes a final state.
constexpr bool is_settled(JobState state) {
  return state == JobState::done || state == JobState::failed || state == JobState::cancelled;
}

/// A job's changes are numbered from 1 without gaps, and are durable before they are reported.
struct StateChange {
  std::uint64_t number = 0;
  double time_s = 0;
  JobState state = JobState::unknown;
  std::string reason{};
  std::uint64_t attempt = 0;
  bool operator==(const StateChange&) const = default;
};

/// Numbers of solutions. `found` counts a search's solutions, `in_proportion` the chains'
/// independent solutions.
struct SolutionCounts {
  std::uint64_t found = 0;
  std::uint64_t found_wanted = 0;  ///< 0: none requested
  std::uint64_t in_proportion = 0;
  std::uint64_t in_proportion_wanted = 0;
  bool operator==(const SolutionCounts&) const = default;
};

struct FailureCount {
  std::string simulation{};  ///< the failure kind's name (plan/failure.h)
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
  std::string reason{};       ///< why the job is in this state
  std::uint64_t place = 0;    ///< in the queue, from 1; 0: not queued
  std::string not_yet{};      ///< why the job does not run yet, and from when it might
  std::uint64_t attempt = 0;  ///< number of the newest start; 0: none yet
  std::int32_t priority = 0;
  std::optional<std::uint32_t> cores_wanted{};
  std::uint32_t cores = 0;  ///< cores in use now
  std::uint32_t ranks = 0;
  std::uint64_t memory_bytes = 0;
  bool strict = false;
  bool pinned = false;  ///< exempt from the deletion of finished jobs

  std::uint64_t scans_done = 0;   ///< committed
  std::uint64_t scans_total = 0;  ///< 0: unknown from the stop rule
  SolutionCounts solutions{};
  std::vector<FailureCount> failures{};
  double simulations_per_s = 0;
  std::optional<double> left_s{};            ///< until the end, by scans
  std::optional<double> solutions_left_s{};  ///< until enough solutions

  double core_s = 0;  ///< processor time of all attempts
  double submitted_s = 0;
  double started_s = 0;     ///< first start; 0: not started
  double ended_s = 0;       ///< 0: not ended
  std::uint64_t bytes = 0;  ///< size of the job's folder
  double deleted_at_s = 0;  ///< announced deletion; 0: not announced
  std::string digest{};     ///< of the newest archive's content; empty: no archive
  std::string results_version{};
  std::string end_words{};                    ///< the run's message at its end
  std::vector<std::string> last_log_lines{};  ///< of a failed job; at most k_last_log_lines
  std::string repeat_command{};               ///< of a failed job: command to reproduce the failure
  std::vector<StateChange> history{};         ///< only in `status`; newest changes, oldest first
  bool operator==(const JobView&) const = default;
};

/// Selects jobs that meet all given conditions.
struct ListAsk {
  std::optional<GroupId> group{};
  std::optional<std::uint32_t> user{};  ///< empty: all that the caller may see
  std::vector<JobState> states{};       ///< empty: any
  std::string name_part{};              ///< empty: any
  bool oldest_first = false;
  std::uint32_t count = 100;  ///< capped at k_page_jobs_max
  std::string cursor{};       ///< from the page before; empty: the first page
  bool operator==(const ListAsk&) const = default;
};

struct JobPage {
  std::vector<JobView> jobs{};  ///< without histories
  std::string cursor{};         ///< of the next page; empty: last page
  std::uint64_t total = 0;      ///< matching jobs on all pages
  bool operator==(const JobPage&) const = default;
};

/// A call's effect on a job. The call names the job or its group.
struct Touched {
  JobId job{};
  JobState state = JobState::unknown;  ///< after the call
  std::string words{};                 ///< "stops at the next scan"
  bool operator==(const Touched&) const = default;
};

enum class ExtendBy : std::uint8_t { unknown, scans, rounds, solutions, odds };

/// A new limit in the normalised request's [stop]. It is absolute, not an increase. For `odds`, the
/// limit is the relative error.
struct Extension {
  ExtendBy by = ExtendBy::unknown;
  double to = 0;  ///< whole number, except for odds
  bool operator==(const Extension&) const = default;
};

enum class ChangeKind : std::uint8_t {
  unknown,
  cancel,  ///< stops cleanly and ends, with an archive of the results so far
  hold,    ///< stops cleanly, until `resume`
  resume,  ///< queues a held, failed or cancelled job again
  extend,  ///< raises [stop]; queues an ended job again
  erase,   ///< deletes an ended job and all its data
  pin,     ///< exempts the job from the deletion of finished jobs
  unpin,
  set_priority,
};
inline constexpr std::size_t k_change_kinds = 9;

std::string_view name_of(ChangeKind kind);

struct ChangeAsk {
  Target target{};
  ChangeKind kind = ChangeKind::unknown;
  Extension extension{};      ///< for extend
  std::int32_t priority = 0;  ///< for set_priority
  bool operator==(const ChangeAsk&) const = default;
};

// ---------------------------------------------------------------------------------------- watching

/// How far a watcher has received a job's events and state changes.
struct WatchPoint {
  JobId job{};
  std::uint64_t event = 0;   ///< number of the last numbered event received
  std::uint64_t change = 0;  ///< number of the last state change received
  /// Copied from the previous batch: the service's mark for unnumbered events. 0: there was no
  /// batch. A service that does not recognise the mark sends the newest events.
  std::uint64_t mark = 0;
  bool operator==(const WatchPoint&) const = default;
};

// -------------------------------------------------------------------------------------------- logs

/// Requests either the last lines of a log, or bytes from an offset on. Offsets count all bytes
/// that the job has ever logged. The service stores only the newest bytes.
struct LogAsk {
  JobId job{};
  std::optional<std::uint64_t> from{};  ///< empty: the last `lines`
  std::uint32_t lines = 50;
  std::uint32_t bytes_max = 256U << 10U;  ///< capped at k_log_bytes_max
  bool operator==(const LogAsk&) const = default;
};

struct LogPiece {
  /// Offset of the first byte. If the requested bytes are lost, the offset is larger than
  /// requested.
  std::uint64_t first = 0;
  std::string text{};
  std::uint64_t end = 0;  ///< current end of the log
  bool is_over = false;   ///< nothing will follow `end`
  bool operator==(const LogPiece&) const = default;
};

// ---------------------------------------------------------------------------------------- fetching

enum class FetchKind : std::uint8_t {
  unknown,
  archive,        ///< newest archive
  so_far,         ///< archive made now of all committed results
  recordings,     ///< of the kept animations in `ids`
  failure_files,  ///< inputs for `sleight replay`
};

struct FetchAsk {
  JobId job{};
  FetchKind kind = FetchKind::archive;
  std::vector<std::uint64_t> ids{};  ///< of recordings; at most k_fetch_ids_max
  std::string after{};               ///< only files after this name; empty: from the first
  /// SHA-256, in hexadecimal, of a file of which the client already has a part. The service sends
  /// that file if it still exists.
  std::string sha256_wanted{};
  bool operator==(const FetchAsk&) const = default;
};

struct FileView {
  std::string name{};
  std::uint64_t size = 0;
  std::string sha256{};  ///< of the content, hexadecimal
  bool operator==(const FileView&) const = default;
};

// ------------------------------------------------------------------------------------------ tokens

/// Permissions of a session that logged in with a token, as bits. No scope includes another.
enum class Scope : std::uint8_t {
  unknown = 0,
  read = 1,  ///< list, status, watch, logs, fetch, info
  submit = 2,
  manage = 4,   ///< change
  operate = 8,  ///< drain and stop, if the user may
};
inline constexpr Scope k_scopes[] = {Scope::read, Scope::submit, Scope::manage, Scope::operate};

std::string_view name_of(Scope scope);
std::optional<Scope> scope_of(std::string_view name);

struct Scopes {
  std::uint8_t bits = 0;
  bool has_unknown = false;  ///< in a message: contains a scope unknown to this program

  static constexpr Scopes all() { return {.bits = 15}; }
  constexpr bool has(Scope scope) const { return (bits & static_cast<std::uint8_t>(scope)) != 0; }
  constexpr void add(Scope scope) {
    bits = static_cast<std::uint8_t>(bits | static_cast<std::uint8_t>(scope));
  }
  bool operator==(const Scopes&) const = default;
};

struct TokenAsk {
  std::string token{};  ///< complete token, drawn by the client (token_text.h)
  std::string name{};
  std::optional<std::uint32_t> for_user{};  ///< uid; empty: the caller's own
  Scopes scopes{};
  double valid_s = 0;           ///< 0: no expiry
  std::uint32_t jobs_max = 0;   ///< unfinished jobs of this token; 0: the user's limit
  std::uint32_t cores_max = 0;  ///< per job of this token; 0: the user's limit
  bool operator==(const TokenAsk&) const = default;
};

struct TokenView {
  std::string id{};
  std::string name{};
  std::uint32_t user = 0;
  Scopes scopes{};
  double created_s = 0;
  double expires_s = 0;      ///< 0: never
  bool has_expired = false;  ///< stays true if the clock is set back
  double revoked_s = 0;      ///< 0: not revoked
  double last_used_s = 0;    ///< 0: never
  std::string last_from{};
  std::uint32_t jobs_max = 0;
  std::uint32_t cores_max = 0;
  bool operator==(const TokenView&) const = default;
};

// ------------------------------------------------------------------------------------------ server

struct NamedLimit {
  std::string name{};
  std::string value{};  ///< with unit: "16 cores", "10 GB"
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
  std::string keeping_rule{};  ///< for people: how long finished jobs are kept
  std::vector<NamedLimit> limits{};
  std::vector<StateCount> counts{};
  std::uint32_t connections = 0;
  std::uint32_t watchers = 0;
  std::string address{};      ///< TCP address; empty: not listening
  std::string fingerprint{};  ///< of the TLS certificate
  bool operator==(const ServerView&) const = default;
};

// ------------------------------------------------------------------------------------------ limits

inline constexpr std::size_t k_key_bytes_max = 64;
inline constexpr std::size_t k_name_bytes_max = 256;
inline constexpr std::size_t k_request_bytes_max = 1U << 20U;     ///< per job
inline constexpr std::size_t k_submission_bytes_max = 3U << 20U;  ///< per submission
inline constexpr std::size_t k_submission_jobs_max = 1000;
inline constexpr std::size_t k_page_jobs_max = 500;
inline constexpr std::size_t k_watch_jobs_max = 1000;  ///< per watch
inline constexpr std::size_t k_batch_events_max = 256;
inline constexpr std::size_t k_log_bytes_max = 512U << 10U;
inline constexpr std::size_t k_last_log_lines = 50;
inline constexpr std::size_t k_fetch_ids_max = 10'000;
inline constexpr std::size_t k_fetch_files_max = 64;  ///< per call
inline constexpr std::size_t k_piece_bytes_max = 1U << 20U;
/// Longer texts and lists in views are truncated, so that an answer stays readable.
inline constexpr std::size_t k_text_bytes_max = 64U << 10U;
inline constexpr std::size_t k_history_max = 1000;
inline constexpr std::size_t k_options_max = 32;        ///< backend options per job
inline constexpr std::size_t k_option_bytes_max = 256;  ///< per name or value
inline constexpr std::size_t k_tokens_max = 1000;       ///< per user and per answer
/// Not a uid: the system uses this value for "unchanged".
inline constexpr std::uint32_t k_no_user = UINT32_MAX;
inline constexpr double k_token_s_max = 3650.0 * 86400;

/// Returns whether a fetched file may have this name. A valid name has no folder, is not hidden,
/// has no control characters, and has at most k_name_bytes_max bytes.
bool is_file_name(std::string_view name);

}  // namespace sleight::rpc
