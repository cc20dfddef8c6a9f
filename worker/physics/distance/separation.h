// Supports: how far a piece reaches in a direction, and bounds of the gap from that.
//
// Thread safety: pure functions.
#pragma once

#include "worker/physics/distance/placed_pose.h"
#include "worker/physics/shape/convex_polyhedron.h"

namespace sleight::physics {

/// The vertex furthest along a direction of the piece's frame, by a scan of all; the first of those
/// that round to the same reach.
std::uint16_t furthest_vertex(const ConvexView& piece, const Vec3& direction);

/// The same by climbing from neighbour to neighbour, for many vertices and a good start: its reach
/// is the greatest to rounding, but on a tie it may be another vertex.
std::uint16_t climbed_vertex(const ConvexView& piece, const Vec3& direction, std::uint16_t start);

/// Bound of the gap along a unit axis of the world: the least of dot(axis, B) less the greatest of
/// dot(axis, A). The gap is at least this, less separation_error_m below. Negative if the shadows
/// on the axis overlap. REQUIRES: |axis| = 1 to rounding.
double separation_along(const Vec3& axis, const ConvexView& a, const PlacedPose& pose_a,
                        const ConvexView& b, const PlacedPose& pose_b);

/// What rounding may add to separation_along, an axis of length 1 + 2^-51 included: 2^-49 of the
/// coordinates involved. Subtract it for a certified bound.
double separation_error_m(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                          const PlacedPose& pose_b);

}  // namespace sleight::physics
