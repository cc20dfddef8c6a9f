// Turns some bodies of random scenes into fixed bodies, and filters some pairs of groups.
//
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <array>

#include "tests/unit/worker/physics/simulator/dice.h"
#include "worker/physics/scene/scene.h"

namespace sleight::physics::testing {

inline CollisionGroup random_group(Dice& dice) {
  return {static_cast<std::uint8_t>(dice.below(3))};
}

/// Takes away what fixed bodies may not have.
inline void settle_fixed(Scene& scene) {
  for (BodyDescription& body : scene.bodies) {
    if (!body.fixed) continue;
    body.start.twist = {};
    body.start_tick = {};
    body.start_again = nullptr;
    body.rests = false;
    body.inertia.mass_kg = 0;
  }
  std::erase_if(scene.controls,
                [&](const Control& control) { return scene.bodies[control.body].fixed; });
}

/// Whether statics may change groups. Not where nothing can rest: in a pit without its floor, balls
/// would be wedged between the walls.
inline bool may_regroup_statics(const Scene& scene) {
  return scene.slow.rest_speed_mps > 0 || is_zero(scene.gravity_mps2);
}

/// Groups 1 and 2 don't meet. Bodies that start at rest, and what carries them, stay in group 0.
inline Scene fixed_and_filtered(Scene scene, Dice& dice) {
  const bool periodic = scene.period_m != std::array<double, 3>{};
  const bool some_rest = std::ranges::any_of(scene.bodies, &BodyDescription::rests);
  for (BodyDescription& body : scene.bodies) {
    body.fixed = dice.one_in(4) && !periodic;
    if (!some_rest) body.group = random_group(dice);
  }
  scene.filter.set_meet({1}, {2}, false);
  const auto regroup = [&](auto& statics) {
    for (auto& one : statics) {
      if (!some_rest && may_regroup_statics(scene) && dice.one_in(4))
        one.group = random_group(dice);
    }
  };
  regroup(scene.planes);
  regroup(scene.convexes);
  regroup(scene.meshes);
  settle_fixed(scene);
  return scene;
}

}  // namespace sleight::physics::testing
