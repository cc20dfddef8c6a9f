#include "tests/jobs/wrong_parts.h"

#include <algorithm>
#include <utility>

namespace sleight::jobs::simulated {

Options options_with(Mistake mistake, Options options) {
  if (mistake == Mistake::user_limit_ignored) options.limits.cores = 0;
  if (mistake == Mistake::deaths_for_ever) options.deaths_max = 1'000'000;
  if (mistake == Mistake::no_back_off) options.back_off_first_s = options.back_off_last_s = 0;
  if (mistake == Mistake::deleted_unannounced) options.announce_s = 0;
  return options;
}

Restored restored_with(Mistake mistake, Restored restored) {
  if (mistake == Mistake::ids_come_again) {
    restored.next_id = 1;
    for (const Job& job : restored.jobs)
      restored.next_id = std::max(restored.next_id, job.id.value + 1);
  }
  for (Job& job : restored.jobs) {
    if (mistake == Mistake::done_runs_again && job.state == State::done && !job.is_leaving)
      job.state = State::queued;
    if (mistake == Mistake::open_attempts_forgotten && is_active(job.state)) {
      job.state = State::queued;
      job.cores = 0;
    }
    if (mistake == Mistake::same_attempt_again && job.state == State::queued &&
        job.attempt.value > 0)
      --job.attempt.value;
  }
  return restored;
}

namespace {

Counts* counts_of(Sight& sight) {
  if (auto* running = std::get_if<Running>(&sight.seen)) return &running->counts;
  if (auto* ended = std::get_if<Ended>(&sight.seen)) return &ended->counts;
  if (auto* died = std::get_if<Died>(&sight.seen)) return &died->counts;
  return nullptr;
}

Sight sight_with(Mistake mistake, Sight sight, const Jobs& machine) {
  auto* const ended = std::get_if<Ended>(&sight.seen);
  if (mistake == Mistake::any_attempt_counts) {
    if (const Job* job = machine.find(sight.job)) sight.attempt = job->attempt;
  } else if (mistake == Mistake::exit_code_decides && ended != nullptr) {
    ended->kind = ended->exit_code == 0 ? EndKind::finished : EndKind::none;
  } else if (mistake == Mistake::bug_is_a_death && ended != nullptr &&
             ended->kind == EndKind::bug) {
    ended->kind = EndKind::none;
  } else if (mistake == Mistake::cancelled_goes_on) {
    if (ended != nullptr) ended->outside = Outside::nothing;
    if (auto* died = std::get_if<Died>(&sight.seen)) died->outside = Outside::nothing;
  } else if (mistake == Mistake::commits_not_counted) {
    if (Counts* counts = counts_of(sight)) counts->scans = 0;
  }
  return sight;
}

}  // namespace

Input input_with(Mistake mistake, Input input, const Jobs& machine) {
  if (auto* tick = std::get_if<Tick>(&input)) {
    if (mistake == Mistake::wall_clock_decides) tick->now_s = tick->wall;
  } else if (auto* room = std::get_if<Room>(&input)) {
    if (mistake == Mistake::one_core_too_many) ++room->cores;
    if (mistake == Mistake::memory_not_counted) room->memory_bytes *= 1000;
    if (mistake == Mistake::reserve_ignored) room->disk_reserve_bytes = 0;
  } else if (auto* submit = std::get_if<Submit>(&input)) {
    if (mistake == Mistake::keys_ignored) submit->client_key.clear();
  } else if (auto* sight = std::get_if<Sight>(&input)) {
    return sight_with(mistake, std::move(*sight), machine);
  }
  return input;
}

std::vector<Effect> effects_with(Mistake mistake, std::vector<Effect> effects,
                                 cluster::Dice& dice) {
  if (mistake == Mistake::stops_forgotten)
    std::erase_if(effects, [](const Effect& e) { return std::holds_alternative<Stop>(e); });
  if (mistake == Mistake::looks_forgotten)
    std::erase_if(effects, [](const Effect& e) { return std::holds_alternative<Look>(e); });
  const bool has_save = !effects.empty() && std::holds_alternative<Save>(effects.front());
  if (!has_save) return effects;
  if (mistake == Mistake::half_a_save && dice.chance(0.1))
    std::get<Save>(effects.front()).changes.clear();
  if (mistake == Mistake::save_lost && dice.chance(0.1)) effects.erase(effects.begin());
  if (mistake == Mistake::effects_before_save)
    std::rotate(effects.begin(), effects.begin() + 1, effects.end());
  return effects;
}

ScenarioChoice where_it_shows(Mistake mistake) {
  using Kind = Fault::Kind;
  ScenarioChoice choice{.jobs_max = 100};
  switch (mistake) {
    case Mistake::ids_come_again:
      choice = {.jobs_max = 20, .wants = {Kind::server_dies}, .are_deleted = true};
      break;
    case Mistake::done_runs_again:
    case Mistake::open_attempts_forgotten:
    case Mistake::same_attempt_again:
      choice.wants = {Kind::server_dies, Kind::server_dies_at_save, Kind::keeper_dies};
      break;
    case Mistake::any_attempt_counts:
      choice.wants = {Kind::messages_late, Kind::messages_twice, Kind::keeper_dies};
      break;
    case Mistake::looks_forgotten:
      choice.wants = {Kind::server_dies, Kind::messages_lost};
      break;
    case Mistake::commits_not_counted:
    case Mistake::deaths_for_ever:
    case Mistake::no_back_off:
      choice.wants = {Kind::keeper_dies};
      break;
    case Mistake::cancelled_goes_on:
      choice.wants = {Kind::cancelled_by_hand};
      break;
    case Mistake::reserve_ignored:
      choice.wants = {Kind::disk_fills};
      break;
    case Mistake::wall_clock_decides:
      choice.wants = {Kind::wall_jumps};
      break;
    default:
      break;
  }
  return choice;
}

}  // namespace sleight::jobs::simulated
