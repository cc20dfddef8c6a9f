// Applies the rules of turns.h: which jobs start, and which make room.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "common/base/check.h"
#include "service/jobs/jobs.h"

namespace sleight::jobs {

bool Jobs::may_start() const {
  return has_begun_ && room_ && !is_draining_ && !is_disk_low_ && backend_.is_there;
}

bool Jobs::fits_machine(const Job& job) const {
  const std::uint32_t cores_limit = accounts_.limits(job.user).cores;
  if (cores_limit > 0 && job.wishes.processes() > cores_limit) return false;
  if (!room_) return true;
  return job.wishes.processes() <= room_->cores &&
         job.wishes.memory_bytes <= room_->memory_bytes / job.wishes.processes();
}

std::uint32_t Jobs::cores_free() const {
  return room_->cores - std::min(room_->cores, cores_in_use_);
}
std::uint64_t Jobs::memory_free() const {
  return room_->memory_bytes - std::min(room_->memory_bytes, memory_in_use_);
}

/// Returns how many cores the user's attempts have. Attempts that were asked to stop don't count.
std::uint32_t Jobs::cores_kept(UserId user) const {
  const Account* account = accounts_.find(user);
  return account == nullptr ? 0 : account->cores - account->cores_stopping;
}

/// Returns the maximum cores that the job can have on this machine. The user's other jobs also
/// count towards the user's limit.
std::uint32_t Jobs::cores_max(const Job& job) const {
  std::uint32_t cores = room_->cores;
  if (job.wishes.ranks > 0) {
    cores = std::min(cores, std::max(job.wishes.ranks, job.wishes.cores));
  } else if (job.wishes.cores > 0) {
    cores = std::min(cores, job.wishes.cores);
  }
  const std::uint32_t limit = accounts_.limits(job.user).cores;
  const Account* account = accounts_.find(job.user);
  if (limit == 0 || account == nullptr) return cores;
  const std::uint32_t others = account->cores - (is_active(job.state) ? job.cores : 0);
  return std::min(cores, limit - std::min(limit, others));
}

bool Jobs::may_have_turn(UserId user, const Job& first) const {
  return cores_max(first) >= first.wishes.processes() &&
         !accounts_.is_over_core_hours(user, clock_s_, false) &&
         !accounts_.is_over_bytes(user, false);
}

NextJob Jobs::first_of(UserId user, const Queue::OfUser& waiting) const {
  const Account* account = accounts_.find(user);
  const auto [since_s, longest] = waiting.longest();
  const bool is_turn = longest != waiting.first() && clock_s_ - since_s >= options_.patience_s &&
                       clock_s_ - account->turn_s >= options_.patience_s;
  const Job& job = jobs_.at(is_turn ? longest : waiting.first());
  return {.id = job.id,
          .user = user,
          .priority = job.priority,
          .is_overdue =
              account->idle_since_s && clock_s_ - *account->idle_since_s >= options_.patience_s,
          .is_turn = is_turn};
}

std::optional<NextJob> Jobs::next_job() const {
  using Order = std::tuple<bool, double, double, std::int64_t, JobId>;
  std::optional<NextJob> next;
  Order first;
  for (const auto& [user, waiting] : queue_.users()) {
    const NextJob job = first_of(user, waiting);
    if (!may_have_turn(user, jobs_.at(job.id))) continue;
    const double idle_since_s = job.is_overdue ? *accounts_.find(user)->idle_since_s : clock_s_;
    const Order order{!job.is_overdue, idle_since_s, accounts_.standing_core_s(user, clock_s_),
                      -std::int64_t{job.priority}, job.id};
    if (next && order > first) continue;
    next = job;
    first = order;
  }
  return next;
}

Shares Jobs::shares() const {
  std::set<UserId> users;
  for (const auto& [user, waiting] : queue_.users()) {
    if (may_have_turn(user, jobs_.at(waiting.first()))) users.insert(user);
  }
  for (const auto& [id, open] : open_) {
    if (!open.stop_asked_s) users.insert(jobs_.at(id).user);
  }
  return {.cores = room_->cores, .users = std::max<std::uint64_t>(1, users.size())};
}

/// Returns how many free cores to leave for other waiting users.
std::uint64_t Jobs::claim_of_others(UserId user, const Shares& shares) const {
  std::uint64_t claim = 0;
  for (const auto& [other, waiting] : queue_.users()) {
    const Job& job = jobs_.at(waiting.first());
    if (other == user || !may_have_turn(other, job)) continue;
    const std::uint32_t kept = cores_kept(other);
    const auto share = static_cast<std::uint32_t>(shares.each());
    const std::uint32_t missing = share - std::min(share, kept);
    claim += std::min(cores_max(job), kept == 0 ? std::max(1U, missing) : missing);
  }
  return claim;
}

void Jobs::hand_out() {
  if (!may_start()) return;
  while (const std::optional<NextJob> next = next_job()) {
    Job& job = jobs_.at(next->id);
    if (has_other_results(job)) {
      enter(job, State::held, Reason::other_results,
            "The results version of the installed programs differs from the run's. The job resumes "
            "automatically after the run's version is installed. Otherwise, submit the request "
            "again.");
      continue;
    }
    const Shares now = shares();
    const Need need = need_of(job, now, cores_kept(job.user), cores_max(job));
    const bool can_start = cores_free() >= need.cores_min && memory_free() >= need.memory_bytes;
    const bool has_need = can_start && cores_free() >= need.cores;
    if (!has_need && make_room(*next, need, now)) return;
    if (!can_start) return;
    start(job, cores_given(need, cores_free(), claim_of_others(job.user, now)), next->is_turn);
  }
}

void Jobs::start(Job& job, std::uint32_t cores, bool is_turn) {
  accounts_.advance(job.user, clock_s_);
  Account& account = accounts_.of(job.user);
  account.cores += cores;
  if (is_turn) account.turn_s = clock_s_;
  cores_in_use_ += cores;
  memory_in_use_ += job.wishes.memory_of_all();
  dirty_users_.insert(job.user);

  ++job.attempt.value;
  job.attempt_revision = job.revision;
  job.attempt_begin_s = clock_s_;
  job.scans_at_attempt = job.counts.scans;
  job.cores = cores;
  if (job.began_wall <= 0) job.began_wall = wall_;
  Open& open = open_[job.id];
  open.charged_s = clock_s_;
  enter(job, State::starting, Reason::its_turn,
        fmt::format("Started with {} core{}.", cores, cores == 1 ? "" : "s"));
  note_idle(job.user);
  launch(job);
  set_alarm(job.id, open, clock_s_ + options_.look_after_launch_s);
}

std::vector<RunningJob> Jobs::running_jobs() const {
  std::vector<RunningJob> running;
  for (const auto& [id, open] : open_) {
    const Job& job = jobs_.at(id);
    if (job.state != State::running) continue;
    running.push_back({.id = id,
                       .user = job.user,
                       .priority = job.priority,
                       .cores = job.cores,
                       .cores_wished = cores_max(job),
                       .memory_bytes = job.wishes.memory_of_all(),
                       .has_had_slice = clock_s_ - job.attempt_begin_s >= slice_s(job, options_),
                       .restart_cost_s = restart_cost_s(job, options_),
                       .core_seconds = job.core_seconds + static_cast<double>(job.cores) *
                                                              (clock_s_ - open.charged_s)});
  }
  return running;
}

/// If the next job comes before running jobs, asks these to stop. Returns whether the next job
/// should wait for the stops. If not, the next job starts on the free cores or can't start.
bool Jobs::make_room(const NextJob& next, const Need& need, const Shares& shares) {
  std::uint32_t cores = cores_free();
  std::uint64_t memory = memory_free();
  for (const auto& [id, open] : open_) {
    // If a job is slow to stop, don't count its cores.
    if (!open.stop_asked_s || clock_s_ - *open.stop_asked_s >= options_.slice_s_min) continue;
    cores += jobs_.at(id).cores;
    memory += jobs_.at(id).wishes.memory_of_all();
  }
  const auto is_enough = [&](std::uint32_t wanted) {
    return cores >= wanted && memory >= need.memory_bytes;
  };
  if (is_enough(need.cores)) return true;

  const double next_standing = accounts_.standing_core_s(next.user, clock_s_);
  std::vector<std::pair<double, RunningJob>> after;  // with its user's standing
  for (const RunningJob& job : running_jobs()) {
    const double standing = accounts_.standing_core_s(job.user, clock_s_);
    if (job.has_had_slice && comes_before(next, next_standing, job, standing, options_))
      after.emplace_back(standing, job);
  }
  std::ranges::sort(after, [](const auto& a, const auto& b) {
    return std::tuple(-a.first, a.second.priority, b.second.id) <
           std::tuple(-b.first, b.second.priority, a.second.id);
  });

  std::set<JobId> stops;
  const auto add = [&](const RunningJob& job) {
    stops.insert(job.id);
    cores += job.cores;
    memory += job.memory_bytes;
  };
  // Take the next job's share from users above their share.
  std::map<UserId, std::uint32_t> kept;
  for (const auto& [standing, job] : after) {
    if (is_enough(need.cores)) break;
    const auto& [user, cores_of_user] = *kept.try_emplace(job.user, cores_kept(job.user)).first;
    if (user != next.user && !next.is_overdue && cores_of_user <= shares.each()) continue;
    add(job);
    kept[user] -= job.cores;
  }
  // If the next job still couldn't start, stop jobs of any user. If even that isn't enough, stop no
  // job.
  for (const auto& [standing, job] : after) {
    if (is_enough(need.cores_min)) break;
    if (!stops.contains(job.id)) add(job);
  }
  if (!is_enough(need.cores_min)) return false;
  for (const JobId id : stops)
    ask_to_stop(jobs_.at(id), Reason::others_wait,
                "Other jobs are waiting, and this job has used its turn.");
  return !stops.empty();
}

/// If cores are free and nobody waits for them, stops a running job in order to restart it with
/// more cores.
void Jobs::use_idle_cores() {
  if (!may_start() || next_job()) return;
  for (const auto& [id, open] : open_) {
    if (open.is_pending) continue;
    if (jobs_.at(id).state != State::running) return;  // wait for the outcome first
  }
  const std::vector<RunningJob> running = running_jobs();
  const RunningJob* widest = nullptr;
  std::uint32_t widest_gain = 0;
  for (const RunningJob& job : running) {
    const std::uint32_t cores = std::min(job.cores_wished, job.cores + cores_free());
    if (!job.has_had_slice || !is_worth_widening(job, cores, options_)) continue;
    if (cores - job.cores <= widest_gain) continue;
    widest = &job;
    widest_gain = cores - job.cores;
  }
  if (widest != nullptr) {
    ask_to_stop(jobs_.at(widest->id), Reason::wider, "The job resumes with more cores.");
  } else {
    even_out(running, shares());
  }
}

/// Stops two jobs. One user is below its share; its job restarts with more cores. The other user is
/// above its share and has used more; its job gives up its cores.
void Jobs::even_out(const std::vector<RunningJob>& running, const Shares& shares) {
  const auto had = [&](const RunningJob& job) { return accounts_.had_core_s(job.user, clock_s_); };
  const RunningJob* below = nullptr;
  const RunningJob* above = nullptr;
  for (const RunningJob& job : running) {
    if (!job.has_had_slice) continue;
    const std::uint32_t kept = cores_kept(job.user);
    const bool is_below = kept < shares.each() && job.cores < job.cores_wished;
    if (is_below && (below == nullptr || had(job) < had(*below))) below = &job;
    if (kept > shares.each() && (above == nullptr || had(job) > had(*above))) above = &job;
  }
  if (below == nullptr || above == nullptr) return;
  // The difference between the two users' core-seconds must be worth a slice. Otherwise they would
  // keep changing places.
  if (had(*above) - had(*below) < shares.each() * options_.slice_s_min) return;
  ask_to_stop(jobs_.at(below->id), Reason::wider, "The job resumes with more cores.");
  ask_to_stop(jobs_.at(above->id), Reason::others_wait,
              "Other users have had less computing time.");
}

/// If the machine has become smaller, stops jobs until the others fit.
void Jobs::shed() {
  std::uint64_t cores = 0;
  std::uint64_t memory = 0;
  std::vector<std::tuple<double, JobId>> order;
  for (const auto& [id, open] : open_) {
    const Job& job = jobs_.at(id);
    if (open.stop_asked_s) continue;
    cores += job.cores;
    memory += job.wishes.memory_of_all();
    order.emplace_back(-accounts_.standing_core_s(job.user, clock_s_), id);
  }
  std::ranges::sort(order);
  for (const auto& [standing, id] : order) {
    if (cores <= room_->cores && memory <= room_->memory_bytes) break;
    Job& job = jobs_.at(id);
    cores -= job.cores;
    memory -= job.wishes.memory_of_all();
    ask_to_stop(job, Reason::less_room, "The cores or memory available to jobs were reduced.");
  }
}

void Jobs::hold_over_limits() {
  for (const auto& [id, open] : open_) {
    Job& job = jobs_.at(id);
    const bool has_had_slice = clock_s_ - job.attempt_begin_s >= slice_s(job, options_);
    // Wait for the end of the slice. Otherwise a job that has long scans would never progress.
    if (has_had_slice && accounts_.is_over_core_hours(job.user, clock_s_, false)) {
      ask_to_stop(job, Reason::limit_core_hours,
                  "The user's jobs have used their daily core-hours. The job resumes automatically "
                  "when core-hours are available again.");
    } else if (accounts_.is_over_bytes(job.user, false)) {
      ask_to_stop(job, Reason::limit_bytes,
                  "The user's jobs have reached their disk limit. The job resumes automatically "
                  "after some jobs are deleted (`sleight delete`).");
    }
  }
}

Waiting Jobs::waiting(JobId id) const {
  const Job& job = jobs_.at(id);
  CHECK(job.state == State::queued);
  const auto because = [](WhyNot why, std::string sentence) {
    return Waiting{.why = why, .place = 0, .sentence = std::move(sentence)};
  };
  if (!has_begun_ || !room_) return because(WhyNot::not_known_yet, "The server has just started.");
  if (job.next_start_s > clock_s_)
    return because(WhyNot::back_off,
                   fmt::format("The job restarts in {:.0f} s (delay after its last attempt).",
                               std::ceil(job.next_start_s - clock_s_)));
  if (unfit_.contains(id))
    return because(WhyNot::too_large,
                   "The job requests more ranks or memory than is available to jobs.");
  if (is_draining_) return because(WhyNot::draining, "The server is being drained.");
  if (is_disk_low_)
    return because(WhyNot::disk_low, "Free disk space is below the server's reserve.");
  if (!backend_.is_there) return because(WhyNot::backend_away, "No job can start now.");
  if (accounts_.is_over_core_hours(job.user, clock_s_, false) ||
      accounts_.is_over_bytes(job.user, false))
    return because(WhyNot::limit_core_hours, "The user has reached a limit.");
  if (cores_max(job) < job.wishes.processes())
    return because(WhyNot::limit_cores,
                   "The job needs more cores than the user's limit leaves free.");

  const std::uint64_t rank = queue_.rank(id);
  const double standing = accounts_.standing_core_s(job.user, clock_s_);
  std::uint64_t place = rank;
  for (const auto& [user, waiting] : queue_.users()) {
    if (user == job.user || !may_have_turn(user, jobs_.at(waiting.first()))) continue;
    const bool is_before = accounts_.standing_core_s(user, clock_s_) < standing;
    place += std::min<std::uint64_t>(waiting.order.size(), is_before ? rank : rank - 1);
  }
  place = std::min(place, k_place_max);
  if (place == 1)
    return {.sentence = "The job is next, as soon as running jobs free enough cores and memory."};
  return {
      .why = WhyNot::others_first,
      .place = place,
      .sentence = fmt::format("{}{} {} before this job.", place == k_place_max ? "At least " : "",
                              place - 1, place == 2 ? "job is" : "jobs are")};
}

}  // namespace sleight::jobs
