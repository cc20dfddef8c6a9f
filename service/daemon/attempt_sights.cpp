#include "service/daemon/attempt_sights.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <string_view>
#include <utility>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/store/damage.h"
#include "common/store/sessions.h"
#include "service/keeper/tool.h"

namespace sleight::daemon {
namespace {

constexpr double k_version_s_max = 10;

/// Returns a stamp of the file. The stamp changes when the file is replaced or written. Empty:
/// there is no file.
std::string stamp_of(const std::string& program) {
  struct stat file {};
  if (::stat(program.c_str(), &file) != 0) return {};
  return fmt::format("{}:{}:{}:{}.{}", file.st_dev, file.st_ino, file.st_size, file.st_mtim.tv_sec,
                     file.st_mtim.tv_nsec);
}

/// Returns the version in the line "results ..." of `program --version`. None: the program can't be
/// run, or it doesn't print the line within k_version_s_max.
std::optional<std::string> results_version_of(const std::string& program) {
  constexpr std::string_view k_before = "\nresults ";
  try {
    const keeper::ToolEnd end = keeper::run_tool(
        {program, "--version"},
        {.seconds_max = k_version_s_max, .environment = keeper::program_environment()});
    const std::size_t at = end.output.find(k_before);
    if (end.exit_code != 0 || at == std::string::npos) return std::nullopt;
    const std::size_t begin = at + k_before.size();
    return end.output.substr(begin, end.output.find('\n', begin) - begin);
  } catch (const base::Error&) {
    return std::nullopt;
  }
}

/// If less space is free than this, a failure of the environment counts as a full disk.
constexpr std::uint64_t k_full_below_bytes = std::uint64_t{16} << 20U;

jobs::EndKind end_kind_of(events::End end) {
  const auto kind = jobs::end_kind_of(std::string(events::name_of(end)));
  CHECK(kind.has_value());
  return *kind;
}

std::string repeat_of(const keeper::AttemptRecord& record, const std::string& folder) {
  return fmt::format("cd {} && {}", folder, fmt::join(record.command, " "));
}

std::string signal_words(const keeper::AttemptEnd& end) {
  switch (end.killed_for) {
    case keeper::KilledFor::lingering:
      return "the program reported its end but did not exit";
    case keeper::KilledFor::without_ranks:
      return "mpirun hung after its ranks had exited";
    default:
      break;
  }
  if (!end.not_started.empty()) return end.not_started;
  if (end.signal) return fmt::format("the program was killed by signal {}", *end.signal);
  if (end.exit_code) return fmt::format("the program exited with code {}", *end.exit_code);
  return "the program ended";
}

}  // namespace

AttemptSights::AttemptSights(Parts parts) : parts_(std::move(parts)) {}

WatchedRun AttemptSights::watch(jobs::JobId job, bool is_found) {
  WatchedRun run{.since_s = parts_.clock.now_s(), .is_found = is_found};
  // Version of the program that was started. The file may have been replaced since.
  run.results_version = is_found ? run_results_version(job) : results_version_;
  const auto& progress = parts_.feeds.of(job).progress();
  run.scans_before = progress ? progress->scans_done : 0;
  return run;
}

std::optional<jobs::Running> AttemptSights::news(jobs::JobId job, WatchedRun& run, double now_s) {
  const bool had_committed = run.first_commit_after_s.has_value();
  if (!run.is_young() && now_s - run.looked_s < k_look_s) return std::nullopt;
  run.looked_s = now_s;
  jobs::Running seen = running(job, run);
  const bool just_committed = !had_committed && run.first_commit_after_s.has_value();
  if (!just_committed && now_s - run.told_s < k_tell_running_s) return std::nullopt;
  if (!just_committed && seen.counts.scans == run.told_scans) return std::nullopt;
  run.told_s = now_s;
  run.told_scans = seen.counts.scans;
  return seen;
}

jobs::LaunchFailed AttemptSights::launch_failed(jobs::JobId job, jobs::Attempt attempt,
                                                const std::string& words) const {
  return {.job = job,
          .attempt = attempt,
          .hindrance = has_no_room(words) ? jobs::Hindrance::disk_full : jobs::Hindrance::none,
          .words = words};
}

jobs::Counts AttemptSights::counts_of(jobs::JobId job, bool thoroughly) {
  const JobFeed& feed = parts_.feeds.read(job, thoroughly);
  jobs::Counts counts;
  if (!feed.progress()) return counts;
  const events::Progress& progress = *feed.progress();
  counts.scans = progress.scans_done;
  counts.found = progress.finds.found;
  counts.solutions = progress.solutions;
  for (std::size_t kind = 0; kind < plan::k_failure_kinds; ++kind) {
    if (progress.failures.by_kind[kind] > 0)
      counts.failures[std::string(plan::k_failure_names[kind])] = progress.failures.by_kind[kind];
  }
  return counts;
}

jobs::Running AttemptSights::running(jobs::JobId job, WatchedRun& run) {
  jobs::Running running{.counts = counts_of(job, false),
                        .first_commit_after_s = run.first_commit_after_s};
  if (run.is_young() && running.counts.scans > run.scans_before) {
    run.first_commit_after_s = parts_.clock.now_s() - run.since_s;
    running.first_commit_after_s = run.first_commit_after_s;
  }
  const double now_s = parts_.clock.now_s();
  if (run.measured_s == 0 || now_s - run.measured_s > k_measure_s) {
    run.measured_s = now_s;
    run.disk_bytes = parts_.folders.bytes(job);
  }
  running.disk_bytes = run.disk_bytes;
  running.results_version = run.results_version;
  return running;
}

bool AttemptSights::has_no_room(const std::string& words) const {
  for (const char* sign : {"No space left", "disk is full", "disk full", "Disk quota"})
    if (words.find(sign) != std::string::npos) return true;
  return disk_free_bytes(parts_.folders.all()) < k_full_below_bytes;
}

std::string AttemptSights::run_results_version(jobs::JobId job) const {
  try {
    return store::stored_request_of(parts_.folders.run(job)).results_version;
  } catch (const base::Error&) {
    return {};  // there is no run yet
  }
}

/// Returns what prevented a run from continuing. None: the run itself failed.
jobs::Hindrance AttemptSights::hindrance_of(jobs::JobId job, const keeper::AttemptEnd& end) const {
  const bool said_why = end.run_end && end.run_end->end == events::End::failed;
  const base::ExitCode code = said_why ? end.run_end->exit_code : base::ExitCode::ok;
  if (code == base::ExitCode::conflict) {
    const std::string version = run_results_version(job);
    if (!version.empty() && !results_version_.empty() && version != results_version_)
      return jobs::Hindrance::other_results;
  }
  const bool may_be_room = code == base::ExitCode::environment || !end.run_end;
  const std::string words = said_why ? end.run_end->words : end.not_started;
  if (may_be_room && has_no_room(words)) return jobs::Hindrance::disk_full;
  if (code == base::ExitCode::environment && store::tells_of_damage(words))
    return jobs::Hindrance::store_damaged;
  return jobs::Hindrance::none;
}

jobs::Ended AttemptSights::ended(jobs::JobId job, const keeper::AttemptRecord& record,
                                 std::optional<double> first_commit_after_s) {
  CHECK(record.end.has_value());
  const keeper::AttemptEnd& end = *record.end;
  jobs::Ended ended{.exit_code = end.exit_code.value_or(0),
                    .signal = end.signal.value_or(0),
                    .hindrance = hindrance_of(job, end),
                    .log_end = fmt::format("{}", fmt::join(end.log_tail, "\n")),
                    .repeat = repeat_of(record, parts_.folders.folder(job)),
                    .counts = counts_of(job, true),
                    .first_commit_after_s = first_commit_after_s,
                    .disk_bytes = parts_.folders.bytes(job),
                    .results_version = run_results_version(job)};
  if (!end.run_end) {
    ended.words = signal_words(end);
    // The program couldn't handle the signal yet, so the signal killed it.
    if (end.stop_asked && end.signal == SIGUSR1) ended.kind = jobs::EndKind::stop_requested;
    return ended;
  }
  const events::RunEnd& told = *end.run_end;
  ended.kind = end_kind_of(told.end);
  ended.digest = told.digest;
  ended.words = told.words;
  ended.place = told.place;
  ended.counts.found = std::max(ended.counts.found, told.found);
  ended.counts.solutions = std::max(ended.counts.solutions, told.solutions);
  return ended;
}

jobs::Died AttemptSights::died(jobs::JobId job, const keeper::AttemptRecord* record,
                               std::string words) {
  return {.words = std::move(words),
          .repeat = record == nullptr ? "" : repeat_of(*record, parts_.folders.folder(job)),
          .counts = counts_of(job, true),
          .disk_bytes = parts_.folders.bytes(job)};
}

std::optional<jobs::BackendNote> AttemptSights::look_at_programs() {
  const std::string& program = parts_.programs.sleight;
  const std::string stamp = stamp_of(program);
  if (programs_stamp_ && stamp == *programs_stamp_) return std::nullopt;
  programs_stamp_ = stamp;
  const std::optional<std::string> version =
      stamp.empty() ? std::nullopt : results_version_of(program);
  results_version_ = version.value_or("");
  return jobs::BackendNote{.is_there = version.has_value(), .results_version = results_version_};
}

}  // namespace sleight::daemon
