// Compares runs that use an earlier run's history with runs that use no history.
//
// Thread safety: pure functions.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "tests/engines/engines.h"
#include "tests/unit/worker/physics/simulator/proposals.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics::testing {

/// Random options for a run that keeps its history, and mostly its impacts.
inline SimulationOptions random_way(Dice& dice) {
  SimulationOptions options;
  options.keep_history = true;
  switch (dice.below(8)) {
    case 0:
      options.algorithm = Algorithm::synchronous;
      break;
    case 1:
      options.algorithm = Algorithm::all_pairs;
      break;
    default:
      break;
  }
  const BroadPhaseKind boxes =
      dice.one_in(6) ? BroadPhaseKind::sweep_and_prune : BroadPhaseKind::hierarchical_grid;
  const auto queue = dice.below(6);
  options.keep_impacts = queue != 2;
  options.make_engine = engine_with(boxes, queue == 0   ? QueueKind::heap
                                           : queue == 1 ? QueueKind::calendar
                                                        : QueueKind::tournament);
  return options;
}

inline ::testing::AssertionResult same_state(const Simulation& a, const Simulation& b,
                                             std::size_t bodies) {
  for (std::uint32_t i = 0; i < bodies; ++i) {
    const BodyId body{i};
    if (a.started(body) != b.started(body))
      return ::testing::AssertionFailure() << "body " << i << " has started in one only";
    if (!a.started(body)) continue;
    const Tick now = a.now();
    const Pose p = a.pose(body, now);
    const Pose q = b.pose(body, now);
    const Twist v = a.twist(body, now);
    const Twist w = b.twist(body, now);
    if (p.position_m != q.position_m || p.orientation.coeffs() != q.orientation.coeffs() ||
        v.velocity_mps != w.velocity_mps || v.angular_velocity_radps != w.angular_velocity_radps ||
        a.mode(body) != b.mode(body))
      return ::testing::AssertionFailure() << "body " << i << " differs";
  }
  return ::testing::AssertionSuccess();
}

inline std::uint64_t changes_of(const Counts& counts) {
  return counts.collisions + counts.static_collisions + counts.controls + counts.starts +
         counts.modes + counts.rest_decisions;
}

inline std::string first_difference(const Recording& a, const Recording& b) {
  std::string found = "nowhere but at their ends";
  Tick first = k_never;
  for (std::uint32_t i = 0; i < a.bodies(); ++i) {
    const auto p = a.segments({i});
    const auto q = b.segments({i});
    for (std::size_t k = 0; k < std::max(p.size(), q.size()); ++k) {
      const bool same = k < p.size() && k < q.size() && p[k].cause == q[k].cause &&
                        same_bits(p[k].segment, q[k].segment);
      if (same) continue;
      const EventKey cause = k < p.size() ? p[k].cause : q[k].cause;
      if (cause.tick >= first) break;
      first = cause.tick;
      found = fmt::format("body {}, segment {} of {} and {}, tick {}, kind {}, {}, {}", i, k,
                          p.size(), q.size(), cause.tick.value, static_cast<int>(cause.kind),
                          cause.lower, cause.higher);
      break;
    }
  }
  return found;
}

/// Balls side by side on a floor. They soon come to rest.
inline Scene balls_apart(std::uint32_t count) {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.contacts = ContactTable(1, {.restitution = 0.5, .friction = 0.3, .rolling_friction = 0.05});
  scene.slow = scenes::slow_contacts_of(0.02);
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  for (std::uint32_t i = 0; i < count; ++i) {
    scene.bodies.push_back({.name = {},
                            .shape = Sphere{.radius_m = 0.01},
                            .inertia = solid_ball_inertia(0.01, 0.01),
                            .start = {.pose = {.position_m = {0.05 * i, 0, 0.03}}, .twist = {}}});
  }
  return scene;
}

struct RunResult {
  std::uint64_t digest = 0;
  Counts counts;
  std::shared_ptr<const History> history;
};

inline RunResult run(const Scene& scene, double duration_s,
                     std::shared_ptr<const History> history = nullptr,
                     SimulationOptions options = {}) {
  options.keep_history = true;
  Simulation simulation = Simulation::start(scene, options, std::move(history)).value();
  const auto error = simulation.run_until(Tick{} + ticks_after(duration_s));
  EXPECT_FALSE(error) << error->message;
  return {simulation.recording().digest(), simulation.counts(), simulation.history()};
}

}  // namespace sleight::physics::testing
