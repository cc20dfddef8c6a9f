// The collisions that a simulation processed.
//
// Thread safety: values.
#pragma once

#include <cstdint>

#include "worker/physics/event/tick.h"

namespace sleight::physics {

/// A collision.
struct Impact {
  Tick tick{};
  std::uint32_t lower = 0;  ///< id of the first body
  /// Id of the other body, or k_static and the number of a static object: planes, convexes, meshes
  /// and surfaces are numbered in this order.
  std::uint32_t higher = 0;
  std::uint32_t noise_number = 0;  ///< see NoiseAddress; 0: without noise
  /// Speed at which the touching points approached along the contact normal, before the response.
  /// At least 0.
  double approach_mps = 0;
  friend bool operator==(const Impact&, const Impact&) = default;
};

}  // namespace sleight::physics
