// The closest points of two convex pieces of which at least one is round (round_piece.h).
//
// Idea. The gap along a unit axis n is the distance of the two frames' origins along it less both
// supports; the gap of the pieces is the greatest of these, and each is a lower bound. GJK (see
// closest_points.h) finds the axis: a round piece's points come from its support, one for each
// direction, in place of vertices. It is run on the pieces less their margins, which are apart when
// the pieces touch, so that the line between them has a direction. It ends when the bound along its
// axis has come up to the distance that it has reached. Rounding in small simplices often stops it
// before; then it starts again from there, with points that are all about the end, and goes up the
// slope of the bound, which is concave about its greatest value. What is left is mostly 1e-15 m,
// and was 1e-12 m at most in 30,000 pairs.
//
//   a point (or ball) and a piece of revolution: in closed form. In the half-plane through the axis
//   the axis of the gap is a normal of a straight part of the profile or points from a disc to the
//   point, and the greatest of these gaps is the gap.
//   a half-space and any piece: its support.
//
// Invariants
//   1. All results depend on shapes and poses alone, bit for bit.
//   2. gap_m is the support separation along `normal`, so it is at most the true gap, and at least
//      that less k_round_gap_error of the coordinates involved while the pieces less their margins
//      are apart. Where these overlap, which is deeper than any contact comes, gap_m is minus the
//      margins, and the normal is some direction.
//   3. No allocation; at most four descents of k_gjk_iterations_max iterations, and short climbs.
// `Closest::feature_a` and `feature_b` name nothing. Thread safety: pure functions.
#pragma once

#include <array>
#include <cmath>

#include "worker/physics/distance/closest_points.h"
#include "worker/physics/shape/round_piece.h"

namespace sleight::physics {

/// Of the sum of both outer radii and the distance of the frames: what a gap may fall short by.
inline constexpr double k_round_gap_error = 0x1p-32;

/// How far a piece of any kind reaches along a direction of its frame, of any length: the greatest
/// of c.u over its vertices, or RoundPiece::reach_m.
double reach_of_m(const ConvexView& piece, const Vec3& direction);

/// REQUIRES: one of the two is round; as closest_cold.
Closest closest_round(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                      const PlacedPose& pose_b);

/// Of the half-space dot(normal, p) <= offset_m and a round piece. Where a ring lies flat on the
/// plane, its point is the centre of the circle's disc.
Closest closest_round_to_plane(const Vec3& normal, double offset_m, const ConvexView& piece,
                               const PlacedPose& pose);

/// Calls found(point) for points of a round piece, in the world, that reach nearly as far as it
/// does along a world direction, less `within_m`: of a ring that lies flat, some of its circle.
template <class Found>
void for_each_point_near(const ConvexView& piece, const PlacedPose& pose, const Vec3& direction,
                         double within_m, const Found& found) {
  // Cosines of multiples of 45 degrees; the sine is the cosine two of them earlier.
  constexpr double k_half = 0.70710678118654752;
  constexpr std::array<double, 8> k_cosines{1, k_half, 0, -k_half, -1, -k_half, 0, k_half};
  const RoundPiece& round = *piece.round;
  const Vec3 u = transposed_product(pose.rotation, direction);
  const double reach_m = round.reach_m(u);
  const Vec3& axis = round.axis();
  Vec3 first = u - math::dot(axis, u) * axis;
  if (math::norm(first) < 1e-6) {
    first = std::fabs(axis.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
    first = first - math::dot(axis, first) * axis;
  }
  first = math::normalized(first);
  const Vec3 second = math::cross(axis, first);
  for (const RoundFeature& feature : round.features()) {
    const std::size_t points = feature.circle_m > 0 ? k_cosines.size() : 1;
    for (std::size_t i = 0; i < points; ++i) {
      const Vec3 outwards = k_cosines[i] * first + k_cosines[(i + 6) % k_cosines.size()] * second;
      const Vec3 point = feature.centre_m + feature.circle_m * outwards + feature.radius_m * u;
      if (math::dot(u, point) >= reach_m - within_m) found(to_world(pose, point));
    }
  }
}

}  // namespace sleight::physics
