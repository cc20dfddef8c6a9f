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

Outcome UserScene::simulate_from(const State& candidate, const State& state,
                                 const Outcome& outcome) const {
  // As for dice: if nothing can be replayed, the candidate stores no history.
  if (!quantities().resemble(candidate, state)) return simulate(candidate);
  return simulated(candidate, {.history = true}, outcome.history);
}

Outcome UserScene::simulated(const State& state, const Wanted& wanted,
                             const std::shared_ptr<const physics::History>& history) const {
  const BuiltScene& built = *parameters().built;
  const Judge& judge = model_->judge;
  const std::optional<physics::Scene> made = quantities().scene(state);
  if (!made) return {.end = End::impossible, .judgement = {.all_met = false}};
  const physics::Scene& scene = *made;
  const auto stopped = [&](const physics::SceneError& error) {
    // A scene that the simulator refuses comes from the state's values, not from a failure.
    plan::FailurePointer failure =
        physics::is_failure(error.kind) ? failure_of(error, encode(state)) : nullptr;
    return Outcome{.end = failure ? End::failed : End::impossible,
                   .judgement = {.all_met = false},
                   .failure = std::move(failure)};
  };
  const bool records = judge.needs_recording() || wanted.recording != nullptr;
  auto started = physics::Simulation::start(
      scene, {.record = records, .keep_history = wanted.history, .keep_impacts = true}, history);
  if (!started) return stopped(started.error());
  physics::Simulation simulation = std::move(started).value();

  const EndWatch watch(built, simulation);
  const physics::Tick limit =
      tick_of(judge.waits_for_rest() ? parameters().scene.end_s : judge.last_s());
  const physics::Tick last = tick_of(judge.last_s());
  std::vector<Views> at_times;
  Outcome outcome{.end = judge.waits_for_rest() ? End::time_limit : End::settled};
  for (physics::Tick now{};;) {
    const std::vector<double>& times_s = judge.times_s();
    while (at_times.size() < times_s.size() && tick_of(times_s[at_times.size()]) <= now)
      at_times.push_back(views_of(built, simulation, now));
    const bool all_ended = watch.all_ended(scene);
    if (judge.waits_for_rest() && all_ended && now >= last) outcome.end = End::settled;
    if (now >= limit || (outcome.end == End::settled && judge.waits_for_rest())) break;
    now = std::min(limit, now + k_look_every);
    if (at_times.size() < times_s.size()) now = std::min(now, tick_of(times_s[at_times.size()]));
    if (const auto error = simulation.run_until(now)) return stopped(*error);
    if (simulation.impacts().size() > k_collisions_max)
      return stopped({physics::SceneError::Kind::work_limit,
                      fmt::format("there are more than {} collisions", k_collisions_max)});
  }
  outcome.end_s = physics::seconds(simulation.now() - physics::Tick{});
  outcome.collisions = static_cast<std::uint32_t>(simulation.impacts().size());
  outcome.judgement = judge.judge({.scene = scene,
                                   .at_times = at_times,
                                   .at_end = views_of(built, simulation, simulation.now()),
                                   .impacts = simulation.impacts(),
                                   .recording = records ? &simulation.recording() : nullptr});
  if (wanted.history) outcome.history = simulation.history();
  if (wanted.recording != nullptr) *wanted.recording = simulation.recording();
  return outcome;
}

double UserScene::log_constraint(const Outcome& outcome) const {
  if (!outcome.is_animation()) return -std::numeric_limits<double>::infinity();
  return outcome.judgement.log_constraint;
}

// ---- proposals ----------------------------------------------------------------------------------

template <class Act>
void UserScene::for_block(Kind kind, random::Stream& stream, Act act) const {
  const auto one_of = [&](std::size_t count) {
    return static_cast<std::size_t>(random::UniformInteger{.count = count}.draw(stream));
  };
  const std::span<const Draw> draws = quantities().draws();
  const auto act_on = [&](const Draw& draw) {
    for (std::size_t i = 0; i < draw.numbers; ++i)
      act(draw.first_number + i);
  };
  if (draws.empty()) return;
  if (kind == Kind::redraw_draw || kind == Kind::step_draw)
    return act_on(draws[one_of(draws.size())]);
  if (kind == Kind::redraw_all || kind == Kind::step_all) {
    for (const Draw& draw : draws)
      act_on(draw);
    return;
  }
  const auto& of_bodies = quantities().draws_of_bodies();
  if (of_bodies.empty()) return;
  for (const std::size_t draw : of_bodies[one_of(of_bodies.size())])
    act_on(draws[draw]);
}

sampling::Proposal<Numbers> UserScene::propose(const State& state, std::span<const double> scales,
                                               random::Stream& stream) const {
  constexpr std::array k_shares{0.02, 0.08, 0.1, 0.1, 0.3, 0.4};
  constexpr double k_step = 0.5;
  constexpr std::uint64_t k_halvings = 5;
  const auto kind = static_cast<Kind>(random::draw_by_share(k_shares, stream));
  const double scale = scales.empty() ? 1 : scales[static_cast<std::size_t>(kind)];
  // A step's size is halved 0 to 5 times.
  const auto halvings =
      static_cast<int>(random::UniformInteger{.count = k_halvings + 1}.draw(stream));
  const double step = std::min(1.0, std::ldexp(k_step * scale, -halvings));
  const double keep = std::sqrt(1 - step * step);
  const bool redraws = kind < Kind::step_all;
  sampling::Proposal<State> proposal{.candidate = state, .kind = static_cast<std::uint32_t>(kind)};
  for_block(kind, stream, [&](std::size_t i) {
    double& number = proposal.candidate[i];
    if (!quantities().is_normal(i) && redraws) {
      number = stream.uniform();
      return;
    }
    const double normal = random::Normal{.mean = 0, .sd = 1}.draw(stream);
    if (quantities().is_normal(i)) {
      number = redraws ? normal : keep * number + step * normal;
    } else {
      // Reflect at 0 and 1.
      double along = number + 0.5 * step * normal;
      along -= 2 * std::floor(0.5 * along);
      number = along > 1 ? 2 - along : along;
      if (!(number > 0 && number < 1)) number = state[i];
    }
  });
  // Every move leaves the prior invariant and is reversible.
  proposal.log_q_ratio = log_prior(state) - log_prior(proposal.candidate);
  return proposal;
}

// ---- bytes and values ---------------------------------------------------------------------------

base::Bytes UserScene::encode(const State& state) const {
  base::ByteWriter writer;
  for (const double number : state)
    writer.put(number);
  return writer.take();
}

std::optional<Numbers> UserScene::decode(base::BytesView bytes) const {
  base::ByteReader reader(bytes);
  State state;
  for (std::size_t i = 0; i < quantities().size(); ++i) {
    const auto number = reader.get<double>();
    if (!number || !std::isfinite(*number)) return std::nullopt;
    if (!quantities().is_normal(i) && !(*number > 0 && *number < 1)) return std::nullopt;
    state.push_back(*number);
  }
  if (!reader.at_end()) return std::nullopt;
  return state;
}

std::size_t UserScene::owned_bytes(const State& state, const Outcome& outcome) const {
  return (state.capacity() + outcome.judgement.distances.capacity()) * sizeof(double) +
         (outcome.history ? outcome.history->bytes() : 0);
}

std::vector<double> UserScene::outcome_values(const Outcome& outcome) const {
  std::vector<double> values{static_cast<double>(outcome.end), outcome.end_s,
                             static_cast<double>(outcome.collisions)};
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

// ---- search -------------------------------------------------------------------------------------

SceneSearch UserScene::builder(const Guide& /*guide*/) const {
  return SceneSearch(*this);
}

std::optional<SceneSearch::Prefix> SceneSearch::attempt(const Prefix& /*prefix*/,
                                                        std::uint32_t /*stage*/,
                                                        sampling::SearchEffort& effort,
                                                        random::Stream& stream) const {
  constexpr std::uint32_t k_draws = 8;
  const auto steps = static_cast<std::uint32_t>(
      std::clamp<std::size_t>(40 * world_->quantities().draws().size(), 100, 2000));
  const auto look_at = [&](Prefix& one) {
    ++effort.simulations;
    if (world_->starts_overlap(one.outcome)) ++effort.overlapping_starts;
    if (one.outcome.failure) effort.failures.push_back(one.outcome.failure);
    return world_->log_constraint(one.outcome);
  };
  Prefix best;
  double best_log = sampling::k_log_zero;
  for (std::uint32_t nth = 0; nth < k_draws; ++nth) {
    Prefix one{.state = world_->draw_prior(stream), .outcome = {}};
    one.outcome = world_->simulate(one.state);
    const double log = look_at(one);
    if (world_->satisfied(one.outcome)) return one;
    if (nth > 0 && !(log > best_log)) continue;
    best = std::move(one);
    best_log = log;
  }
  // Anneal: log p_c counts more and more.
  for (std::uint32_t step = 0; step < steps; ++step) {
    auto proposal = world_->propose(best.state, stream);
    const double beta = (step + 1.0) / steps;
    Prefix one{.state = std::move(proposal.candidate), .outcome = {}};
    one.outcome = world_->simulate_from(one.state, best.state, best.outcome);
    const double log = look_at(one);
    if (world_->satisfied(one.outcome)) return one;
    const double log_u = math::log(stream.uniform());
    // The moves keep the prior, so only p_c decides.
    if (log == sampling::k_log_zero || beta * (log - best_log) < log_u) continue;
    best = std::move(one);
    best_log = log;
  }
  return std::nullopt;
}

}  // namespace sleight::worlds::user_scene
