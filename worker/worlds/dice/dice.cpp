#include "worker/worlds/dice/dice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "common/base/check.h"
#include "worker/physics/shape/shapes.h"
#include "worker/physics/simulator/simulation.h"
#include "worker/physics/surface/spline_surface.h"
#include "worker/worlds/failures/failure_of.h"

namespace sleight::worlds::dice {
namespace {

/// Interval at which the simulation tests whether all dice are at rest.
constexpr double k_look_every_s = 0.1;

physics::Tick tick_of(double time_s) {
  return physics::Tick{} + physics::ticks_after(time_s);
}

/// Whether a candidate and a state have the same table key, and at least one die that starts alike.
bool resembles(const State& candidate, const State& state) {
  if (candidate.table_key != state.table_key) return false;
  for (std::size_t die = 0; die < state.dice.size(); ++die) {
    if (candidate.dice[die] == state.dice[die]) return true;
  }
  return false;
}

DieView view_of(const physics::Simulation& simulation, physics::BodyId body,
                const physics::BodyDescription& description, physics::Tick tick) {
  if (!simulation.started(body)) {
    return {.position_m = description.start.pose.position_m,
            .orientation = description.start.pose.orientation,
            .velocity_mps = description.start.twist.velocity_mps};
  }
  const physics::Pose pose = simulation.pose(body, tick);
  return {.position_m = pose.position_m,
          .orientation = pose.orientation,
          .velocity_mps = simulation.twist(body, tick).velocity_mps};
}

bool rests(const physics::Simulation& simulation, physics::BodyId body) {
  return simulation.started(body) && simulation.mode(body) == physics::MotionMode::resting;
}

}  // namespace

std::size_t offset_bin_of(double score) {
  constexpr double k_last = k_offset_bins - 1;
  const double bin = std::floor((score - k_offset_first_sd) / k_offset_step_sd) + 1;
  return static_cast<std::size_t>(std::clamp(bin, 0.0, k_last));
}

Dice::Dice(const Parameters& parameters)
    : parameters_(parameters), times_s_(goal_times(parameters.goals)) {
  CHECK(!parameters_.world.dice.empty());
  auto cube = std::make_shared<physics::Compound>();
  cube->parts.push_back(physics::cube(parameters_.world.side_m).value());
  cube_ = std::move(cube);
}

physics::Scene Dice::scene(const State& state) const {
  const WorldParameters& world = parameters_.world;
  physics::Scene scene;
  scene.gravity_mps2 = {0, 0, -world.gravity_mps2};
  scene.contacts = physics::ContactTable(
      1, {.restitution = world.dice_restitution, .friction = world.dice_friction});
  scene.slow = physics::coarse_slow_contacts_of(world.side_m, world.gravity_mps2);
  scene.surfaces.push_back(
      {.name = "table",
       .controls = std::make_shared<RandomTable>(world.table, state.table_key, state.overrides),
       .spacing_m = world.table.spacing_m});
  const double mass_kg = world.density_kgpm3 * world.side_m * world.side_m * world.side_m;
  const double moment_kgm2 = mass_kg * world.side_m * world.side_m / 6;
  for (std::size_t die = 0; die < state.dice.size(); ++die) {
    const DieThrow& one = state.dice[die];
    physics::BodyDescription body;
    body.name = fmt::format("die {}", die + 1);
    body.shape = cube_;
    body.inertia = {.mass_kg = mass_kg,
                    .principal_kgm2 = {moment_kgm2, moment_kgm2, moment_kgm2},
                    .symmetry = physics::InertiaSymmetry::spherical};
    body.start = {
        .pose = {.position_m = one.position_m, .orientation = one.orientation},
        .twist = {.velocity_mps = one.velocity_mps, .angular_velocity_radps = one.spin_radps}};
    body.start_tick = tick_of(world.dice[die].start_s);
    scene.bodies.push_back(std::move(body));
  }
  return scene;
}

Outcome Dice::simulate(const State& state) const {
  return simulated(state, {}, nullptr);
}

ViewedOutcome Dice::simulate_and_view(const State& state) const {
  ViewedOutcome seen;
  seen.outcome = simulated(state, {.views = &seen.views}, nullptr);
  return seen;
}

Outcome Dice::simulate_from(const State& candidate, const State& state,
                            const Outcome& outcome) const {
  // If the candidate doesn't resemble the state, nothing can be replayed. The candidate then stores
  // no history, because most such candidates are rejected. After an acceptance, the next candidate
  // that resembles the new state stores a history.
  if (!resembles(candidate, state)) return simulate(candidate);
  return simulated(candidate, {.history = true}, outcome.history);
}

Outcome Dice::simulated(const State& state, const Wanted& wanted,
                        const std::shared_ptr<const physics::History>& history) const {
  const physics::Scene scene = this->scene(state);
  const auto stopped = [&](const physics::SceneError& error) {
    plan::FailurePointer failure = failure_of(error, encode(state));
    return Outcome{.end = failure ? End::failed : End::impossible,
                   .judgement = {.all_met = false},
                   .failure = std::move(failure)};
  };
  auto started =
      physics::Simulation::start(scene, {.record = true, .keep_history = wanted.history}, history);
  if (!started) return stopped(started.error());
  physics::Simulation simulation = std::move(started).value();

  // Simulate up to each goal's time, then until all dice rest.
  const physics::Tick limit = tick_of(parameters_.world.time_max_s);
  Views views;
  Outcome outcome{.end = End::time_limit};
  std::size_t seen = 0;
  for (physics::Tick now{}; now < limit || seen < times_s_.size();) {
    const physics::Tick goal = seen < times_s_.size() ? tick_of(times_s_[seen]) : physics::k_never;
    if (goal == now || (outcome.end == End::settled && seen < times_s_.size())) {
      // Dice at rest don't change later.
      for (std::uint32_t die = 0; die < dice(); ++die)
        views.at_times.push_back(view_of(simulation, {die}, scene.bodies[die], now));
      ++seen;
      continue;
    }
    if (outcome.end == End::settled) break;
    now = std::min({limit, goal, now + physics::ticks_after(k_look_every_s)});
    if (const auto error = simulation.run_until(now)) return stopped(*error);
    bool all_rest = true;
    for (std::uint32_t die = 0; die < dice(); ++die)
      all_rest = all_rest && rests(simulation, {die});
    if (all_rest) outcome.end = End::settled;
  }

  // Evaluate the end.
  const physics::Recording& recorded = simulation.recording();
  for (std::uint32_t die = 0; die < dice(); ++die) {
    views.at_end.push_back(view_of(simulation, {die}, scene.bodies[die], simulation.now()));
    views.rest_s.push_back(
        rests(simulation, {die})
            ? physics::seconds(recorded.segments({die}).back().segment.flight.begin -
                               physics::Tick{})
            : parameters_.world.time_max_s);
  }
  outcome.end_s = *std::ranges::max_element(views.rest_s);
  outcome.judgement = judge(parameters_.goals, parameters_.numbering, views, times_s_);
  look_at_contacts(state, scene, simulation.surface_touches(), outcome);
  if (wanted.history) outcome.history = simulation.history();
  if (wanted.recording != nullptr) *wanted.recording = recorded;
  outcome.at_end = views.at_end;
  if (wanted.views != nullptr) *wanted.views = std::move(views);
  return outcome;
}

void Dice::look_at_contacts(const State& state, const physics::Scene& scene,
                            std::span<const physics::SurfaceTouch> touches,
                            Outcome& outcome) const {
  const physics::SplineSurface surface(scene.surfaces.front());
  outcome.collisions = static_cast<std::uint32_t>(touches.size());
  if (touches.empty()) return;

  // Compute each control point's mean weight. Sum in the order of collisions. A collision's weight
  // is the duration of the die's preceding flight, because most collisions are small bounces of a
  // settling die.
  std::map<GridIndex, double> sums;
  std::vector<physics::Tick> before;
  for (const physics::BodyDescription& body : scene.bodies)
    before.push_back(body.start_tick);
  double flown_s = 0;
  for (const physics::SurfaceTouch& touch : touches) {
    // If a collision is in the same tick as the previous collision, the flight counts as one tick.
    const double flight_s =
        physics::seconds(std::max<physics::TickCount>(1, touch.tick - before[touch.body]));
    before[touch.body] = touch.tick;
    flown_s += flight_s;
    const double x_m = touch.point_m.x();
    const double y_m = touch.point_m.y();
    const auto points = physics::SplineSurface::support(surface.patch_at(x_m, y_m));
    const auto weights = surface.weights_at(x_m, y_m);
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (weights[k] > 0 && is_on_table(parameters_.world.table, points[k]))
        sums[points[k]] += weights[k] * flight_s;
    }
  }
  outcome.contacts.reserve(sums.size());
  for (const auto& [index, sum] : sums) {
    outcome.contacts.push_back({index, sum / flown_s});
    const SurfaceControl control = control_at(parameters_.world, state, index);
    outcome.log_plausibility += log_density_of(parameters_.world.table, control);
    if (parameters_.world.table.height_sd_m <= 0) continue;
    const double height_sds = control.height_m / parameters_.world.table.height_sd_m;
    ++outcome.offsets[offset_bin_of(height_sds)];
    outcome.offset_squares += height_sds * height_sds;
  }
}

double Dice::log_constraint(const Outcome& outcome) const {
  if (!outcome.is_animation()) return -std::numeric_limits<double>::infinity();
  return outcome.judgement.log_constraint;
}

std::size_t Dice::owned_bytes(const State& state, const Outcome& outcome) const {
  const Judgement& judgement = outcome.judgement;
  return state.overrides.capacity() * sizeof(Override) + state.dice.capacity() * sizeof(DieThrow) +
         outcome.contacts.capacity() * sizeof(ContactShare) +
         outcome.at_end.capacity() * sizeof(DieView) +
         judgement.distances.capacity() * sizeof(double) +
         judgement.numberings.capacity() * sizeof(std::uint32_t) +
         (outcome.history ? outcome.history->bytes() : 0);
}

std::vector<double> Dice::outcome_values(const Outcome& outcome) const {
  std::vector<double> values{static_cast<double>(outcome.end), outcome.end_s,
                             static_cast<double>(outcome.collisions), outcome.log_plausibility,
                             outcome.offset_squares};
  values.insert(values.end(), outcome.offsets.begin(), outcome.offsets.end());
  for (std::size_t goal = 0; goal < parameters_.goals.size(); ++goal) {
    values.push_back(outcome.is_animation() ? outcome.judgement.distances[goal]
                                            : std::numeric_limits<double>::quiet_NaN());
  }
  return values;
}

Animation Dice::animate(const State& state) const {
  Animation animation;
  animation.outcome = simulated(state, {.recording = &animation.recording}, nullptr);
  return animation;
}

}  // namespace sleight::worlds::dice
