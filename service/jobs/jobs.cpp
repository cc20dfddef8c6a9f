#include "service/jobs/jobs.h"

#include <algorithm>
#include <limits>

#include "common/base/check.h"

namespace sleight::jobs {
namespace {

/// Interval at which an idle machine saves its clock. The clock determines the age of finished
/// jobs.
constexpr double k_idle_save_s = 3600;
/// Interval at which the machine checks whether running jobs should make room.
constexpr double k_look_at_turns_s = 0.5;
/// Interval at which the machine checks whether the users of held jobs are below their limits
/// again.
constexpr double k_look_at_limits_s = 10;
/// Interval at which the machine again requests that a folder be deleted.
constexpr double k_remove_again_s = 60;

bool goes_on_by_itself(const Job& job) {
  return job.state == State::held && job.reason != Reason::hold_asked &&
         job.reason != Reason::cancelled_outside;
}
bool is_of_limit(Reason reason) {
  return reason == Reason::limit_core_hours || reason == Reason::limit_bytes;
}

}  // namespace

Jobs::Jobs(const Options& options, Restored restored)
    : options_(options), next_id_(restored.next_id), clock_s_(restored.clock_s) {
  saved_s_ = clock_s_;
  for (const Usage& usage : restored.usages)
    accounts_.restore(usage);
  for (Job& record : restored.jobs) {
    const JobId id = record.id;
    CHECK_LT(id.value, next_id_);
    Job& job = jobs_.emplace(id, std::move(record)).first->second;
    Account& account = accounts_.of(job.user);
    account.disk_bytes += job.disk_bytes;
    if (!job.client_key.empty() && !job.is_leaving) by_key_[{job.user, job.client_key}] = id;
    if (is_active(job.state)) {
      Open& open = open_[id];
      open.has_begun = job.state == State::running;
      open.is_found = true;
      open.charged_s = clock_s_;
      account.cores += job.cores;
      cores_in_use_ += job.cores;
      memory_in_use_ += job.wishes.memory_of_all();
      if (job.state == State::yielding) {
        open.stop_asked_s = clock_s_;
        account.cores_stopping += job.cores;
      }
    }
    join_indices(job);
  }
}

std::vector<Effect> Jobs::step(const Input& input) {
  effects_.clear();
  std::visit([this](const auto& kind) { take(kind); }, input);
  // Reports on running jobs don't change whose turn it is, but the clock does.
  if (!std::holds_alternative<Sight>(input) || !save_.changes.empty()) hand_out();
  finish_step();
  return std::exchange(effects_, {});
}

/// Makes the Save, which has all changes, the step's first effect.
void Jobs::finish_step() {
  if (dirty_.empty() && dirty_users_.empty() && save_.changes.empty() && save_.erased.empty() &&
      !saves_clock_)
    return;
  for (const JobId id : dirty_)
    save_.jobs.push_back(jobs_.at(id));
  for (const UserId user : dirty_users_) {
    accounts_.advance(user, clock_s_);
    save_.usages.push_back(accounts_.of(user).usage);
  }
  save_.clock_s = clock_s_;
  save_.next_id = next_id_;
  dirty_.clear();
  dirty_users_.clear();
  saves_clock_ = false;
  effects_.insert(effects_.begin(), std::exchange(save_, {}));
}

void Jobs::take(const Tick& input) {
  if (!ticks_begin_s_) ticks_begin_s_ = input.now_s - clock_s_;
  CHECK_GE(input.now_s - *ticks_begin_s_, clock_s_ - 1e-6);
  clock_s_ = std::max(clock_s_, input.now_s - *ticks_begin_s_);
  wall_ = input.wall;
  if (!has_begun_) return;
  ring_alarms();
  end_delays();
  release_limited();
  hold_over_limits();
  use_idle_cores();
  keep_house();
  save_use();
}

void Jobs::take(const Began&) {
  has_begun_ = true;
  for (auto& [id, open] : open_)
    look(jobs_.at(id), open);
  for (auto& [id, job] : jobs_) {
    if (job.is_leaving) effects_.emplace_back(Remove{id});
  }
}

void Jobs::take(const Room& input) {
  const bool is_other_machine =
      !room_ || room_->cores != input.cores || room_->memory_bytes != input.memory_bytes;
  room_ = input;
  if (is_other_machine) {
    const std::set<JobId> unfit = std::exchange(unfit_, {});
    for (const JobId id : unfit)
      put_into_queue(jobs_.at(id));
    for (const auto& [id, job] : jobs_) {
      if (job.state != State::queued || fits_machine(job) || !queue_.remove(id)) continue;
      put_into_queue(job);
      note_idle(job.user);
    }
  }
  const auto free_bytes = static_cast<double>(input.disk_free_bytes);
  const double reserve_bytes = static_cast<double>(input.disk_reserve_bytes) *
                               (is_disk_low_ ? options_.disk_resume_factor : 1);
  const bool was_low = std::exchange(is_disk_low_, free_bytes < reserve_bytes);
  if (is_disk_low_) {
    for (auto& [id, open] : open_)
      ask_to_stop(jobs_.at(id), Reason::disk_low,
                  "Free disk space is below the server's reserve. The job resumes automatically "
                  "when enough space is free. `sleight delete` deletes finished jobs.");
  } else if (was_low || is_other_machine) {
    release_held();
  }
  shed();
}

void Jobs::take(const Drain& input) {
  is_draining_ = input.on;
  if (!input.on) return;
  for (auto& [id, open] : open_)
    ask_to_stop(jobs_.at(id), Reason::draining, "The server is being drained.");
}

void Jobs::take(const BackendNote& input) {
  backend_ = input;
  release_held();
}

void Jobs::take(const Removed& input) {
  const auto found = jobs_.find(input.job);
  if (found == jobs_.end() || !found->second.is_leaving) return;
  leave_indices(found->second);
  accounts_.of(found->second.user).disk_bytes -= found->second.disk_bytes;
  dirty_.erase(input.job);
  jobs_.erase(found);
  save_.erased.push_back(input.job);
}

void Jobs::enter(Job& job, State to, Reason reason, std::string words) {
  leave_indices(job);
  const State from = std::exchange(job.state, to);
  job.reason = reason;
  job.words = words;
  job.changed_wall = wall_;
  job.next_start_wall = job.next_start_s > clock_s_ ? wall_at(job.next_start_s) : 0;
  if (to == State::queued && from != State::queued) job.queued_since_s = clock_s_;
  if (is_over(to)) {
    job.over_since_s = clock_s_;
    job.over_wall = wall_;
    job.next_start_wall = 0;
  }
  join_indices(job);
  note(job, from, reason, std::move(words));
}

void Jobs::note(const Job& job, State from, Reason reason, std::string words) {
  save_.changes.push_back({.id = job.id,
                           .from = from,
                           .to = job.state,
                           .reason = reason,
                           .attempt = job.attempt,
                           .wall = wall_,
                           .words = std::move(words)});
  dirty_.insert(job.id);
}

/// Removes the job from all indices. If a value orders an index, call this before changing the
/// value.
void Jobs::leave_indices(const Job& job) {
  delayed_.erase({job.next_start_s, job.id});
  if (job.is_leaving) return;
  --counts_[job.state];
  if (!is_over(job.state)) --accounts_.of(job.user).unfinished;
  if (job.state == State::queued) {
    queue_.remove(job.id);
    unfit_.erase(job.id);
    note_idle(job.user);
  } else if (job.state == State::held) {
    held_.erase(job.id);
    limited_.erase({job.user, job.id});
  } else if (is_over(job.state) && !job.pinned) {
    keeping_.remove(job);
  }
}

void Jobs::join_indices(const Job& job) {
  if (job.is_leaving) {
    delayed_.emplace(job.next_start_s, job.id);
    return;
  }
  ++counts_[job.state];
  if (!is_over(job.state)) ++accounts_.of(job.user).unfinished;
  const bool is_delayed = job.next_start_s > clock_s_;
  if (job.state == State::queued) {
    if (is_delayed) {
      delayed_.emplace(job.next_start_s, job.id);
    } else {
      put_into_queue(job);
    }
  } else if (goes_on_by_itself(job)) {
    if (is_of_limit(job.reason)) {
      limited_.emplace(job.user, job.id);
    } else {
      held_.insert(job.id);
    }
    if (is_delayed) delayed_.emplace(job.next_start_s, job.id);
  } else if (is_over(job.state) && !job.pinned) {
    keeping_.add(job);
  }
}

void Jobs::put_into_queue(const Job& job) {
  if (fits_machine(job)) {
    queue_.add(job);
    note_idle(job.user);
  } else {
    unfit_.insert(job.id);
  }
}

/// Updates the time from which the user has waited without a running job.
void Jobs::note_idle(UserId user) {
  Account& account = accounts_.of(user);
  if (account.cores > 0 || !queue_.users().contains(user)) {
    account.idle_since_s.reset();
  } else if (!account.idle_since_s) {
    account.idle_since_s = clock_s_;
  }
}

bool Jobs::is_cause_gone(const Job& job) const {
  switch (job.reason) {
    case Reason::disk_low:
    case Reason::disk_full:
      return room_ && !is_disk_low_;
    case Reason::backend_away:
      return backend_.is_there;
    case Reason::other_results:
      return !has_other_results(job);
    case Reason::limit_core_hours:
      return !accounts_.is_over_core_hours(job.user, clock_s_, true);
    case Reason::limit_bytes:
      return !accounts_.is_over_bytes(job.user, true);
    default:
      return false;
  }
}

void Jobs::release_held() {
  for (const JobId id : std::set<JobId>(held_)) {
    Job& job = jobs_.at(id);
    if (job.next_start_s <= clock_s_ && is_cause_gone(job))
      enter(job, State::queued, Reason::went_on,
            "The reason for holding the job no longer applies.");
  }
}

void Jobs::release_limited() {
  auto next = limited_.begin();
  while (next != limited_.end()) {
    const UserId user = next->first;
    const auto end = limited_.upper_bound({user, JobId{std::numeric_limits<std::uint64_t>::max()}});
    const bool has_hours = !accounts_.is_over_core_hours(user, clock_s_, true);
    const bool has_bytes = !accounts_.is_over_bytes(user, true);
    std::vector<JobId> gone;
    for (auto job = next; job != end && (has_hours || has_bytes); ++job) {
      const bool is_of_hours = jobs_.at(job->second).reason == Reason::limit_core_hours;
      if (is_of_hours ? has_hours : has_bytes) gone.push_back(job->second);
    }
    next = end;
    for (const JobId id : gone)
      enter(jobs_.at(id), State::queued, Reason::went_on,
            "The user's jobs are below the limit again.");
  }
}

void Jobs::end_delays() {
  while (!delayed_.empty() && delayed_.begin()->first <= clock_s_) {
    Job& job = jobs_.at(delayed_.begin()->second);
    delayed_.erase(delayed_.begin());
    if (job.is_leaving) {
      effects_.emplace_back(Remove{job.id});
      job.next_start_s = clock_s_ + k_remove_again_s;
      delayed_.emplace(job.next_start_s, job.id);
    } else if (job.state == State::queued) {
      put_into_queue(job);
    } else if (job.state == State::held && is_cause_gone(job)) {
      enter(job, State::queued, Reason::went_on,
            "The reason for holding the job no longer applies.");
    }
  }
}

/// Deletes the job but keeps its record until the folder no longer exists.
void Jobs::let_go(Job& job) {
  leave_indices(job);
  if (!job.client_key.empty()) by_key_.erase({job.user, job.client_key});
  job.is_leaving = true;
  job.next_start_s = clock_s_ + k_remove_again_s;
  join_indices(job);
  dirty_.insert(job.id);
  effects_.emplace_back(Remove{job.id});
}

void Jobs::keep_house() {
  while (const auto next = keeping_.next_to_announce(clock_s_)) {
    Job& job = jobs_.at(next->first);
    keeping_.remove(job);
    job.remove_at_s = next->second;
    job.remove_wall = wall_at(next->second);
    keeping_.add(job);
    dirty_.insert(job.id);
    effects_.emplace_back(Announce{.job = job.id, .user = job.user, .wall = job.remove_wall});
  }
  while (const auto next = keeping_.next_to_delete(clock_s_))
    let_go(jobs_.at(*next));
}

void Jobs::save_use() {
  if (clock_s_ - saved_s_ < (open_.empty() ? k_idle_save_s : options_.save_every_s)) return;
  saved_s_ = clock_s_;
  saves_clock_ = true;
  for (auto& [id, open] : open_) {
    Job& job = jobs_.at(id);
    charge(job, open);
    dirty_.insert(id);
    dirty_users_.insert(job.user);
  }
}

const Job* Jobs::find(JobId id) const {
  const auto found = jobs_.find(id);
  return found == jobs_.end() || found->second.is_leaving ? nullptr : &found->second;
}

Standing Jobs::standing() const {
  const auto count = [this](State state) {
    const auto found = counts_.find(state);
    return found == counts_.end() ? 0 : found->second;
  };
  return {.cores = room_ ? room_->cores : 0,
          .cores_in_use = cores_in_use_,
          .memory_bytes = room_ ? room_->memory_bytes : 0,
          .memory_in_use = memory_in_use_,
          .queued = count(State::queued),
          .active = count(State::starting) + count(State::running) + count(State::yielding),
          .held = count(State::held),
          .over = count(State::done) + count(State::failed) + count(State::cancelled),
          .is_draining = is_draining_,
          .is_disk_low = is_disk_low_,
          .is_backend_there = backend_.is_there};
}

std::optional<double> Jobs::next_tick_s() const {
  if (!ticks_begin_s_ || !has_begun_) return std::nullopt;
  std::optional<double> next = keeping_.next_s();
  const auto also = [&next](double at_s) { next = next ? std::min(*next, at_s) : at_s; };
  if (!alarms_.empty()) also(alarms_.begin()->first);
  if (!delayed_.empty()) also(delayed_.begin()->first);
  if (!open_.empty()) also(clock_s_ + k_look_at_turns_s);
  if (!limited_.empty()) also(clock_s_ + k_look_at_limits_s);
  also(saved_s_ + (open_.empty() ? k_idle_save_s : options_.save_every_s));
  return std::max(*next, clock_s_) + *ticks_begin_s_;
}

}  // namespace sleight::jobs
