// Compares the results of Marbles and Simulation for a scene.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "worker/physics/marbles/marbles.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics::testing {

/// Number of balls whose place, twist or mode differs in any bit. Skips suspended balls. REQUIRES:
/// both engines are at the same tick.
inline int different_balls(const Simulation& simulation, const Marbles& marbles) {
  int different = 0;
  for (std::uint32_t i = 0; i < marbles.size(); ++i) {
    const BodyId ball{i};
    if (simulation.started(ball) != marbles.started(ball)) ++different;
    if (!marbles.started(ball) || marbles.is_suspended(ball)) continue;
    const Twist expected = simulation.twist(ball, simulation.now());
    const Twist twist = marbles.twist(ball);
    const bool same =
        simulation.pose(ball, simulation.now()).position_m == marbles.position_m(ball) &&
        expected.velocity_mps == twist.velocity_mps &&
        expected.angular_velocity_radps == twist.angular_velocity_radps &&
        simulation.mode(ball) == marbles.mode(ball);
    if (!same) ++different;
  }
  return different;
}

/// Runs both engines to a tick and compares their balls. Sets `goes_on` to false if an engine
/// failed, else to true.
inline ::testing::AssertionResult alike_at(Simulation& simulation, Marbles& marbles, Tick tick,
                                           bool& goes_on) {
  const auto expected = simulation.run_until(tick);
  const auto error = marbles.run_until(tick);
  goes_on = !expected && !error;
  if (expected.has_value() != error.has_value() || (error && error->message != expected->message))
    return ::testing::AssertionFailure() << "errors: " << (expected ? expected->message : "none")
                                         << " against " << (error ? error->message : "none");
  const int different = goes_on ? different_balls(simulation, marbles) : 0;
  if (different == 0) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << different << " balls differ at tick " << tick.value;
}

}  // namespace sleight::physics::testing
