#include "service/jobs/ends.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "common/base/check.h"
#include "common/base/error.h"

namespace sleight::jobs {
namespace {

bool is_asked(const Job& job) {
  return job.state == State::yielding;
}

/// Returns the number of consecutive deaths without a commit. The current death counts.
std::uint32_t deaths_with_this(const Job& job) {
  return job.deaths == 0 || job.counts.scans > job.scans_at_death ? 1 : job.deaths + 1;
}

std::string with_log(std::string words, std::string_view log_end, std::string_view repeat) {
  if (!log_end.empty()) words += fmt::format("\nThe log ends with:\n{}", log_end);
  if (!repeat.empty()) words += fmt::format("\nTo repeat the failure, run: {}", repeat);
  return words;
}

/// The job starts again, unless its stop was requested.
Verdict goes_on(const Job& job, const Verdict& else_) {
  if (!is_asked(job)) return else_;
  const State to = state_after_stop(job.reason);
  Verdict verdict = else_;
  verdict.to = to;
  if (to == State::queued && else_.backs_off) return verdict;  // the reason explains the wait
  verdict.reason = job.reason;
  verdict.words = job.words;
  if (to == State::cancelled) verdict.words = "Cancelled.";
  return verdict;
}

/// The job fails, because any restart would end in the same way.
Verdict fails(const Job& job, Reason reason, std::string words) {
  if (is_asked(job) && job.reason == Reason::cancel_asked)
    return {.to = State::cancelled, .reason = Reason::cancel_asked, .words = "Cancelled."};
  return {.to = State::failed, .reason = reason, .words = std::move(words)};
}

/// The job is held until its hindrance is gone.
Verdict is_hindered(const Job& job, Reason reason, std::string words) {
  Verdict verdict{
      .to = State::held, .reason = reason, .words = std::move(words), .backs_off = true};
  if (is_asked(job) && state_after_stop(job.reason) != State::queued) return goes_on(job, verdict);
  return verdict;
}

/// A batch system took the job's cores, or somebody cancelled the job there. Not the job's fault.
Verdict ends_outside(const Job& job, Outside outside, const std::string& how) {
  if (outside == Outside::cancelled)
    return goes_on(job, {.to = State::held,
                         .reason = Reason::cancelled_outside,
                         .words = fmt::format("The job was cancelled in the batch system. {}{}To "
                                              "continue the job, run `sleight resume {}`.",
                                              how, how.empty() ? "" : ". ", job.id)});
  return goes_on(
      job, {.to = State::queued,
            .reason = Reason::taken_away,
            .words = fmt::format(
                "The batch system took the job's cores. {}{}The job resumes automatically.", how,
                how.empty() ? "" : ". "),
            .backs_off = job.counts.scans <= job.scans_at_attempt});
}

/// If the sentence lacks a period, adds one.
std::string sentence(std::string words) {
  if (!words.empty() && std::string_view(".!?").find(words.back()) == std::string_view::npos)
    words += '.';
  return words;
}

Verdict dies(const Job& job, const std::string& how, std::string_view log_end,
             std::string_view repeat, const Options& options) {
  const std::uint32_t deaths = deaths_with_this(job);
  if (deaths >= options.deaths_max) {
    Verdict verdict =
        fails(job, Reason::died,
              with_log(fmt::format("The job failed {} times without progress. The last failure: {}",
                                   deaths, how),
                       log_end, repeat));
    verdict.is_death = true;
    return verdict;
  }
  return goes_on(job, {.to = State::queued,
                       .reason = Reason::died,
                       .words = fmt::format("{} The job restarts automatically.", sentence(how)),
                       .backs_off = true,
                       .is_death = true});
}

std::string how_it_ended(const Ended& ended) {
  if (ended.signal != 0) return fmt::format("Signal {} killed the program.", ended.signal);
  if (!ended.words.empty()) return fmt::format("The program failed: {}", ended.words);
  return fmt::format("The program exited with code {} and left no record of its end.",
                     ended.exit_code);
}

const std::string k_disk_full =
    "The disk is full. Free some space (`sleight delete` deletes finished jobs). The job then "
    "resumes automatically.";
const std::string k_other_results =
    "The results version of the installed programs differs from the run's. The job resumes "
    "automatically after the run's version is installed. Otherwise, submit the request again.";

Verdict judge_error(const Job& job, const Ended& ended, const Surroundings& around,
                    const Options& options) {
  using base::ExitCode;
  const auto code = static_cast<ExitCode>(ended.exit_code);
  if (ended.hindrance == Hindrance::other_results ||
      (code == ExitCode::conflict && around.has_other_results))
    return is_hindered(job, Reason::other_results, k_other_results);
  if (ended.hindrance == Hindrance::disk_full ||
      (code == ExitCode::environment && around.is_disk_low))
    return is_hindered(job, Reason::disk_full, k_disk_full);
  if (ended.hindrance == Hindrance::store_damaged)
    return fails(
        job, Reason::refused_by_program,
        with_log(fmt::format("The run store is damaged: {} Submit the job again. Archives that the "
                             "run wrote are still available (`sleight fetch {}`).",
                             ended.words, job.id),
                 {}, ended.repeat));
  if (code == ExitCode::usage || code == ExitCode::bad_request || code == ExitCode::bad_archive)
    return fails(
        job, Reason::refused_by_program,
        with_log(fmt::format("The program rejected the job: {}", ended.words), {}, ended.repeat));
  return dies(job, how_it_ended(ended), ended.log_end, ended.repeat, options);
}

Verdict judge_bug(const Job& job, const Ended& ended, const Options& options) {
  const std::string how = fmt::format("A check failed at {}: {}", ended.place, ended.words);
  const bool is_again =
      !ended.place.empty() && ended.place == job.bug_place && job.counts.scans <= job.scans_at_bug;
  Verdict verdict =
      is_again ? fails(job, Reason::bug,
                       with_log(fmt::format("{} The same check failed twice without progress in "
                                            "between. This is a bug in Sleight.",
                                            sentence(how)),
                                ended.log_end, ended.repeat))
               : dies(job, how, ended.log_end, ended.repeat, options);
  verdict.is_death = true;
  verdict.is_bug = true;
  return verdict;
}

}  // namespace

State state_after_stop(Reason reason) {
  switch (reason) {
    case Reason::cancel_asked:
      return State::cancelled;
    case Reason::hold_asked:
    case Reason::disk_low:
    case Reason::limit_core_hours:
    case Reason::limit_bytes:
      return State::held;
    default:
      return State::queued;
  }
}

Verdict judge(const Job& job, const Ended& ended, const Surroundings& around,
              const Options& options) {
  switch (ended.kind) {
    case EndKind::finished:
      if (job.attempt_revision < job.revision)
        return goes_on(
            job,
            {.to = State::queued,
             .reason = Reason::extended,
             .words = "The original request is finished. The job continues with the extension."});
      return {.to = State::done, .reason = Reason::finished, .words = ended.words};
    case EndKind::gave_up:
      if (job.counts.found + job.counts.solutions > 0)
        return {.to = State::done, .reason = Reason::gave_up, .words = ended.words};
      return fails(job, Reason::gave_up, ended.words);
    case EndKind::no_draws:
      return fails(job, Reason::no_draws, ended.words);
    case EndKind::simulation_failed:
      return fails(job, Reason::simulation_failed, with_log(ended.words, {}, ended.repeat));
    case EndKind::time_limit:
    case EndKind::stop_requested:
      if (ended.outside != Outside::nothing)
        return ends_outside(job, ended.outside, ended.outside_words);
      // If nothing was committed, delay the restart: signals from outside might stop the job again
      // and again.
      return goes_on(job,
                     {.to = State::queued,
                      .reason = Reason::stopped_by_itself,
                      .words = "A signal stopped the job. The job restarts automatically.",
                      .backs_off = !is_asked(job) && job.counts.scans <= job.scans_at_attempt});
    case EndKind::failed:
      return judge_error(job, ended, around, options);
    case EndKind::bug:
      return judge_bug(job, ended, options);
    case EndKind::none:
      if (ended.outside != Outside::nothing && ended.hindrance == Hindrance::none)
        return ends_outside(job, ended.outside, ended.outside_words);
      return ended.hindrance != Hindrance::none
                 ? judge_error(job, ended, around, options)
                 : dies(job, how_it_ended(ended), ended.log_end, ended.repeat, options);
  }
  CHECK(false);
}

Verdict judge(const Job& job, const Died& died, const Options& options) {
  if (died.outside != Outside::nothing) return ends_outside(job, died.outside, died.words);
  const std::string how =
      died.words.empty() ? "The program was killed together with its keeper." : died.words;
  return dies(job, how, died.log_end, died.repeat, options);
}

Verdict judge(const Job& job, const LaunchFailed& failed, const Surroundings& around,
              const Options& options) {
  if (failed.is_backend_away)
    return is_hindered(job, Reason::backend_away,
                       "No job can start now. The job starts automatically as soon as possible. "
                       "`sleight server status` shows the server's state.");
  if (failed.hindrance == Hindrance::other_results || around.has_other_results)
    return is_hindered(job, Reason::other_results, k_other_results);
  if (failed.hindrance == Hindrance::disk_full || around.is_disk_low)
    return is_hindered(job, Reason::disk_full, k_disk_full);
  return dies(job, fmt::format("The job could not start: {}", failed.words), {}, {}, options);
}

Verdict judge_unbegun(const Job& job, const Options& options) {
  return dies(job, "The job's keeper was started several times, but no attempt began.", {}, {},
              options);
}

double count_end(Job& job, const Verdict& verdict, const std::string& place, double lived_s,
                 const Options& options) {
  const bool has_committed = job.counts.scans > job.scans_at_attempt;
  job.fruitless = has_committed ? 0 : job.fruitless + 1;
  if (verdict.is_death) {
    job.deaths = deaths_with_this(job);
    job.scans_at_death = job.counts.scans;
  } else if (has_committed) {
    job.deaths = 0;
  }
  if (verdict.is_bug) {
    job.bug_place = place;
    job.scans_at_bug = job.counts.scans;
  }
  if (!verdict.backs_off) {
    if (has_committed) job.back_offs = 0;
    return 0;
  }
  if (lived_s >= options.steady_s) job.back_offs = 0;
  const auto doublings = static_cast<int>(std::min(job.back_offs, k_doublings_max));
  ++job.back_offs;
  return std::min(options.back_off_last_s, std::ldexp(options.back_off_first_s, doublings));
}

}  // namespace sleight::jobs
