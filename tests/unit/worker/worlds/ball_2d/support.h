// Balls and normals for tests.
#pragma once

#include <cmath>
#include <cstdint>

#include "common/random/linear_distributions.h"
#include "common/random/stream.h"
#include "worker/worlds/ball_2d/motion.h"

namespace sleight::worlds::ball_2d::testing {

inline constexpr double k_degree_rad = 0.017453292519943295;

inline random::Stream stream_of(std::uint64_t seed, std::uint64_t index) {
  return random::Stream({.seed = seed, .purpose = random::Purpose::prior}, index);
}

/// Surface normals. The angles are independent and normally distributed, with a given standard
/// deviation.
inline NormalAngles random_normals(const WorldParameters& world, double sd_rad,
                                   random::Stream& stream) {
  NormalAngles normals{};
  for (std::uint32_t i = 0; i < world.collisions; ++i)
    normals[i] = random::Normal{.mean = 0, .sd = sd_rad}.draw(stream);
  return normals;
}

inline WorldParameters random_world(random::Stream& stream) {
  WorldParameters world;
  world.diameter_m = 0.01 + stream.uniform();
  world.gravity_mps2 = 0.5 + 20 * stream.uniform();
  world.drop_height_diameters = 0.1 + 20 * stream.uniform();
  world.collisions = 1 + static_cast<std::uint32_t>(stream.bits() % 12);
  world.restitution = 0.05 + 0.95 * stream.uniform();
  return world;
}

inline double impact_speed(const WorldParameters& world) {
  return std::sqrt(2 * world.gravity_mps2 * world.drop_height_diameters * world.diameter_m);
}

}  // namespace sleight::worlds::ball_2d::testing
