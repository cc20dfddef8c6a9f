// Handles observations of open attempts.
#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "service/jobs/jobs.h"

namespace sleight::jobs {
namespace {

/// Rank of a stop's reason. A reason replaces only a reason of lower rank.
int weight(Reason reason) {
  if (reason == Reason::cancel_asked) return 3;
  if (reason == Reason::hold_asked) return 2;
  return state_after_stop(reason) == State::held ? 1 : 0;
}

}  // namespace

void Jobs::take(const Sight& input) {
  const auto found = jobs_.find(input.job);
  if (found == jobs_.end()) return;
  Job& job = found->second;
  const bool is_there =
      std::holds_alternative<Running>(input.seen) || std::holds_alternative<Pending>(input.seen);
  if (!is_active(job.state) || input.attempt < job.attempt) {
    // The folder is still held by an attempt that was presumed dead. Stop the attempt, because
    // newer attempts wait for the folder.
    if (is_there)
      effects_.emplace_back(Stop{.job = job.id,
                                 .attempt = input.attempt,
                                 .how = is_over(job.state) ? StopHow::now : StopHow::in_order});
    return;
  }
  if (input.attempt > job.attempt) {
    // The folder is newer than the job store, for example after the store was restored from a
    // backup. The folder is right.
    job.attempt = input.attempt;
    dirty_.insert(job.id);
  }
  Open& open = open_.at(job.id);
  std::visit([&](const auto& seen) { see(job, open, seen); }, input.seen);
}

void Jobs::take(const Launched& input) {
  const auto found = jobs_.find(input.job);
  if (found == jobs_.end() || !is_active(found->second.state) ||
      found->second.attempt != input.attempt)
    return;
  Job& job = found->second;
  Open& open = open_.at(job.id);
  if (!open.has_begun) begins(job, open);
}

void Jobs::take(const LaunchFailed& input) {
  const auto found = jobs_.find(input.job);
  if (found == jobs_.end() || !is_active(found->second.state) ||
      found->second.attempt != input.attempt)
    return;
  // If the attempt was launched before, another keeper may still begin it, so it stays open.
  const Open& open = open_.at(input.job);
  if (open.has_begun || open.is_pending || open.is_found || open.is_launched_again) return;
  close(found->second, judge(found->second, input, around(found->second), options_));
}

/// The attempt may still begin, so this launches it again, even if it should stop. If a keeper was
/// seen before, NeverBegan is outdated. Repeated NeverBegan means that somebody deleted the record.
void Jobs::see(Job& job, Open& open, const NeverBegan&) {
  if (!std::exchange(open.is_looked_for, false)) return;
  set_pending(job, open, false);
  if (++open.unbegun >= options_.unbegun_max) {
    close(job, judge_unbegun(job, options_));
    return;
  }
  if (!open.has_begun) {
    open.is_launched_again = true;
    launch(job);
  }
  set_alarm(job.id, open, clock_s_ + options_.look_after_launch_s);
}

/// The attempt will begin by itself, unless it is stopped while it is in the batch system's queue.
void Jobs::see(Job& job, Open& open, const Pending& seen) {
  open.is_looked_for = false;
  open.unbegun = 0;
  const bool was_pending = open.is_pending;
  if (!open.has_begun) set_pending(job, open, true);  // else the news is late
  if (job.state == State::starting && job.words != seen.words) {
    job.words = seen.words;
    dirty_.insert(job.id);
  }
  if (!open.stop_asked_s) {
    set_alarm(job.id, open, clock_s_ + options_.look_every_s);
  } else if (open.is_pending && !was_pending) {
    send_stop(job, open);
  }
}

void Jobs::set_pending(Job& job, Open& open, bool is_pending) {
  if (open.is_pending == is_pending) return;
  charge(job, open);
  accounts_.advance(job.user, clock_s_);
  Account& account = accounts_.of(job.user);
  account.cores_waiting += is_pending ? job.cores : 0U;
  account.cores_waiting -= is_pending ? 0U : job.cores;
  dirty_users_.insert(job.user);
  dirty_.insert(job.id);
  open.is_pending = is_pending;
}

void Jobs::see(Job& job, Open& open, const Running& seen) {
  open.is_looked_for = false;
  open.unbegun = 0;
  if (!open.has_begun) begins(job, open);
  const bool had_committed = job.counts.scans > job.scans_at_attempt;
  hear(job, seen.counts, seen.disk_bytes, seen.results_version);
  learn_start_cost(job, seen.first_commit_after_s, had_committed);
  if (!open.stop_asked_s) set_alarm(job.id, open, clock_s_ + options_.look_every_s);
}

void Jobs::see(Job& job, Open& open, const Ended& seen) {
  const bool had_committed = job.counts.scans > job.scans_at_attempt;
  hear(job, seen.counts, seen.disk_bytes, seen.results_version);
  learn_start_cost(job, seen.first_commit_after_s, had_committed);
  if (open.stop_asked_s && open.has_begun) job.stop_cost_s = clock_s_ - *open.stop_asked_s;
  if (seen.kind != EndKind::none) job.end = seen.kind;
  if (!seen.digest.empty()) job.digest = seen.digest;
  Ended ended = seen;
  // If we killed the attempt, it counts as stopped, not as a death.
  if (open.is_ended_now && ended.kind == EndKind::none) ended.kind = EndKind::stop_requested;
  close(job, judge(job, ended, around(job), options_), seen.place);
}

void Jobs::see(Job& job, Open& open, const Died& seen) {
  hear(job, seen.counts, seen.disk_bytes, {});
  close(job, open.is_ended_now
                 ? judge(job, Ended{.kind = EndKind::stop_requested}, around(job), options_)
                 : judge(job, seen, options_));
}

/// An Unknown doesn't change the job's state, because keepers continue without the daemon.
void Jobs::see(Job& job, Open& open, const Unknown& seen) {
  open.is_looked_for = false;
  if (job.state == State::starting && !seen.words.empty() && job.words != seen.words) {
    job.words = seen.words;
    dirty_.insert(job.id);
  }
  if (!open.stop_asked_s) set_alarm(job.id, open, clock_s_ + options_.look_after_launch_s);
}

void Jobs::hear(Job& job, const Counts& counts, std::uint64_t disk_bytes,
                const std::string& results_version) {
  // Sights may arrive out of order. The highest count is right, because commits are never undone.
  if (counts.scans >= job.counts.scans) job.counts = counts;
  if (disk_bytes > 0) {
    Account& account = accounts_.of(job.user);
    account.disk_bytes = account.disk_bytes - job.disk_bytes + disk_bytes;
    job.disk_bytes = disk_bytes;
  }
  if (!results_version.empty()) job.results_version = results_version;
}

void Jobs::learn_start_cost(Job& job, std::optional<double> first_commit_after_s,
                            bool had_committed) {
  if (had_committed || job.counts.scans <= job.scans_at_attempt) return;
  const double seen_after_s = clock_s_ - job.attempt_begin_s;
  job.start_cost_s = std::clamp(first_commit_after_s.value_or(seen_after_s), 0.0, seen_after_s);
  dirty_.insert(job.id);
}

void Jobs::begins(Job& job, Open& open) {
  if (open.is_pending) {
    set_pending(job, open, false);
    job.attempt_begin_s = clock_s_;  // its slice begins now
  }
  open.has_begun = true;
  if (job.state == State::starting) {
    enter(job, State::running, open.is_found ? Reason::found_running : Reason::began, {});
    set_alarm(job.id, open, clock_s_ + options_.look_every_s);
  } else if (open.stop_asked_s) {
    send_stop(job, open);
  }
}

void Jobs::close(Job& job, const Verdict& verdict, const std::string& bug_place) {
  Open& open = open_.at(job.id);
  charge(job, open);
  accounts_.advance(job.user, clock_s_);
  Account& account = accounts_.of(job.user);
  CHECK_GE(account.cores, job.cores);
  account.cores -= job.cores;
  if (open.stop_asked_s) account.cores_stopping -= job.cores;
  if (open.is_pending) account.cores_waiting -= job.cores;
  cores_in_use_ -= job.cores;
  memory_in_use_ -= job.wishes.memory_of_all();
  dirty_users_.insert(job.user);
  if (open.alarm_s) alarms_.erase({*open.alarm_s, job.id});
  open_.erase(job.id);

  const double waits_s =
      count_end(job, verdict, bug_place, clock_s_ - job.attempt_begin_s, options_);
  // The cause of a hold may already be gone, so check the job again after this time.
  constexpr double k_held_s_min = 1;
  job.next_start_s =
      clock_s_ + (verdict.to == State::held ? std::max(waits_s, k_held_s_min) : waits_s);
  job.cores = 0;
  enter(job, verdict.to, verdict.reason, verdict.words);
  note_idle(job.user);
}

void Jobs::charge(Job& job, Open& open) {
  if (!open.is_pending)
    job.core_seconds += static_cast<double>(job.cores) * (clock_s_ - open.charged_s);
  open.charged_s = clock_s_;
}

void Jobs::look(const Job& job, Open& open) {
  open.is_looked_for = true;
  effects_.emplace_back(Look{.job = job.id, .attempt = job.attempt});
  set_alarm(job.id, open,
            clock_s_ + (open.has_begun || open.is_pending ? options_.look_every_s
                                                          : options_.look_after_launch_s));
}

void Jobs::launch(const Job& job) {
  effects_.emplace_back(Launch{.job = job.id,
                               .attempt = job.attempt,
                               .revision = job.attempt_revision,
                               .cores = job.cores,
                               .ranks = job.wishes.ranks,
                               .memory_bytes = job.wishes.memory_bytes});
}

/// REQUIRES: an attempt of the job is open.
void Jobs::ask_to_stop(Job& job, Reason reason, std::string words) {
  Open& open = open_.at(job.id);
  if (open.stop_asked_s) {
    if (weight(reason) > weight(job.reason)) enter(job, State::yielding, reason, std::move(words));
    return;
  }
  open.stop_asked_s = clock_s_;
  accounts_.of(job.user).cores_stopping += job.cores;
  enter(job, State::yielding, reason, std::move(words));
  if (open.has_begun || open.is_pending) send_stop(job, open);
}

void Jobs::send_stop(const Job& job, Open& open) {
  const bool is_late = clock_s_ - *open.stop_asked_s >= options_.stop_now_after_s;
  open.is_ended_now = open.is_ended_now || is_late;
  effects_.emplace_back(Stop{
      .job = job.id, .attempt = job.attempt, .how = is_late ? StopHow::now : StopHow::in_order});
  set_alarm(job.id, open, clock_s_ + options_.stop_again_s);
}

void Jobs::set_alarm(JobId job, Open& open, double at_s) {
  if (open.alarm_s) alarms_.erase({*open.alarm_s, job});
  open.alarm_s = at_s;
  alarms_.emplace(at_s, job);
}

/// If an attempt has no recent report, looks at it. If an attempt doesn't stop, repeats its Stop.
void Jobs::ring_alarms() {
  while (!alarms_.empty() && alarms_.begin()->first <= clock_s_) {
    const JobId id = alarms_.begin()->second;
    Open& open = open_.at(id);
    const Job& job = jobs_.at(id);
    look(job, open);
    if (open.stop_asked_s && (open.has_begun || open.is_pending)) send_stop(job, open);
  }
}

bool Jobs::has_other_results(const Job& job) const {
  return !job.results_version.empty() && !backend_.results_version.empty() &&
         job.results_version != backend_.results_version;
}

Surroundings Jobs::around(const Job& job) const {
  return {.is_disk_low = is_disk_low_, .has_other_results = has_other_results(job)};
}

}  // namespace sleight::jobs
