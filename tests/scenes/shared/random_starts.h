// Random initial states of scenes, and the gravity of most scenes.
//
// Thread safety: functions change only the stream.
#pragma once

#include "common/random/distributions.h"
#include "common/random/stream.h"
#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics::scenes {

inline constexpr double k_gravity_mps2 = 9.81;

inline random::Stream stream_of_scene(std::uint64_t seed, std::uint64_t part) {
  return random::Stream({.seed = seed, .purpose = random::Purpose::scene}, part);
}

inline double between(random::Stream& stream, double low, double high) {
  return low + (high - low) * stream.uniform();
}

inline Vec3 vector_between(random::Stream& stream, double low, double high) {
  const double x = between(stream, low, high);
  const double y = between(stream, low, high);
  const double z = between(stream, low, high);
  return {x, y, z};
}

}  // namespace sleight::physics::scenes
