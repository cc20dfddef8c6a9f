#include "worker/worlds/user_scene/user_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "common/random/linear_distributions.h"
#include "worker/physics/simulator/simulation.h"
#include "worker/sampling/log_sum.h"
#include "worker/worlds/failures/failure_of.h"
#include "worker/worlds/user_scene/end_watch.h"

namespace sleight::worlds::user_scene {
namespace {

physics::Tick tick_of(double time_s) {
  return physics::Tick{} + physics::ticks_after(time_s);
}

Views views_of(const BuiltScene& built, const physics::Simulation& simulation, physics::Tick tick) {
  Views views;
  for (physics::BodyId body{}; body < built.moving; ++body) {
    BodyView& view = views.emplace_back();
    view.takes_part = simulation.started(body);
    if (!view.takes_part) continue;
    view.rests = simulation.mode(body) == physics::MotionMode::resting;
    view.place = composed(simulation.pose(body, tick), inverse(built.objects[body].frame));
  }
  return views;
}

}  // namespace

UserScene::UserScene(const Parameters& parameters)
    : model_(std::make_shared<const Model>(parameters)) {}

State UserScene::draw_prior(random::Stream& stream) const {
  State state{.numbers = quantities().draw_prior(stream)};
  if (has_noise()) state.noise.key = stream.bits();
  return state;
}

Outcome UserScene::simulate_from(const State& candidate, const State& state, const Outcome& outcome,
                                 const Wanted& asked) const {
  // A renewal changes only noise that no impact used.
  const bool is_renewed =
      candidate.numbers == state.numbers && outcome.is_animation() &&
      std::ranges::all_of(outcome.noised, [&](const physics::Impact& impact) {
        return candidate.noise.at(address_of(impact)) == state.noise.at(address_of(impact));
      });
  if (is_renewed) return outcome;
  // As for dice: if nothing can be replayed, the candidate stores no history.
  const bool replays = quantities().resemble(candidate.numbers, state.numbers);
  Wanted wanted = asked;
  wanted.history = replays;
  return simulated(candidate, wanted, replays ? outcome.history : nullptr);
}

sampling::Progress UserScene::progress(const Outcome& outcome) const {
  sampling::Progress progress;
  if (!outcome.is_animation()) return progress;
  for (const Stage& stage : judge().stages()) {
    double score = 0;
    bool is_passed = true;
    for (const std::uint32_t i : stage.constraints) {
      const double distance = outcome.judgement.distances[i];
      if (std::isnan(distance)) return progress;  // not judged
      score += log_constraint_of(parameters().constraints[i], distance);
      is_passed = is_passed && outcome.judgement.met[i];
    }
    if (!is_passed) {
      progress.score = score;
      break;
    }
    ++progress.passed;
  }
  return progress;
}

std::string UserScene::stage_name(std::uint32_t stage) const {
  if (stages() == 1) return "all constraints";
  std::vector<std::string> names;
  for (const std::uint32_t constraint : judge().stages()[stage].constraints)
    names.push_back("'" + parameters().constraints[constraint].name + "'");
  return fmt::format("{}", fmt::join(names, ", "));
}

std::vector<sampling::MissKind> UserScene::miss_kinds() const {
  std::vector<sampling::MissKind> kinds;
  for (const Constraint& one : parameters().constraints)
    kinds.insert(kinds.begin(), {"'" + one.name + "'", unit_of(one).name});
  return kinds;
}

std::optional<sampling::Miss> UserScene::first_miss(const Outcome& outcome) const {
  const std::vector<Constraint>& constraints = parameters().constraints;
  for (const Stage& stage : judge().stages()) {
    for (const std::uint32_t i : stage.constraints) {
      if (!outcome.is_animation() || outcome.judgement.met[i]) continue;
      const double distance = outcome.judgement.distances[i];
      if (!(distance > constraints[i].tolerance)) return std::nullopt;  // e.g. not at rest
      return sampling::Miss{.kind = static_cast<std::uint32_t>(constraints.size() - 1 - i),
                            .amount = distance / unit_of(constraints[i]).scale};
    }
  }
  return std::nullopt;
}

Outcome UserScene::simulated(const State& state, const Wanted& wanted,
                             const std::shared_ptr<const physics::History>& history) const {
  const BuiltScene& built = *parameters().built;
  std::optional<physics::Scene> made = quantities().scene(state.numbers);
  if (!made) return {.end = End::impossible, .judgement = {.all_met = false}};
  if (has_noise()) made->noise.values = values_of(state.noise);
  const physics::Scene& scene = *made;
  const auto stopped = [&](const physics::SceneError& error) {
    // A scene that the simulator refuses comes from the state's values, not from a failure.
    plan::FailurePointer failure =
        physics::is_failure(error.kind) ? failure_of(error, encode(state)) : nullptr;
    return Outcome{.end = failure ? End::failed : End::impossible,
                   .judgement = {.all_met = false},
                   .failure = std::move(failure)};
  };
  const bool records = judge().needs_recording() || wanted.recording != nullptr;
  auto started = physics::Simulation::start(
      scene, {.record = records, .keep_history = wanted.history, .keep_impacts = true}, history);
  if (!started) return stopped(started.error());
  physics::Simulation simulation = std::move(started).value();

  const std::uint32_t stages = std::min(wanted.stages, this->stages());
  const bool waits = judge().waits_for_rest() && stages == this->stages();
  const double last_s = judge().stages()[stages - 1].until_s;
  const physics::Tick limit = tick_of(waits ? parameters().scene.end_s : last_s);
  const physics::Tick last = tick_of(last_s);
  std::uint32_t judged =
      wanted.stops_early ? 0 : stages - 1;  // The last stage is judged at the end.
  bool goes_on = true;
  std::vector<Views> at_times;
  const auto judged_now = [&](std::uint32_t first_stages) {
    return judge().judge({.scene = scene,
                          .at_times = at_times,
                          .at_end = views_of(built, simulation, simulation.now()),
                          .impacts = simulation.impacts(),
                          .recording = records ? &simulation.recording() : nullptr},
                         first_stages);
  };
  Outcome outcome{.end = waits ? End::time_limit : End::settled};
  for (physics::Tick now{};;) {
    const std::vector<double>& times_s = judge().times_s();
    while (at_times.size() < times_s.size() && tick_of(times_s[at_times.size()]) <= now)
      at_times.push_back(views_of(built, simulation, now));
    if (waits && now >= last && all_ended(built, scene, simulation)) outcome.end = End::settled;
    if (now >= limit || (outcome.end == End::settled && waits)) break;
    now = std::min(limit, now + k_look_every);
    if (at_times.size() < times_s.size()) now = std::min(now, tick_of(times_s[at_times.size()]));
    for (; goes_on && judged + 1 < stages; ++judged) {
      const physics::Tick until = tick_of(judge().stages()[judged].until_s);
      if (until >= now) break;
      if (const auto error = simulation.run_until(until)) return stopped(*error);
      outcome.judgement = judged_now(judged + 1);
      goes_on = outcome.judgement.all_met;
    }
    if (!goes_on) break;
    if (const auto error = simulation.run_until(now)) return stopped(*error);
    if (simulation.impacts().size() > k_collisions_max)
      return stopped({physics::SceneError::Kind::work_limit,
                      fmt::format("there are more than {} collisions", k_collisions_max)});
  }
  outcome.end_s = physics::seconds(simulation.now() - physics::Tick{});
  outcome.collisions = static_cast<std::uint32_t>(simulation.impacts().size());
  if (goes_on) outcome.judgement = judged_now(stages);
  std::ranges::copy_if(simulation.impacts(), std::back_inserter(outcome.noised),
                       [](const physics::Impact& impact) { return impact.noise_number > 0; });
  count_normals(state, outcome);
  if (wanted.history) outcome.history = simulation.history();
  if (wanted.recording != nullptr) *wanted.recording = simulation.recording();
  return outcome;
}

double UserScene::log_constraint(const Outcome& outcome) const {
  if (!outcome.is_animation()) return -std::numeric_limits<double>::infinity();
  return outcome.judgement.log_constraint;
}

sampling::Proposal<State> UserScene::propose(const State& state, const Outcome& outcome,
                                             std::span<const double> scales,
                                             random::Stream& stream) const {
  return user_scene::propose({.quantities = quantities(),
                              .has_noise = has_noise(),
                              .end_s = parameters().scene.end_s,
                              .noised = outcome.noised},
                             state, scales, stream);
}

double UserScene::log_q_ratio(const State& state, const Outcome& outcome,
                              const sampling::Proposal<State>& proposal,
                              const Outcome& candidate_outcome) const {
  return log_prior(state) - log_prior(proposal.candidate) +
         shot_log_ratio(outcome.noised, candidate_outcome.noised);
}

std::size_t UserScene::owned_bytes(const State& state, const Outcome& outcome) const {
  return (state.numbers.capacity() + outcome.judgement.distances.capacity()) * sizeof(double) +
         state.noise.overrides.capacity() * sizeof(NoiseOverride) +
         outcome.noised.capacity() * sizeof(physics::Impact) +
         (outcome.history ? outcome.history->bytes() : 0);
}

void UserScene::count_normals(const State& state, Outcome& outcome) const {
  const auto add = [&](double normal) {
    ++outcome.normals;
    outcome.squares += normal * normal;
  };
  for (std::size_t i = 0; i < state.numbers.size(); ++i) {
    if (quantities().is_normal(i)) add(state.numbers[i]);
  }
  for (const physics::Impact& impact : outcome.noised) {
    for (const double normal : state.noise.at(address_of(impact)))
      add(normal);
  }
}

std::vector<double> UserScene::outcome_values(const Outcome& outcome) const {
  std::vector<double> values{static_cast<double>(outcome.end), outcome.end_s,
                             static_cast<double>(outcome.collisions)};
  if (has_noise()) {
    values.push_back(outcome.normals);
    values.push_back(outcome.squares);
  }
  std::vector<double> distances = outcome.judgement.distances;
  distances.resize(parameters().constraints.size(), std::numeric_limits<double>::quiet_NaN());
  values.insert(values.end(), distances.begin(), distances.end());
  return values;
}

Animation UserScene::animate(const State& state) const {
  Animation animation;
  animation.outcome = simulated(state, {.recording = &animation.recording}, nullptr);
  return animation;
}

}  // namespace sleight::worlds::user_scene
