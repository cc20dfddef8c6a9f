// Computes the closest points of two convex pieces if at least one is round (round_piece.h).
//
// Idea. Along a unit axis n, the separation is the distance of the frames' origins minus both
// supports. The gap is the maximum separation over all axes, so the separation along any axis is a
// lower bound. GJK (see closest_points.h) finds the axis of maximum separation. Instead of
// vertices, GJK uses a round piece's support, which is one point per direction. GJK runs on the
// pieces reduced by their margins. Even if the pieces touch, the reduced pieces are apart, so the
// line between them has a direction. GJK ends when the bound along its axis reaches the simplex's
// distance. Rounding in small simplices often stops GJK earlier. In this case GJK restarts from its
// last direction, so that all points are near the end. The search also climbs the slope of the
// bound, which is concave near its maximum. The remaining error is usually 1e-15 m, and was at most
// 1e-12 m in 30,000 pairs.
//
// Two cases have a closed form:
//   - A point (or ball) and a piece of revolution. In the half-plane of axis and point, candidates
//     for n are the normals of the profile's straight parts and the directions from discs to the
//     point. The gap is the greatest separation along a candidate.
//   - A half-space and any piece: the piece's support gives the closest point.
//
// Invariants
//   1. All results depend only on shapes and poses, bit for bit.
//   2. gap_m is the separation along `normal`, so it is at most the true gap. While the reduced
//      pieces are apart, gap_m is less than the true gap by at most k_round_gap_error of the
//      coordinates involved. If the reduced pieces overlap, gap_m is minus the sum of the margins
//      and the normal is arbitrary. No contact is so deep.
//   3. Nothing is allocated. A call makes at most four descents of k_gjk_iterations_max iterations,
//      and short climbs.
// `Closest::feature_a` and `feature_b` are not set. Thread safety: pure functions.
#pragma once

#include <array>
#include <cmath>

#include "worker/physics/distance/closest_points.h"
#include "worker/physics/shape/round_piece.h"

namespace sleight::physics {

/// Maximum error of a gap, relative to the sum of both outer radii and the frames' distance.
inline constexpr double k_round_gap_error = 0x1p-32;

/// Returns how far any piece reaches along a direction u of its frame. u may have any length. For a
/// polyhedron, the result is the greatest c.u over its vertices c; for a round piece,
/// RoundPiece::reach_m.
double reach_of_m(const ConvexView& piece, const Vec3& direction);

/// REQUIRES: at least one of the two pieces is round; also the requirements of closest_cold().
Closest closest_round(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                      const PlacedPose& pose_b);

/// Returns the closest points of the half-space dot(normal, p) <= offset_m and a round piece. If a
/// ring lies flat on the plane, the closest point is the centre of its circle.
Closest closest_round_to_plane(const Vec3& normal, double offset_m, const ConvexView& piece,
                               const PlacedPose& pose);

/// Calls found(point, in world coordinates) for points of a round piece that reach within
/// `within_m` of its furthest extent. `direction` is a world direction. A ring that lies flat has
/// several such points.
template <class Found>
void for_each_point_near(const ConvexView& piece, const PlacedPose& pose, const Vec3& direction,
                         double within_m, const Found& found) {
  // Cosines of multiples of 45 degrees. The sine of an angle is the cosine two entries earlier.
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
