#include "worker/worlds/user_scene/check/check.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

namespace sleight::worlds::user_scene {
namespace {

using physics::BodyId;
using physics::MotionMode;
using physics::Tick;

double seconds_at(Tick tick) {
  return physics::seconds(tick - Tick{});
}

std::uint64_t events_of(const physics::Counts& counts) {
  return counts.collisions + counts.static_collisions + counts.modes;
}

BodyOutcome outcome_of(const BuiltScene& built, const physics::Simulation& simulation,
                       BodyId body) {
  const Tick now = simulation.now();
  BodyOutcome result{.end = end_of(built, simulation, body)};
  if (result.end == BodyEnd::waits) return result;
  if (result.end == BodyEnd::rests) {
    const auto segments = simulation.recording().segments(body);
    auto first = segments.end() - 1;
    while (first != segments.begin() && (first - 1)->segment.mode == MotionMode::resting)
      --first;
    result.rests_since_s = seconds_at(first->segment.flight.begin);
  }
  result.place = composed(simulation.pose(body, now), inverse(built.objects[body].frame));
  result.speed_mps = math::norm(simulation.twist(body, now).velocity_mps);
  return result;
}

void add_hits(const BuiltScene& built, std::span<const physics::Impact> impacts, NominalRun& run) {
  const StaticOwners owners(built);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> index_of;
  for (const physics::Impact& impact : impacts) {
    const std::uint32_t a = impact.lower;
    const std::uint32_t b = owners.met_by(impact);
    const auto [at, is_first] = index_of.try_emplace({a, b}, run.hits.size());
    if (is_first) run.hits.push_back({.a = a, .b = b, .first_s = seconds_at(impact.tick)});
    ++run.hits[at->second].count;
    ++run.bodies[a].hits;
    if (b < built.moving) ++run.bodies[b].hits;
  }
}

}  // namespace

NominalRun nominal_run(const SceneDescription& description, const BuiltScene& built,
                       std::uint64_t events_max) {
  auto started = physics::Simulation::start(built.scene, {.keep_impacts = true});
  if (!started) return {.end = RunEnd::error, .error = started.error()};
  NominalRun result{.end = RunEnd::error};
  physics::Simulation simulation = std::move(started).value();
  const Tick end = Tick{} + physics::ticks_after(description.end_s);
  while (!result.error && simulation.now() < end && !all_ended(built, built.scene, simulation) &&
         events_of(simulation.counts()) <= events_max)
    result.error = simulation.run_until(std::min(end, simulation.now() + k_look_every));
  if (!result.error)
    result.end = all_ended(built, built.scene, simulation) ? RunEnd::all_ended
                 : simulation.now() == end                 ? RunEnd::time_over
                                                           : RunEnd::work_limit;
  result.end_s = seconds_at(simulation.now());
  for (BodyId body{}; body < built.moving; ++body)
    result.bodies.push_back(outcome_of(built, simulation, body));
  result.recording = std::make_shared<const physics::Recording>(simulation.recording());
  add_hits(built, simulation.impacts(), result);
  return result;
}

}  // namespace sleight::worlds::user_scene
