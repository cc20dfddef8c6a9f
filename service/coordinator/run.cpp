#include "service/coordinator/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/base/version.h"
#include "common/events/event_log.h"
#include "common/logging/log.h"
#include "common/store/run_lock.h"
#include "common/store/run_store.h"
#include "common/store/stored_motions.h"
#include "service/coordinator/checkpoints.h"
#include "service/coordinator/derive.h"
#include "service/coordinator/failure_files.h"
#include "service/coordinator/output_place.h"
#include "service/coordinator/run_events.h"
#include "service/coordinator/writing_words.h"

namespace sleight::coordinator {
namespace {

/// Refuses a foreign output. `fresh`: deletes an earlier run. REQUIRES: the folder's lock is held.
void claim_output(const std::string& output, const std::string& folder, bool fresh,
                  base::FileSystem& files) {
  const std::string database = store::RunStore::database_path(folder);
  const bool has_run = files.exists(database);
  if (files.exists(output) && !has_run) {
    throw base::Error(base::ExitCode::conflict,
                      fmt::format("{}: not overwritten, because its run store {} is missing; move "
                                  "the file away, or choose another output",
                                  output, database));
  }
  if (!fresh || !has_run) return;
  if (files.exists(output)) refuse_foreign_file(output, {""});
  logging::info(fmt::format("--fresh: deleting the earlier run of {}", output));
  // Delete the archive first. If only the store were deleted, the archive would be refused above.
  files.remove(output);
  // Next, delete the database before its log. A database without its log may be inconsistent.
  for (const char* suffix : {"", "-wal", "-shm"}) {
    files.remove(database + suffix);
    files.remove(store::StoredMotions::path(folder) + suffix);
  }
  FailureFiles::remove_all(folder, files);
  files.remove(events::event_log_path(folder));
  files.remove(events::old_event_log_path(folder));
}

/// Deletes unfinished archives that killed processes left. While the lock is held, no other process
/// writes. If a file can't be deleted, logs a warning and continues.
void remove_leftovers(const std::string& output, base::FileSystem& files) {
  const std::string folder = base::directory_of(output);
  const std::string beginning = output.substr(output.find_last_of('/') + 1) + ".tmp.";
  const auto attempt = [](const auto& act) {
    try {
      act();
    } catch (const base::Error& failure) {
      logging::warn(
          fmt::format("can't delete temporary archives of killed processes: {}", failure.what()));
    }
  };
  std::vector<std::string> names;
  attempt([&] { names = files.names_in(folder); });
  for (const std::string& name : names) {
    if (name.starts_with(beginning)) attempt([&] { files.remove(folder + "/" + name); });
  }
}

void say_failure(const plan::ReplicaKey& replica, const plan::FailedSimulation& failed,
                 const std::optional<std::string>& path) {
  logging::warn(fmt::format(
      "a simulation failed because of a simulator bug, and its state is discarded: {}: {} (chain "
      "{}, replica {}, scan {}); {}",
      plan::name_of(failed.failure.kind), failed.failure.message, replica.chain.value,
      replica.replica.value, failed.scan.value,
      path ? "to repeat it: sleight replay " + *path
           : "the maximum number of failure files is reached"));
}

/// Logs why the run waits for blocks in progress.
void say_stopping() {
  logging::info(
      fmt::format("stopping: waiting up to {:g} s for results, then writing the archive; the next "
                  "session computes the rest",
                  k_stop_grace_s));
}

/// If an earlier session made more scans than this archive has, says so.
void say_what_is_left_out(store::RunStore& run_store, const std::string& output,
                          std::uint64_t scans) {
  std::optional<std::uint64_t> stored;
  for (const store::ReplicaProgress& at : run_store.progress()) {
    if (at.replica.chain.value < plan::k_first_lane)
      stored = std::min(stored.value_or(at.next_scan), at.next_scan);
  }
  if (stored.value_or(0) <= scans) return;
  logging::info(
      fmt::format("{}: contains the first {} scans of each chain, as requested; the run store has "
                  "{} scans of each chain",
                  output, scans, *stored));
}

/// Stores failures as files. Logs only the first failure. Progress and summary count all failures.
class FailureNotes {
 public:
  FailureNotes(const std::string& folder, const std::string& request_text, base::FileSystem& files)
      : files_(folder, request_text, files) {}
  void note(const plan::ReplicaKey& replica, const plan::FailedSimulation& failed) {
    const std::optional<std::string> path = files_.keep(replica, failed);
    if (std::exchange(any_, true)) return;
    first_path_ = path.value_or("");
    say_failure(replica, failed, path);
  }
  std::string file_of(const plan::ReplicaKey& replica, base::ScanIndex scan,
                      plan::FailureKind kind) const {
    return files_.path_of(replica, scan, kind);
  }
  /// Returns the file of the first failure. Empty: there was no failure, or it has no file.
  const std::string& first_path() const { return first_path_; }

 private:
  FailureFiles files_;
  std::string first_path_;
  bool any_ = false;
};

}  // namespace

std::string run_folder(const std::string& output) {
  return output + ".run";
}

namespace {

/// Drives the plan from the store's state, and derives the archive.
RunSummary drive_and_derive(const RunInputs& inputs, const RunOptions& options,
                            const std::string& folder, store::RunLock& lock,
                            store::RunStore& run_store, FailureNotes& failures,
                            RunEvents& run_events) {
  base::FileSystem& files = inputs.files;
  lock.keep();  // there are no forks after this point
  if (run_store.epoch() > 1) run_events.say("reading results of earlier sessions");
  double motions_s = 0;  // used by the checkpoints' thread while that runs
  const auto archive_of = [&](request::Cut cut, const std::function<bool()>& stop,
                              const archive::HearWriting& hear) {
    const DeriveInputs derive{.request = inputs.request,
                              .reader = inputs.reader,
                              .plan_of = inputs.plan_of,
                              .files = files,
                              .results_version = inputs.results_version,
                              .motions_s = &motions_s,
                              .store = run_store.to_read(),
                              .fence = [&lock] { lock.check(); },
                              .hear = hear};
    std::string digest = derive_archive(derive, folder, options.output, cut, stop);
    if (!digest.empty())
      run_events.archive_written({.digest = digest, .scans = cut.scans, .found = cut.found});
    return std::pair(std::move(digest), cut.scans);
  };
  Checkpoints checkpoints(
      [&](const request::Cut& reached, const std::atomic<bool>& stop) {
        run_store.flush();  // the cut may not be committed yet
        motions_s = 0;
        const std::string digest = archive_of(reached, [&stop] { return stop.load(); }, {}).first;
        return Checkpoints::Made{.archive = !digest.empty(), .motions_s = motions_s};
      },
      inputs.clock, options.checkpoint_every_s, files.exists(options.output));
  const DriveOptions drive_options{
      .time_limit_s = options.time_limit_s,
      .stop_requested = options.stop_requested,
      .stopping = [] { say_stopping(); },
      .report = [&](const events::Progress& now) { run_events.show(now); },
      .log_natural_throw = inputs.reader.layout().log_natural_throw,
      .standing =
          [&](const Standing& now) {
            checkpoints.offer(now);
            run_events.advance(inputs.plan);
          },
      .consumed = [&](const auto& replica, base::ScanIndex first,
                      auto records) { run_events.consumed(replica, first, records); },
      .failed = [&](const auto& replica, const auto& failed) { failures.note(replica, failed); },
      .strict = options.strict};
  const DriveOutcome outcome =
      drive(inputs.plan, run_store, inputs.crew, inputs.clock, drive_options);
  checkpoints.stop();
  run_events.advance(inputs.plan);

  // Derive an archive of the scans that every chain has.
  RunSummary summary{.end = outcome.end,
                     .scans = outcome.reached.scans,
                     .found = outcome.reached.found,
                     .relaxed = outcome.reached.relaxed,
                     .digest = {},
                     .epoch = run_store.epoch(),
                     .first_failure = failures.first_path(),
                     .progress = outcome.progress,
                     .handling = outcome.handling};
  if (summary.scans > 0 || summary.found > 0) {
    run_events.say(k_writing);
    WritingWords words([&](const std::string& phase) { run_events.say(phase); }, inputs.clock);
    // After a stop request, the run still writes its archive. A second signal prevents this.
    const bool is_stopping = summary.end == DriveEnd::stop_requested;
    try {
      std::tie(summary.digest, summary.scans) = archive_of(
          outcome.reached, is_stopping ? std::function<bool()>() : options.stop_requested,
          [&words](const archive::WritingProgress& now) { words.hear(now); });
    } catch (const DeriveStopped&) {
      summary.is_archive_given_up = true;
      if (summary.end != DriveEnd::simulation_failed) summary.end = DriveEnd::stop_requested;
    }
    if (summary.end == DriveEnd::finished && inputs.request.sampler.chains > 0)
      say_what_is_left_out(run_store, options.output, outcome.reached.scans);
  }
  return summary;
}

events::End end_of(const RunSummary& summary) {
  switch (summary.end) {
    case DriveEnd::finished:
      if (summary.progress.finds.is_all && summary.progress.finds.gave_up)
        return events::End::gave_up;
      return summary.digest.empty() ? events::End::no_draws : events::End::finished;
    case DriveEnd::time_limit:
      return events::End::time_limit;
    case DriveEnd::stop_requested:
      return events::End::stop_requested;
    case DriveEnd::simulation_failed:
      break;
  }
  return events::End::simulation_failed;
}

/// Explains the run's end to people in one sentence. Empty: no explanation is needed.
std::string words_of(const RunSummary& summary) {
  if (summary.is_archive_given_up)
    return "stopped while writing the archive; any previous archive is unchanged";
  const plan::Finds& finds = summary.progress.finds;
  const plan::Odds& odds = summary.progress.odds;
  switch (end_of(summary)) {
    case events::End::finished:
    case events::End::time_limit:
    case events::End::stop_requested:
      return odds.are_asked ? events::odds_in_words(odds) : "";
    case events::End::gave_up:
      return fmt::format("the search gave up after {} of {} finds. {}", summary.found, finds.wanted,
                         finds.gave_up_because);
    case events::End::no_draws:
      return "all scans are done, but none is a draw: the burn-in needs more scans";
    case events::End::simulation_failed:
      return summary.first_failure.empty()
                 ? "a simulation failed, and --strict ends the run"
                 : fmt::format("a simulation failed; to repeat it: sleight replay {}",
                               summary.first_failure);
    default:
      return {};
  }
}

events::RunEnd record_of(const RunSummary& summary) {
  return {.epoch = summary.epoch,
          .end = end_of(summary),
          .exit_code = exit_code_of(summary.end),
          .scans = summary.scans,
          .found = summary.relaxed > 0 ? summary.relaxed : summary.found,
          .solutions = summary.progress.solutions,
          .digest = summary.digest,
          .words = words_of(summary)};
}

/// Saves the session's end. Even if the store fails, `options.ended` receives the end.
void leave_record(store::RunStore& run_store, RunEvents& run_events, const events::RunEnd& end,
                  const RunOptions& options) {
  try {
    const std::uint64_t number = run_store.close(end);
    run_events.ended(number, end);
    run_events.stop();
  } catch (const base::Error& failure) {
    logging::warn(fmt::format("could not store how this session ended: {}", failure.what()));
  }
  if (options.ended) options.ended(end);
}

}  // namespace

base::ExitCode exit_code_of(DriveEnd end) {
  switch (end) {
    case DriveEnd::finished:
    case DriveEnd::time_limit:
      return base::ExitCode::ok;
    case DriveEnd::stop_requested:
      return base::ExitCode::interrupted;
    case DriveEnd::simulation_failed:
      break;
  }
  return base::ExitCode::simulation_failed;
}

RunSummary run_request(const RunInputs& inputs, const RunOptions& options) {
  base::FileSystem& files = inputs.files;
  const std::string folder = run_folder(options.output);

  // Reserve the output for this process and this request.
  refuse_unusable_place(options.output, files);
  if (files.exists(options.output) && !files.exists(folder)) {
    claim_output(options.output, folder, options.fresh,
                 files);  // refuses without creating a folder
  }
  store::RunLock lock(folder, {.stop_requested = options.stop_requested});
  claim_output(options.output, folder, options.fresh, files);
  remove_leftovers(options.output, files);
  const store::RunIdentity identity{.identity_text = run_identity(inputs.request),
                                    .request_text = request::normalised_text(inputs.request),
                                    .results_version = inputs.results_version,
                                    .program_version = std::string(base::version()),
                                    .chains = inputs.request.sampler.chains};
  store::RunStore run_store(folder, identity, &lock);

  // The store must record the session's end in every case.
  std::optional<FailureNotes> failures;
  const auto file_of = [&](const auto& replica, base::ScanIndex scan, plan::FailureKind kind) {
    return failures->file_of(replica, scan, kind);
  };
  RunEvents run_events(folder, run_store, inputs.clock, options.hear, file_of);
  try {
    failures.emplace(folder, request::normalised_text(inputs.request), files);
    if (files.exists(options.output)) {
      refuse_foreign_file(options.output, beginnings_of(inputs.request));
    }
    RunSummary summary =
        drive_and_derive(inputs, options, folder, lock, run_store, *failures, run_events);
    leave_record(run_store, run_events, record_of(summary), options);
    return summary;
  } catch (const std::exception& error) {
    events::RunEnd end = events::end_by(error);
    end.epoch = run_store.epoch();
    leave_record(run_store, run_events, end, options);
    throw;
  }
}

}  // namespace sleight::coordinator
