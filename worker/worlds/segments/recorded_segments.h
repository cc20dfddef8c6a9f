// Converts a simulator's recording to segments of common/motion.
//
// Idea. A recorded segment whose place is a parabola and whose angular velocity changes linearly is
// one segment of common/motion. All other recorded segments are cut into pieces: the flight of a
// body that tumbles, and the motion of a frame that isn't at the centre of mass of a body that
// turns. A piece starts with the exact pose, velocity and angular velocity. Its constant
// accelerations make it end in the exact pose. The piece is shortened until it is accurate.
//
// Invariants
//   1. A piece deviates from the simulator's motion by at most k_turn_off_rad. The shown origin and
//      the centre of mass deviate by at most k_place_off times the body's reach. If a body turns by
//      more than some 30,000 rad in one segment, only the pieces' starts are accurate.
//   2. A cut's pieces have the same mode. All but the first have the cause `mode`.
//   3. If the body is spherical and its frame is at the centre of mass, nothing is cut.
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/motion/segment.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/reuse/recording.h"

namespace sleight::worlds {

/// Maximum angle between a piece's orientation and the simulator's. At 1 m, 1 mm.
inline constexpr double k_turn_off_rad = 1e-3;
/// Maximum deviation of a place, as a share of the body's reach.
inline constexpr double k_place_off = 1e-3;

struct RecordedBody {
  std::uint32_t feature = 0;  ///< number in the scene description (common/scene)
  /// The frame that archives show, in the simulator's body frame.
  physics::Pose frame{};
  /// Only the symmetry and the ratios of the moments are used.
  physics::Inertia inertia{
      .mass_kg = 1, .principal_kgm2 = {1, 1, 1}, .symmetry = physics::InertiaSymmetry::spherical};
  /// Distance of the body's furthest point from its centre of mass. Needed if the frame's origin is
  /// elsewhere.
  double reach_m = 0;
  bool moves = true;  ///< a body that doesn't move has no segments, but can be a partner
};

/// Maps an index in the simulator's static geometry to a fixed scene feature. `body`: the body of
/// the recording that met it.
using FixedFeature = std::function<std::int32_t(std::uint32_t body, std::uint32_t index)>;

/// Returns the segments of all moving bodies, ordered by (body, time).
/// REQUIRES: `bodies` has one entry per body of the recording.
std::vector<motion::Segment> recorded_segments(const physics::Recording& recording,
                                               std::span<const RecordedBody> bodies,
                                               const FixedFeature& fixed);

}  // namespace sleight::worlds
