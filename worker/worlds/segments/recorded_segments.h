// A simulator's recording as segments of common/motion, which everything else takes.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/math/rotation.h"
#include "common/motion/segment.h"
#include "worker/physics/reuse/recording.h"

namespace sleight::worlds {

/// A recorded body in the world's archive.
struct RecordedBody {
  std::uint32_t feature = 0;                 ///< of the scene (common/scene)
  math::Quat turn = math::Quat::Identity();  ///< comes before each orientation
};

/// The feature of what doesn't move, by its index in the simulator's static geometry.
using FixedFeature = std::function<std::int32_t(std::uint32_t index)>;

/// The segments of all bodies: body by body, each in the order of time.
/// REQUIRES: one of `bodies` for each in the recording; their moments of inertia are equal, so that
/// they turn about a fixed axis in flight.
std::vector<motion::Segment> recorded_segments(const physics::Recording& recording,
                                               std::span<const RecordedBody> bodies,
                                               const FixedFeature& fixed);

}  // namespace sleight::worlds
