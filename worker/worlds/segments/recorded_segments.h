// A simulator's recording as archives hold it (common/motion).
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/math/rotation.h"
#include "common/motion/segment.h"
#include "worker/physics/reuse/recording.h"

namespace sleight::worlds {

/// How a world's archive calls what the simulator numbers.
struct FeatureNumbers {
  /// The feature of the scene (common/scene) of a recorded body.
  std::function<std::uint32_t(std::uint32_t body)> body;
  /// Of what doesn't move, by its index in the simulator's static geometry.
  std::function<std::int32_t(std::uint32_t index)> fixed;
};

/// The segments of one recorded body, in the order of time; `turn` comes before each orientation.
/// REQUIRES: its moments of inertia are equal, so that it turns about a fixed axis in flight.
std::vector<motion::Segment> recorded_segments(const physics::Recording& recording,
                                               std::uint32_t body, const FeatureNumbers& features,
                                               const math::Quat& turn = math::Quat::Identity());

}  // namespace sleight::worlds
