#include "tests/jobs/ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sleight::jobs::simulated {
namespace {

/// A job may continue after at most this number of reported deaths in a row. A job fails at the
/// fifth death. The check allows two more deaths, because the daemon's own kill after a slow stop
/// may count as a death.
constexpr std::uint32_t k_deaths_most = 6;

/// Returns whether the end counts as a death. A second implementation of the rules in ends.h.
bool is_death(const Ended& ended) {
  if (ended.kind == EndKind::bug) return true;
  if (ended.kind == EndKind::none)
    return ended.hindrance == Hindrance::none && ended.outside == Outside::nothing;
  return false;
}

}  // namespace

void Ledger::wrong(std::string what) {
  if (violation_.empty()) violation_ = std::move(what);
}

void Ledger::is_planned(JobId job, const JobPlan& plan) {
  if (plans_.contains(job) && plans_.at(job) != &plan)
    wrong(fmt::format("id {} was given twice", job));
  plans_[job] = &plan;
}

void Ledger::user_asks(JobId job, AskKind kind) {
  if (kind == AskKind::resume || kind == AskKind::extend) ++revivals_[job];
  if (kind == AskKind::remove) deleted_by_user_.insert(job);
}

void Ledger::decides(const std::vector<Effect>& effects, const Jobs& machine) {
  for (std::size_t i = 0; i < effects.size(); ++i) {
    const auto* save = std::get_if<Save>(&effects[i]);
    if (save == nullptr) continue;
    if (i > 0) wrong("a save that isn't its step's first effect");
    for (const Change& change : save->changes) {
      if (change.to == State::starting && change.from != State::starting)
        check_room(machine.all().at(change.id), machine);
      if (change.from == change.to && change.reason == Reason::submitted)
        check_submit(machine.all().at(change.id), machine);
      if (change.from == State::running && change.to == State::yielding)
        check_told(change.id, effects);
    }
  }
}

/// Checks rules 5 and 6 when an attempt is added.
void Ledger::check_room(const Job& added, const Jobs& machine) {
  if (!room_) return wrong("an attempt before the machine is known");
  std::uint64_t cores = 0;
  std::uint64_t memory = 0;
  std::uint64_t cores_of_user = 0;
  for (const auto& [id, job] : machine.all()) {
    if (!is_active(job.state)) continue;
    cores += job.cores;
    memory += job.wishes.memory_of_all();
    if (job.user == added.user) cores_of_user += job.cores;
  }
  if (cores > room_->cores)
    wrong(fmt::format("job {}: {} of {} cores", added.id, cores, room_->cores));
  if (memory > room_->memory_bytes) wrong(fmt::format("job {}: memory overbooked", added.id));
  if (added.cores < added.wishes.processes()) wrong("ranks without cores");
  const std::uint32_t limit = scenario_.options.limits.cores;
  if (limit > 0 && cores_of_user > limit)
    wrong(fmt::format("job {}: its user has {} of {} cores", added.id, cores_of_user, limit));
  if (room_->disk_free_bytes < room_->disk_reserve_bytes)
    wrong(fmt::format("job {} starts below the disk's reserve", added.id));
  if (is_draining_) wrong(fmt::format("job {} starts while the server is drained", added.id));
  if (!is_backend_there_) wrong(fmt::format("job {} starts without a backend", added.id));
}

void Ledger::check_told(JobId job, const std::vector<Effect>& effects) {
  const bool is_told = std::ranges::any_of(effects, [job](const Effect& effect) {
    const auto* stop = std::get_if<Stop>(&effect);
    return stop != nullptr && stop->job == job;
  });
  if (!is_told) wrong(fmt::format("job {} is to stop, and isn't told", job));
}

void Ledger::check_submit(const Job& added, const Jobs& machine) {
  const auto unfinished =
      static_cast<std::uint64_t>(std::ranges::count_if(machine.all(), [&](const auto& entry) {
        return entry.second.user == added.user && !is_over(entry.second.state);
      }));
  if (unfinished > scenario_.options.limits.jobs)
    wrong(fmt::format("job {}: its user has {} jobs", added.id, unfinished));
}

void Ledger::saves(const Save& save, const SimStore& before) {
  clock_s_ = save.clock_s;
  std::map<JobId, State> states;
  for (const Change& change : save.changes) {
    const Job* job = before.find(change.id);
    const auto known = states.find(change.id);
    if (known != states.end() ? known->second != change.from
                              : job != nullptr && job->state != change.from)
      wrong(fmt::format("job {}: its history goes on from {}", change.id, name_of(change.from)));
    states[change.id] = change.to;
    check_change(change, job);
  }
  for (const Job& job : save.jobs) {
    const Job* old = before.find(job.id);
    const auto now = states.find(job.id);
    const bool is_told =
        now != states.end() ? now->second == job.state : old != nullptr && old->state == job.state;
    if (!is_told) wrong(fmt::format("job {}: {} isn't in its history", job.id, name_of(job.state)));
    check_job(job, old, save);
  }
}

void Ledger::check_change(const Change& change, const Job* before) {
  if (is_over(change.from) && change.to != change.from) {
    std::uint64_t& revivals = revivals_[change.id];
    if (revivals == 0) wrong(fmt::format("job {} was over and isn't any more", change.id));
    revivals -= std::min<std::uint64_t>(revivals, 1);
  }
  Told& told = told_[change.id];
  if (change.reason == Reason::resumed || change.reason == Reason::extended) {
    if (change.to == State::queued && change.from != State::queued && !is_active(change.from))
      told = {.scans_told = told.scans_told};
  }
  const bool closes = is_active(change.from) && !is_active(change.to);
  if (closes && before != nullptr) count_end(change, told);
  const auto end = ends_.find({change.id, change.attempt});
  if (closes && change.from != State::yielding && end != ends_.end() && end->second.is_cancelled &&
      change.to != State::held)
    wrong(
        fmt::format("job {} was cancelled outside, and becomes {}", change.id, name_of(change.to)));
  if (change.to == State::starting && change.from == State::queued &&
      told.not_before_s > clock_s_ + 1e-6)
    wrong(fmt::format("job {} starts {} s too soon after its end", change.id,
                      told.not_before_s - clock_s_));
  if (change.to == State::failed) {
    if (!may_fail(change))
      wrong(fmt::format("job {} fails for nothing: {}", change.id, change.words));
  } else if (closes && told.deaths > k_deaths_most) {
    wrong(fmt::format("job {} goes on after {} deaths", change.id, told.deaths));
  } else if (closes && told.is_bug_again && !is_over(change.to)) {
    wrong(fmt::format("job {} goes on after the same bug twice", change.id));
  }
}

/// Checks rules 9 and 10 against the reports about the attempt.
void Ledger::count_end(const Change& change, Told& told) {
  const auto found = ends_.find({change.id, change.attempt});
  // If no end was reported, no launch of the attempt has begun.
  const ToldEnd end =
      found != ends_.end() ? found->second : ToldEnd{.is_death = true, .scans = told.scans_told};
  told.is_bug_again = end.is_bug && told.has_bug && end.scans <= told.scans_at_bug;
  if (end.is_bug) {
    told.has_bug = true;
    told.scans_at_bug = end.scans;
  }
  const bool is_hindered = change.reason == Reason::disk_full ||
                           change.reason == Reason::other_results ||
                           change.reason == Reason::backend_away;
  if (!end.is_death || is_hindered) {
    if (end.scans > told.scans_at_death) told.deaths = 0;
    return;
  }
  told.deaths = told.deaths == 0 || end.scans > told.scans_at_death ? 1 : told.deaths + 1;
  told.scans_at_death = end.scans;
  if (change.to == State::queued) {
    const auto doublings = static_cast<int>(told.deaths) - 1;
    // If the attempt lived for steady_s, the back-off starts again, and the wait is at least one
    // second.
    const double waits_s =
        end.lived_s >= scenario_.options.steady_s ? 1 : std::ldexp(1.0, doublings);
    told.not_before_s = clock_s_ + waits_s;
  }
}

bool Ledger::may_fail(const Change& change) const {
  const JobPlan& plan = *plans_.at(change.id);
  const auto found = told_.find(change.id);
  switch (change.reason) {
    case Reason::died:
      return found->second.deaths >= scenario_.options.deaths_max;
    case Reason::bug:
      return found->second.is_bug_again;
    case Reason::gave_up:
      return plan.fate == Fate::gives_up;
    case Reason::no_draws:
      return plan.fate == Fate::no_draws;
    case Reason::simulation_failed:
      return plan.fate == Fate::simulation_fails;
    case Reason::refused_by_program:
      return plan.fate == Fate::is_refused;
    default:
      return false;
  }
}

void Ledger::check_job(const Job& job, const Job* before, const Save& save) {
  if (before == nullptr) {
    if (!ids_.insert(job.id).second) wrong(fmt::format("id {} is given again", job.id));
    const auto [key, is_new] = keys_.try_emplace({job.user, job.content}, job.id);
    if (!is_new) wrong(fmt::format("jobs {} and {} are one submit", key->second, job.id));
  } else if (job.attempt < before->attempt) {
    wrong(fmt::format("job {}: attempt {} after {}", job.id, job.attempt, before->attempt));
  } else if (job.state == State::starting && before->state != State::starting &&
             job.attempt == before->attempt) {
    wrong(fmt::format("job {}: attempt {} again", job.id, job.attempt));
  }
  if (job.state == State::done && (before == nullptr || before->state != State::done)) {
    const auto finished = finished_.find(job.id);
    const bool is_finished = finished != finished_.end() && finished->second >= job.revision;
    if (!is_finished && plans_.at(job.id)->fate != Fate::gives_up_with_finds)
      wrong(fmt::format("job {} is done, and its program didn't finish", job.id));
  }
  if (!job.remove_at_s) {
    announced_.erase(job.id);
  } else if (before == nullptr || !before->remove_at_s) {
    announced_[job.id] = save.clock_s;
    ++announcements_;
  }
  if (job.is_leaving && before != nullptr && !before->is_leaving &&
      !deleted_by_user_.contains(job.id)) {
    const auto announced = announced_.find(job.id);
    if (job.pinned || announced == announced_.end() ||
        save.clock_s < announced->second + scenario_.options.announce_s - 1e-6)
      wrong(fmt::format("job {} is deleted too soon", job.id));
  }
}

void Ledger::carries_out(const Effect& effect, const SimStore& store) {
  const auto stored = [&](JobId id) { return store.find(id); };
  if (const auto* launch = std::get_if<Launch>(&effect)) {
    const Job* job = stored(launch->job);
    ++launches_;
    if (job == nullptr || !is_active(job->state) || job->attempt != launch->attempt)
      wrong(fmt::format("job {}: attempt {} is launched and not stored", launch->job,
                        launch->attempt));
  } else if (const auto* stop = std::get_if<Stop>(&effect)) {
    const Job* job = stored(stop->job);
    if (job != nullptr && is_active(job->state) && job->attempt == stop->attempt &&
        job->state != State::yielding)
      wrong(fmt::format("job {} is stopped, and stored as {}", job->id, name_of(job->state)));
  } else if (const auto* look = std::get_if<Look>(&effect)) {
    const Job* job = stored(look->job);
    if (job == nullptr || !is_active(job->state) || job->attempt != look->attempt)
      wrong(fmt::format("job {} is looked for, and has no open attempt", look->job));
  } else if (const auto* remove = std::get_if<Remove>(&effect)) {
    const Job* job = stored(remove->job);
    if (job != nullptr && !job->is_leaving)
      wrong(fmt::format("job {} is removed, and not stored as leaving", remove->job));
  } else if (const auto* answer = std::get_if<Answer>(&effect)) {
    if (!answer->refusal && stored(answer->job) == nullptr)
      wrong(fmt::format("job {} is answered, and not stored", answer->job));
  } else if (const auto* announce = std::get_if<Announce>(&effect)) {
    const Job* job = stored(announce->job);
    if (job != nullptr && !job->remove_at_s) wrong("an announcement that isn't stored");
  }
}

void Ledger::program_begins(JobId job, Attempt attempt, std::uint32_t cores,
                            std::uint64_t memory_bytes, const SimStore& store) {
  if (live_.contains(job)) wrong(fmt::format("job {} runs twice", job));
  const auto newest = newest_begun_.find(job);
  if (newest != newest_begun_.end() && attempt <= newest->second)
    wrong(fmt::format("job {}: attempt {} begins after {}", job, attempt, newest->second));
  newest_begun_[job] = attempt;
  live_[job] = {.attempt = attempt, .cores = cores, .memory_bytes = memory_bytes};
  // The checks below hold only if all reports to the daemon are true.
  if (scenario_.has(Fault::Kind::messages_wrong)) return;
  const Job* stored = store.find(job);
  if (stored == nullptr || is_over(stored->state))
    wrong(fmt::format("job {} is over, and its program begins", job));
  std::uint64_t all_cores = 0;
  std::uint64_t all_memory = 0;
  for (const auto& [id, live] : live_) {
    all_cores += live.cores;
    all_memory += live.memory_bytes;
  }
  if (all_cores > scenario_.room.cores || all_memory > scenario_.room.memory_bytes)
    wrong(fmt::format("{} cores are in use, and {} bytes", all_cores, all_memory));
}

void Ledger::program_ends(JobId job, Attempt attempt) {
  const auto found = live_.find(job);
  if (found == live_.end() || found->second.attempt != attempt)
    return wrong(fmt::format("job {}: attempt {} ends that didn't begin", job, attempt));
  live_.erase(found);
}

void Ledger::tells(const Input& input, const Jobs& machine) {
  if (const auto* room = std::get_if<Room>(&input)) room_ = *room;
  if (const auto* drain = std::get_if<Drain>(&input)) is_draining_ = drain->on;
  if (const auto* note = std::get_if<BackendNote>(&input)) is_backend_there_ = note->is_there;
  if (const auto* failed = std::get_if<LaunchFailed>(&input)) {
    ends_.try_emplace(
        {failed->job, failed->attempt},
        ToldEnd{.is_death = !failed->is_backend_away, .scans = told_[failed->job].scans_told});
  }
  const auto* sight = std::get_if<Sight>(&input);
  if (sight == nullptr) return;
  const Job* job = machine.find(sight->job);
  if (job == nullptr || !is_active(job->state) || sight->attempt != job->attempt) return;
  Told& told = told_[sight->job];
  ToldEnd end{.lived_s = machine.clock_s() - job->attempt_begin_s};
  if (const auto* running = std::get_if<Running>(&sight->seen)) {
    told.scans_told = std::max(told.scans_told, running->counts.scans);
    // A running attempt hasn't ended, even if its launch was reported as failed.
    return;
  }
  if (const auto* ended = std::get_if<Ended>(&sight->seen)) {
    told.scans_told = std::max(told.scans_told, ended->counts.scans);
    end.is_death = is_death(*ended);
    end.is_bug = ended->kind == EndKind::bug;
    end.is_cancelled =
        ended->kind == EndKind::stop_requested && ended->outside == Outside::cancelled;
  } else if (const auto* died = std::get_if<Died>(&sight->seen)) {
    told.scans_told = std::max(told.scans_told, died->counts.scans);
    end.is_death = died->outside == Outside::nothing;
    end.is_cancelled = died->outside == Outside::cancelled;
  } else {
    return;
  }
  end.scans = told.scans_told;
  ends_.insert_or_assign({sight->job, sight->attempt}, end);
}

void Ledger::restarts(const SimStore& store) {
  ends_.clear();
  for (auto& [id, told] : told_) {
    const Job* job = store.find(id);
    told.scans_told = job == nullptr ? 0 : job->counts.scans;
  }
}

}  // namespace sleight::jobs::simulated
