// Computes supports and bounds of the gap. A piece's support is its reach in a direction.
//
// Thread safety: pure functions.
#pragma once

#include "worker/physics/distance/placed_pose.h"
#include "worker/physics/shape/convex_polyhedron.h"

namespace sleight::physics {

/// Scans all vertices and returns the vertex furthest along a direction of the piece's frame. If
/// several have the same rounded reach, returns the first of them.
std::uint16_t furthest_vertex(const ConvexView& piece, const Vec3& direction);

/// Finds the furthest vertex by climbing from neighbour to neighbour. Useful for pieces with many
/// vertices and a good start. Up to rounding, no vertex reaches further. If several vertices reach
/// equally far, furthest_vertex may return another of them.
std::uint16_t climbed_vertex(const ConvexView& piece, const Vec3& direction, std::uint16_t start);

/// Returns a bound of the gap along a unit axis of the world: the least dot(axis, B) minus the
/// greatest dot(axis, A). The bound is negative if the pieces' shadows on the axis overlap. The gap
/// is at least this bound minus separation_error_m. REQUIRES: |axis| = 1 up to rounding.
double separation_along(const Vec3& axis, const ConvexView& a, const PlacedPose& pose_a,
                        const ConvexView& b, const PlacedPose& pose_b);

/// Returns how much rounding may add to separation_along(): 2^-49 of the coordinates involved. The
/// result is valid for axes of length up to 1 + 2^-51. Subtract this error to get a certified
/// bound.
double separation_error_m(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                          const PlacedPose& pose_b);

}  // namespace sleight::physics
