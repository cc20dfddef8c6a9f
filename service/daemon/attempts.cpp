#include "service/daemon/attempts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <exception>
#include <utility>
#include <variant>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/logging/log.h"
#include "common/store/damage.h"
#include "common/store/sessions.h"
#include "service/daemon/program_version.h"

namespace sleight::daemon {
namespace {

/// Less than this on the disk, and a failure of the environment is taken for a full one.
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
      return "the program told its end and did not exit";
    case keeper::KilledFor::without_ranks:
      return "mpirun hung after its ranks had gone";
    default:
      break;
  }
  if (!end.not_started.empty()) return end.not_started;
  if (end.signal) return fmt::format("the program was killed by signal {}", *end.signal);
  if (end.exit_code) return fmt::format("the program exited with {}", *end.exit_code);
  return "the program ended";
}

}  // namespace

Attempts::Attempts(Parts parts) : parts_(std::move(parts)) {}

void Attempts::tell(jobs::Input input) {
  parts_.loop.post([this, input = std::move(input)]() mutable { parts_.hear(std::move(input)); });
}

void Attempts::tell_launch_failed(jobs::JobId job, jobs::Attempt attempt,
                                  const std::string& words) {
  tell(jobs::LaunchFailed{
      .job = job,
      .attempt = attempt,
      .hindrance = has_no_room(words) ? jobs::Hindrance::disk_full : jobs::Hindrance::none,
      .words = words});
}

void Attempts::launch(const jobs::Launch& launch) {
  const std::string folder = parts_.folders.folder(launch.job);
  try {
    if (auto note = look_at_programs()) tell(*std::move(note));
    const LaunchText text = parts_.text_of(launch.job, launch.revision);
    parts_.folders.write_request(launch.job, text.request, parts_.files);
    const std::uint64_t cache_bytes =
        launch.memory_bytes > k_process_bytes ? launch.memory_bytes - k_process_bytes : 0;
    const keeper::AttemptSpec spec{
        .folder = folder,
        .attempt = static_cast<std::uint32_t>(launch.attempt.value),
        .cores = std::max(1U, launch.cores),
        .ranks = launch.ranks,
        .cache_mb = cache_bytes >> 20U,
        .strict = text.strict,
    };
    follow(launch.job, launch.attempt, parts_.backend.launch(spec), false);
    await_begin(launch.job, launch.attempt);
  } catch (const base::Error& failure) {
    tell_launch_failed(launch.job, launch.attempt, failure.what());
  }
}

/// Until the keeper has its record it may end and leave nothing: then nothing has begun.
void Attempts::await_begin(jobs::JobId job, jobs::Attempt attempt) {
  const auto run = running_.find(job);
  if (run == running_.end() || run->second.attempt != attempt || run->second.has_begun) return;
  if (look_whether_begun(job, attempt)) {
    run->second.has_begun = true;
    again_.erase(job);
    tell(jobs::Launched{.job = job, .attempt = attempt});
    return;
  }
  again_[job] =
      parts_.loop.call_later(k_again_s, [this, job, attempt] { await_begin(job, attempt); });
}

/// Whether the attempt has a record, or is found to be another's: `see` tells of that.
bool Attempts::look_whether_begun(jobs::JobId job, jobs::Attempt attempt) {
  try {
    return parts_.backend
        .look(parts_.folders.folder(job), static_cast<std::uint32_t>(attempt.value))
        .record.has_value();
  } catch (const base::Error&) {
    return false;  // looks that the machine asks for say so
  }
}

void Attempts::stop(const jobs::Stop& stop) {
  const keeper::Stop how =
      stop.how == jobs::StopHow::now ? keeper::Stop::now : keeper::Stop::in_order;
  try {
    // The keeper's own handle reaches it before it has a record.
    const auto run = running_.find(stop.job);
    if (run != running_.end() && run->second.attempt == stop.attempt) {
      run->second.keeper->stop(how);
      return;
    }
    parts_.backend.stop(parts_.folders.folder(stop.job),
                        static_cast<std::uint32_t>(stop.attempt.value), how);
  } catch (const base::Error& failure) {
    logging::warn(fmt::format("job {}: {}", stop.job.value, failure.what()));
  }
}

void Attempts::look(const jobs::Look& look) {
  see(look.job, look.attempt);
}

/// Tells what the folder says of the attempt, and waits for the keeper of one that runs.
void Attempts::see(jobs::JobId job, jobs::Attempt attempt) {
  const std::string folder = parts_.folders.folder(job);
  const auto number = static_cast<std::uint32_t>(attempt.value);
  jobs::Sight sight{.job = job, .attempt = attempt, .seen = jobs::Unknown{}};
  try {
    keeper::Look seen = parts_.backend.look(folder, number);
    using State = keeper::Look::State;
    if (seen.state == State::running) {
      if (!running_.contains(job)) {
        if (auto keeper = parts_.backend.adopt(folder, number)) {
          follow(job, attempt, *std::move(keeper), true);
        } else {
          // It just begins, or has just gone: a moment later that can be told.
          again_[job] =
              parts_.loop.call_later(k_again_s, [this, job, attempt] { see(job, attempt); });
          return;
        }
      }
    }
    switch (seen.state) {
      case State::never_began:
        sight.seen = jobs::NeverBegan{};
        break;
      case State::running: {
        const auto run = running_.find(job);
        auto running = run == running_.end() ? std::nullopt : running_of(job, run->second);
        sight.seen = running.value_or(jobs::Running{});
        break;
      }
      case State::ended: {
        const auto run = running_.find(job);
        const auto after_s =
            run == running_.end() ? std::nullopt : run->second.first_commit_after_s;
        sight.seen = ended_of(job, *seen.record, after_s);
        break;
      }
      case State::died:
        sight.seen = died_of(job, *seen.record);
        break;
    }
    if (seen.state != State::running) running_.erase(job);
  } catch (const base::Error& failure) {
    logging::warn(fmt::format("job {}: {}", job.value, failure.what()));
  }
  tell(std::move(sight));
}

void Attempts::follow(jobs::JobId job, jobs::Attempt attempt, keeper::RunningKeeper keeper,
                      bool is_found) {
  Run& run = running_[job];
  run = Run();
  run.attempt = attempt;
  run.since_s = parts_.clock.now_s();
  run.is_found = is_found;
  run.has_begun = is_found;
  // Of the program that was started; the one on the disk may be another by now.
  run.results_version = is_found ? run_results_version(job) : results_version_;
  const auto& progress = parts_.feeds.of(job).progress();
  run.scans_before = progress ? progress->scans_done : 0;
  run.keeper = std::move(keeper);
  run.gone =
      parts_.loop.call_when_readable(run.keeper->descriptor(), [this, job] { keeper_gone(job); });
  plan_poll();
}

void Attempts::keeper_gone(jobs::JobId job) {
  const auto run = running_.find(job);
  if (run == running_.end()) return;
  const jobs::Attempt attempt = run->second.attempt;
  const bool had_begun = run->second.has_begun;
  run->second.gone = {};
  if (had_begun || !tell_unbegun(job, attempt)) see(job, attempt);
  running_.erase(job);
}

/// Of a keeper that has gone: tells of an attempt without a record that it couldn't be started.
bool Attempts::tell_unbegun(jobs::JobId job, jobs::Attempt attempt) {
  again_.erase(job);
  try {
    const keeper::Look seen =
        parts_.backend.look(parts_.folders.folder(job), static_cast<std::uint32_t>(attempt.value));
    if (seen.state != keeper::Look::State::never_began) return false;
    tell_launch_failed(job, attempt,
                       seen.words.empty() ? "its keeper ended before it had begun" : seen.words);
    return true;
  } catch (const base::Error&) {
    return false;
  }
}

/// Looks as often as the youngest of the runs needs it.
void Attempts::plan_poll() {
  double every_s = 0;
  for (const auto& [job, run] : running_) {
    const bool is_young = !run.is_found && !run.first_commit_after_s;
    every_s = is_young ? k_look_young_s : every_s == 0 ? k_look_s : every_s;
  }
  if (every_s == poll_every_s_) return;
  poll_every_s_ = every_s;
  polling_ =
      every_s == 0 ? rpc::Loop::Handle() : parts_.loop.call_every(every_s, [this] { poll(); });
}

void Attempts::poll() {
  const double now_s = parts_.clock.now_s();
  end_those_without_folder(now_s);
  for (auto& [job, run] : running_) {
    const bool had_committed = run.first_commit_after_s.has_value();
    const bool is_young = !run.is_found && !had_committed;
    if (!is_young && now_s - run.looked_s < k_look_s) continue;
    run.looked_s = now_s;
    const auto running = running_of(job, run);
    if (!running) continue;
    const bool just_committed = !had_committed && run.first_commit_after_s.has_value();
    if (!just_committed && now_s - run.told_s < k_tell_running_s) continue;
    if (!just_committed && running->counts.scans == run.told_scans) continue;
    run.told_s = now_s;
    run.told_scans = running->counts.scans;
    tell(jobs::Sight{.job = job, .attempt = run.attempt, .seen = *running});
  }
  plan_poll();
}

/// Somebody has deleted their folders: nothing of what they do is kept.
void Attempts::end_those_without_folder(double now_s) {
  std::vector<jobs::JobId> gone;
  for (const auto& [job, run] : running_) {
    if (run.has_begun && now_s - run.looked_s >= k_look_s &&
        !parts_.files.exists(parts_.folders.folder(job)))
      gone.push_back(job);
  }
  for (const jobs::JobId job : gone) {
    const auto run = running_.find(job);
    run->second.keeper->stop(keeper::Stop::now);
    tell(jobs::Sight{
        .job = job,
        .attempt = run->second.attempt,
        .seen = jobs::Died{
            .words = "Its folder was deleted.", .repeat = {}, .counts = {}, .disk_bytes = 0}});
    parts_.feeds.drop(job);
    running_.erase(run);
  }
}

jobs::Counts Attempts::counts_of(jobs::JobId job, bool thoroughly) {
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

std::optional<jobs::Running> Attempts::running_of(jobs::JobId job, Run& run) {
  jobs::Running running{.counts = counts_of(job, false),
                        .first_commit_after_s = run.first_commit_after_s};
  if (!run.is_found && !run.first_commit_after_s && running.counts.scans > run.scans_before) {
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

bool Attempts::has_no_room(const std::string& words) const {
  for (const char* sign : {"No space left", "disk is full", "disk full", "Disk quota"})
    if (words.find(sign) != std::string::npos) return true;
  return disk_free_bytes(parts_.folders.all()) < k_full_below_bytes;
}

std::string Attempts::run_results_version(jobs::JobId job) const {
  try {
    return store::stored_request_of(parts_.folders.run(job)).results_version;
  } catch (const base::Error&) {
    return {};  // there is no run yet
  }
}

/// What kept a run from going on, as far as it isn't the run's own fault.
jobs::Hindrance Attempts::hindrance_of(jobs::JobId job, const keeper::AttemptEnd& end) const {
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

jobs::Ended Attempts::ended_of(jobs::JobId job, const keeper::AttemptRecord& record,
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

jobs::Died Attempts::died_of(jobs::JobId job, const keeper::AttemptRecord& record) {
  return {.words = "Its keeper and its program were killed.",
          .repeat = repeat_of(record, parts_.folders.folder(job)),
          .counts = counts_of(job, true),
          .disk_bytes = parts_.folders.bytes(job)};
}

std::optional<jobs::BackendNote> Attempts::look_at_programs() {
  const std::string& program = parts_.backend.programs().sleight;
  const std::string stamp = stamp_of(program);
  if (programs_stamp_ && stamp == *programs_stamp_) return std::nullopt;
  programs_stamp_ = stamp;
  const std::optional<std::string> version =
      stamp.empty() ? std::nullopt : results_version_of(program);
  results_version_ = version.value_or("");
  return jobs::BackendNote{.is_there = version.has_value(), .results_version = results_version_};
}

}  // namespace sleight::daemon
