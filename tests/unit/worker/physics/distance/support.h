// Random pieces and placements, a slow reference and a certificate, shared by the distance tests.
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

/// Random numbers of a test case, the same on every machine.
random::Stream numbers(std::uint64_t test, std::uint64_t index);
double between(random::Stream& stream, double low, double high);
/// Returns 10^u with uniform u, for sizes and gaps of many magnitudes.
double log_between(random::Stream& stream, double low, double high);
Vec3 random_vector(random::Stream& stream);  ///< uniform in the cube [-1, 1]^3
Vec3 random_unit(random::Stream& stream);
Mat3 random_rotation(random::Stream& stream);
/// One of the 24 exact rotations of a cube.
Mat3 quarter_turns(random::Stream& stream);

/// A polyhedron or a triangle. A Piece's views are valid while the Piece exists.
struct Piece {
  ConvexPolyhedron polyhedron;
  TrianglePiece triangle;
  bool is_triangle = false;
  std::string kind;
  ConvexView view() const { return is_triangle ? triangle.view() : polyhedron.view(); }
};

/// Returns a hull of 4 to 60 points, an icosphere, a cube, a cube with perturbed corners, a prism
/// or a triangle.
std::unique_ptr<Piece> random_piece(random::Stream& stream, double size_m);

struct Placement {
  PlacedPose a;
  PlacedPose b;
};

/// Places B around A. Orientations are random, parallel, or tilted by 1e-15 to 1e-3 rad. B is up to
/// several sizes away, or is shifted along the normal until the gap is 1e-9 to 1e-3 of the size.
Placement random_placement(random::Stream& stream, const ConvexView& a, const ConvexView& b,
                           double size_m);

/// Shifts B along the normal until the gap is `gap_m`. REQUIRES: A and B are separated.
PlacedPose at_gap(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                  const PlacedPose& pose_b, double gap_m);

/// Magnitude of both pieces' coordinates relative to A's centre. Rounding errors are proportional
/// to this magnitude.
double coordinates_m(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b);

/// Brute-force gap in long double: the least distance from a vertex to a triangle of a face, or
/// from an edge to an edge. Shares no code with the library. REQUIRES: A and B are separated.
long double reference_gap(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                          const PlacedPose& pose_b);

/// Greatest violation, in metres, of the following conditions on a result. Each point must be in
/// its piece, and points and pieces must be gap_m apart along the normal.
double certificate_defect(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                          const PlacedPose& pose_b, const Closest& result);

/// Distance of a world point from a piece. 0 inside.
double outside_m(const ConvexView& piece, const PlacedPose& pose, const Vec3& point_m);

/// Returns `count`, or ten times `count` if SLEIGHT_SOAK=1.
std::uint64_t soaked(std::uint64_t count);

}  // namespace sleight::physics
