#include "tests/jobs/service.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tests/jobs/wrong_parts.h"

namespace sleight::jobs::simulated {
namespace {

using Kind = Fault::Kind;

constexpr double k_commit_s_min = 1e-3, k_commit_s_max = 0.02;
constexpr double k_restart_s_max = 5;
/// If a user gets no answer within this time, the user repeats the call.
constexpr double k_ask_again_s = 4;
constexpr double k_submit_again_s = 20;
constexpr double k_look_around_s = 5;
constexpr double k_day_s = 86400;

}  // namespace

Service::Service(const Scenario& scenario)
    : scenario_(scenario),
      dice_(scenario.seed, cluster::Dice::Part::coordinator),
      ledger_(scenario),
      backend_(scenario.seed, events_, ledger_, store_,
               [this](const Input& input) { hear(input); }) {}

Outcome Service::run(double limit_s) {
  events_.at(0, [this] { begin_daemon(); });
  for (std::size_t i = 0; i < scenario_.jobs.size(); ++i) {
    const JobPlan& plan = scenario_.jobs[i];
    events_.at(plan.submitted_s, [this, i] { submit(i); });
    for (const UserAct& act : plan.acts) {
      const Token token = next_ask_++;
      asks_open_.insert(token);
      events_.at(act.at_s, [this, i, kind = act.kind, token] { ask(i, kind, token); });
    }
  }
  for (const Fault& fault : scenario_.faults)
    events_.at(fault.at_s, [this, &fault] { strike(fault); });
  events_.at(scenario_.quiet_s, [this] { look_around(); });

  const double last_s = scenario_.quiet_s + limit_s;
  while (!outcome_.is_finished && ledger_.violation().empty() && events_.now_s() <= last_s &&
         events_.run_next())
    ++outcome_.events;
  outcome_.violation = ledger_.violation();
  outcome_.unfinished = unfinished();
  outcome_.end_s = events_.now_s();
  outcome_.core_s = backend_.core_s();
  outcome_.useful_core_s = backend_.useful_core_s();
  outcome_.launches = ledger_.launches();
  outcome_.announcements = ledger_.announcements();
  return outcome_;
}

void Service::begin_daemon() {
  ++outcome_.daemons;
  ticks_begin_s_ = dice_.uniform(-1e6, 1e6);
  ledger_.restarts(store_);
  machine_ = std::make_unique<Jobs>(options_with(scenario_.mistake, scenario_.options),
                                    restored_with(scenario_.mistake, store_.restored()));
  const std::uint64_t begun = incarnation_;
  hear(Began{});
  if (begun == incarnation_) tell_surroundings();
}

void Service::kill_daemon() {
  if (!machine_) return;
  machine_.reset();
  ++incarnation_;
  batches_.clear();
  is_committing_ = false;
  tick_at_s_.reset();
  dies_at_save_.reset();
  events_.after(dice_.uniform(0.05, k_restart_s_max), [this] { begin_daemon(); });
}

void Service::hear(const Input& input) {
  if (!machine_) return;
  step(Tick{.now_s = events_.now_s() - ticks_begin_s_, .wall = wall()});
  step(input);
}

void Service::step(const Input& input) {
  ++outcome_.inputs;
  ledger_.tells(input, *machine_);
  std::vector<Effect> effects = machine_->step(input_with(scenario_.mistake, input, *machine_));
  effects = effects_with(scenario_.mistake, std::move(effects), dice_);
  ledger_.decides(effects, *machine_);
  // If an effect precedes a save, it doesn't wait for the save.
  Batch batch;
  for (Effect& effect : effects) {
    if (auto* save = std::get_if<Save>(&effect)) {
      if (!batch.rest.empty()) batches_.push_back(std::exchange(batch, {}));
      batch.save = std::move(*save);
    } else {
      batch.rest.push_back(std::move(effect));
    }
  }
  if (batch.save || !batch.rest.empty()) batches_.push_back(std::move(batch));
  pump();
  plan_tick();
}

void Service::plan_tick() {
  if (!machine_) return;
  const std::optional<double> next_s = machine_->next_tick_s();
  if (!next_s) return;
  const double at_s = std::max(events_.now_s(), *next_s + ticks_begin_s_);
  if (tick_at_s_ && *tick_at_s_ <= at_s) return;
  tick_at_s_ = at_s;
  events_.at(at_s, [this, at_s, begun = incarnation_] {
    if (begun != incarnation_ || !machine_ || tick_at_s_ != at_s) return;
    tick();
  });
}

void Service::tick() {
  tick_at_s_.reset();
  // Ticks come slightly late, because real clocks have a limited resolution.
  step(Tick{.now_s = events_.now_s() - ticks_begin_s_ + 1e-6, .wall = wall()});
}

/// Carries out effects up to the next save. The save takes simulated time.
void Service::pump() {
  while (machine_ && !is_committing_ && !batches_.empty()) {
    if (batches_.front().save) {
      is_committing_ = true;
      events_.after(dice_.uniform(k_commit_s_min, k_commit_s_max), [this, begun = incarnation_] {
        if (begun == incarnation_ && machine_) commit();
      });
      return;
    }
    const Batch batch = std::move(batches_.front());
    batches_.pop_front();
    if (!carry_out(batch.rest)) return;
  }
}

void Service::commit() {
  const std::optional<std::uint64_t> dies = std::exchange(dies_at_save_, std::nullopt);
  if (dies == 0U) return kill_daemon();
  Batch batch = std::move(batches_.front());
  batches_.pop_front();
  is_committing_ = false;
  know_new_jobs(*batch.save);
  ledger_.saves(*batch.save, store_);
  store_.apply(*batch.save);
  if (dies) {
    // The daemon dies before it has carried out all effects.
    batch.rest.resize(std::min<std::size_t>(batch.rest.size(), *dies - 1));
    carry_out(batch.rest);
    return kill_daemon();
  }
  if (carry_out(batch.rest)) pump();
}

/// Passes each new job's plan to the ledger and the backend.
void Service::know_new_jobs(const Save& save) {
  for (const Job& job : save.jobs) {
    if (store_.find(job.id) != nullptr) continue;
    const auto nth = static_cast<std::size_t>(std::stoull(job.content));
    ids_[nth] = job.id;
    ledger_.is_planned(job.id, scenario_.jobs[nth]);
    backend_.is_planned(job.id, scenario_.jobs[nth]);
  }
}

/// Returns false if the daemon died.
bool Service::carry_out(const std::vector<Effect>& effects) {
  const std::uint64_t begun = incarnation_;
  for (const Effect& effect : effects) {
    ledger_.carries_out(effect, store_);
    if (const auto* launch = std::get_if<Launch>(&effect)) {
      backend_.launch(*launch);
    } else if (const auto* stop = std::get_if<Stop>(&effect)) {
      backend_.stop(*stop);
    } else if (const auto* look = std::get_if<Look>(&effect)) {
      backend_.look(*look);
    } else if (const auto* remove = std::get_if<Remove>(&effect)) {
      backend_.remove(remove->job);
    } else if (const auto* answer = std::get_if<Answer>(&effect)) {
      answered(*answer);
    }
    if (begun != incarnation_) return false;
  }
  return true;
}

void Service::answered(const Answer& answer) {
  if (asks_open_.erase(answer.token) > 0 || answer.refusal) return;
  if (answer.token < scenario_.jobs.size()) accepted_.insert(answer.token);
}

void Service::submit(std::size_t nth) {
  if (accepted_.contains(nth)) return;
  const JobPlan& plan = scenario_.jobs[nth];
  const auto send = [this, nth, &plan] {
    hear(Submit{.token = nth,
                .user = plan.user,
                .client_key = fmt::format("key {}", nth),
                .content = fmt::format("{}", nth),
                .priority = plan.priority,
                .wishes = plan.wishes});
  };
  send();
  if (plan.is_submitted_twice) send();
  events_.after(machine_ ? k_submit_again_s : k_ask_again_s, [this, nth] { submit(nth); });
}

void Service::ask(std::size_t nth, AskKind kind, Token token) {
  if (!asks_open_.contains(token)) return;
  const auto id = ids_.find(nth);
  if (accepted_.contains(nth) && machine_) {
    ledger_.user_asks(id->second, kind);
    hear(Ask{.token = token,
             .user = scenario_.jobs[nth].user,
             .job = id->second,
             .kind = kind,
             .priority = 5});
  }
  events_.after(k_ask_again_s, [this, nth, kind, token] { ask(nth, kind, token); });
}

void Service::strike(const Fault& fault) {
  if (lasts(fault.kind)) {
    change(fault, true);
    events_.after(fault.for_s, [this, &fault] { change(fault, false); });
  } else if (fault.kind == Kind::server_dies) {
    kill_daemon();
  } else if (fault.kind == Kind::server_dies_at_save) {
    dies_at_save_ = fault.which % 5;
  } else if (fault.kind == Kind::place_taken) {
    backend_.take_place(fault.which);
  } else if (fault.kind == Kind::cancelled_by_hand) {
    backend_.cancel_by_hand(fault.which);
  } else if (fault.kind == Kind::keeper_dies) {
    backend_.kill(fault.which, fault.which % 4 == 0);
  } else {
    wall_offset_s_ += (static_cast<double>(fault.which % 5) - 2.5) * k_day_s;
  }
}

void Service::change(const Fault& fault, bool begins) {
  if (begins) {
    lasting_.push_back(&fault);
  } else {
    std::erase(lasting_, &fault);
  }
  Weather weather;
  bool is_full = false;
  bool is_away = false;
  bool is_other = false;
  for (const Fault* lasting : lasting_) {
    const auto worsen = [&](Kind kind, double& odds) {
      if (lasting->kind == kind) odds = std::max(odds, lasting->odds);
    };
    worsen(Kind::messages_lost, weather.lost);
    worsen(Kind::messages_twice, weather.doubled);
    worsen(Kind::messages_late, weather.late);
    worsen(Kind::messages_wrong, weather.wrong);
    is_full = is_full || lasting->kind == Kind::disk_fills;
    is_away = is_away || lasting->kind == Kind::backend_leaves;
    is_other = is_other || lasting->kind == Kind::programs_change;
  }
  backend_.set(weather);
  backend_.fill_disk(is_full);
  backend_.leave(is_away);
  backend_.change_programs(is_other);
  tell_surroundings();
}

/// Reports the state of disk and backend to the daemon. Sometimes omits a full disk or an
/// unreachable backend.
void Service::tell_surroundings() {
  Room room = scenario_.room;
  BackendNote note{.results_version = "ours"};
  bool is_draining = false;
  for (const Fault* lasting : lasting_) {
    const bool is_known = lasting->which % 3 != 0;
    if (lasting->kind == Kind::disk_fills && is_known)
      room.disk_free_bytes = room.disk_reserve_bytes / 2;
    if (lasting->kind == Kind::machine_shrinks) room.cores = std::max(1U, room.cores / 2);
    if (lasting->kind == Kind::backend_leaves && is_known) note.is_there = false;
    if (lasting->kind == Kind::programs_change) note.results_version = "theirs";
    is_draining = is_draining || lasting->kind == Kind::server_drains;
  }
  const std::uint64_t begun = incarnation_;
  hear(note);
  if (begun == incarnation_) hear(Drain{is_draining});
  if (begun == incarnation_) hear(room);
}

/// Makes users resume held jobs until all jobs have ended.
void Service::look_around() {
  if (machine_ && unfinished().empty()) {
    outcome_.is_finished = true;
    return;
  }
  for (const auto& [nth, id] : ids_) {
    const Job* job = store_.find(id);
    const bool waits_for_user =
        job != nullptr && job->state == State::held &&
        (job->reason == Reason::hold_asked || job->reason == Reason::cancelled_outside);
    if (!waits_for_user) continue;
    const Token token = next_ask_++;
    asks_open_.insert(token);
    ask(nth, AskKind::resume, token);
  }
  events_.after(k_look_around_s, [this] { look_around(); });
}

std::string Service::unfinished() const {
  if (accepted_.size() < scenario_.jobs.size())
    return fmt::format("{} of {} jobs are accepted", accepted_.size(), scenario_.jobs.size());
  for (const auto& [id, job] : store_.jobs()) {
    if (!is_over(job.state))
      return fmt::format("job {}: {}, {}, attempt {}, next start {:.1f} s of {:.1f} s", id,
                         name_of(job.state), name_of(job.reason), job.attempt, job.next_start_s,
                         store_.clock_s());
  }
  return backend_.anything_runs() ? "a program runs on" : "";
}

}  // namespace sleight::jobs::simulated
