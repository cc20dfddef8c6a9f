// What the distance tests share: random pieces and placements, a slow reference, a certificate.
#pragma once

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "common/random/stream.h"
#include "worker/physics/distance/closest_points.h"
#include "worker/physics/distance/separation.h"
#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/shape/small_pieces.h"

namespace sleight::physics {

/// Numbers for a test case: the same on every machine.
random::Stream numbers(std::uint64_t test, std::uint64_t index);
double between(random::Stream& stream, double low, double high);
/// 10^u with u uniform, through exp: for sizes and gaps over decades.
double log_between(random::Stream& stream, double low, double high);
Vec3 random_vector(random::Stream& stream);  ///< uniform in the cube [-1, 1]^3
Vec3 random_unit(random::Stream& stream);
Mat3 random_rotation(random::Stream& stream);
/// One of the 24 rotations of a cube, exactly.
Mat3 quarter_turns(random::Stream& stream);

/// A polyhedron or a triangle; the view stays valid while it lives.
struct Piece {
  ConvexPolyhedron polyhedron;
  TrianglePiece triangle;
  bool is_triangle = false;
  std::string kind;
  ConvexView view() const { return is_triangle ? triangle.view() : polyhedron.view(); }
};

/// Hulls of 4 to 60 points, icospheres, cubes, cubes with perturbed corners, prisms, triangles.
std::unique_ptr<Piece> random_piece(random::Stream& stream, double size_m);

/// Two pieces and their poses.
struct Placement {
  PlacedPose a;
  PlacedPose b;
};

/// B somewhere around A: free or parallel orientations (exactly, or tilted by 1e-15 to 1e-3 rad),
/// apart by up to some sizes or shifted along the normal to a gap of 1e-9 to 1e-3 of the size.
Placement random_placement(random::Stream& stream, const ConvexView& a, const ConvexView& b,
                           double size_m);

/// B shifted along the normal until the gap is `gap_m`. REQUIRES: separated.
PlacedPose at_gap(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                  const PlacedPose& pose_b, double gap_m);

/// The coordinates that a pair's roundings grow with, as seen from A.
double coordinates_m(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b);

/// The gap by brute force in long double: least distance over all vertices and triangles of faces,
/// and all pairs of edges. Shares no code with the library. REQUIRES: separated.
long double reference_gap(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                          const PlacedPose& pose_b);

/// How far a result is from being proven, in metres: both points must lie in their pieces, be
/// gap_m apart along the normal, and the pieces must be separated by gap_m along it. 0 is perfect.
double certificate_defect(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                          const PlacedPose& pose_b, const Closest& result);

/// How far a point of the world is outside a piece; 0 inside.
double outside_m(const ConvexView& piece, const PlacedPose& pose, const Vec3& point_m);

/// `count`, or ten times as many where the environment says SLEIGHT_SOAK=1.
std::uint64_t soaked(std::uint64_t count);

}  // namespace sleight::physics
