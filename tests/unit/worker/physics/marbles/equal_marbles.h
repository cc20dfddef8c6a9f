// A scene for Marbles.
#pragma once

#include <cstdint>

#include "tests/scenes/shared/scenes.h"

namespace sleight::physics::testing {

/// Equal balls that start one by one, and slide and roll over planes, a pedestal and a sheet.
inline scenes::Setting equal_marbles(std::uint32_t balls, std::uint64_t seed, TickCount interval) {
  scenes::Setting setting = scenes::marbles(balls, seed);
  std::uint32_t i = 0;
  for (BodyDescription& body : setting.scene.bodies) {
    const BodyDescription& first = setting.scene.bodies.front();
    body.shape = first.shape;
    body.inertia = first.inertia;
    body.material = first.material;
    body.start_tick = Tick{} + interval * i++;
  }
  return setting;
}

}  // namespace sleight::physics::testing
