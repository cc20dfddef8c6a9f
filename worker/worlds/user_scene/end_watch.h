// Tells when bodies of a running simulation have ended: they rest, or have left the scene.
// Not thread-safe.
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

class EndWatch {
 public:
  /// REQUIRES: both outlive this object; the simulation is of a scene with the same static objects.
  EndWatch(const BuiltScene& built, const physics::Simulation& simulation)
      : built_(built), simulation_(simulation) {}

  BodyEnd end_of(physics::BodyId body) const;
  /// Whether all moving bodies have ended. Bodies that start at k_tick_max don't count.
  bool all_ended(const physics::Scene& scene) const;

 private:
  const BuiltScene& built_;
  const physics::Simulation& simulation_;
};

}  // namespace sleight::worlds::user_scene
