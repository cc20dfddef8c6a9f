// Converts a simulator's recording to segments of common/motion.
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

struct RecordedBody {
  std::uint32_t feature = 0;                 ///< number in the scene description (common/scene)
  math::Quat turn = math::Quat::Identity();  ///< applied before each orientation
};

/// Maps an index in the simulator's static geometry to a fixed scene feature.
using FixedFeature = std::function<std::int32_t(std::uint32_t index)>;

/// Returns the segments of all bodies, ordered by (body, time).
/// REQUIRES: `bodies` has one entry per body of the recording. A body's moments of inertia are
/// equal, so the body turns about a fixed axis in flight.
std::vector<motion::Segment> recorded_segments(const physics::Recording& recording,
                                               std::span<const RecordedBody> bodies,
                                               const FixedFeature& fixed);

}  // namespace sleight::worlds
