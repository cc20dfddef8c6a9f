// Tells when bodies of a running simulation have ended: they rest, or have left the scene.
// Thread safety: pure functions.
#pragma once

#include <cstdint>

#include "worker/physics/simulator/simulation.h"
#include "worker/worlds/user_scene/build.h"

namespace sleight::worlds::user_scene {

enum class BodyEnd : std::uint8_t {
  waits,  ///< hasn't started
  moves,
  rests,
  left  ///< is further below everything than the scene's size, and no plane is below
};

/// Interval at which a simulation should be asked whether all bodies have ended.
inline constexpr physics::TickCount k_look_every = physics::ticks_after(1.0 / 64);

/// REQUIRES: the simulation is of a scene with the same static objects as `built`.
BodyEnd end_of(const BuiltScene& built, const physics::Simulation& simulation,
               physics::BodyId body);
/// Whether all moving bodies have ended. Bodies of the simulated `scene` that start at k_tick_max
/// don't count.
bool all_ended(const BuiltScene& built, const physics::Scene& scene,
               const physics::Simulation& simulation);

}  // namespace sleight::worlds::user_scene
