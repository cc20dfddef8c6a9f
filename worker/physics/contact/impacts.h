// The collisions that a simulation processed.
//
// Thread safety: values.
#pragma once

#include <cstdint>

#include "worker/physics/event/tick.h"

namespace sleight::physics {

/// A collision. Its pair is that of the event's key (EventKey).
struct Impact {
  Tick tick{};
  std::uint32_t lower = 0;  ///< id of the first body
  /// Id of the other body, or k_static and a StaticId: a feature if the body is a sphere, otherwise
  /// a piece. Surfaces are numbered after the pieces.
  std::uint32_t higher = 0;
  /// Speed at which the touching points approached along the contact normal, before the response.
  /// At least 0.
  double approach_mps = 0;
  friend bool operator==(const Impact&, const Impact&) = default;
};

}  // namespace sleight::physics
