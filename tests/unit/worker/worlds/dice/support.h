// Dice worlds and states for tests.
#pragma once

#include <cstdint>

#include "common/random/stream.h"
#include "worker/worlds/dice/dice.h"

namespace sleight::worlds::dice::testing {

inline random::Stream stream_of(std::uint64_t seed, std::uint64_t index) {
  return random::Stream({.seed = seed, .purpose = random::Purpose::prior}, index);
}

inline Vec3 vector_of(AxisDirection direction) {
  Vec3 v(0, 0, 0);
  v[direction.axis] = direction.sign;
  return v;
}

/// A table with all fields random, and `dice` dice.
inline Parameters all_random(std::uint32_t dice = 1) {
  Parameters parameters;
  parameters.world.table.restitution = {0.3, 0.7};
  parameters.world.table.friction = {0.2, 0.6};
  parameters.world.dice.assign(dice, DieStart{});
  for (std::uint32_t die = 0; die < dice; ++die)
    parameters.world.dice[die].position_m.y() = k_dice_apart_m * die;
  return parameters;
}

}  // namespace sleight::worlds::dice::testing
