// Computes a pair of features' gap, normal and points, and checks whether the pair is the closest.
//
// All values are in A's frame. Take the plane through each point of a pair, perpendicular to the
// normal. A pair is certified if its points are on the features, and each piece is beyond the plane
// through its point. Pieces are convex, so it is enough to check the features' neighbours. Internal
// to worker/physics/distance. Thread safety: pure functions.
#pragma once

#include "worker/physics/distance/closest_points.h"

namespace sleight::physics {

/// Two pieces, seen from A's frame.
struct PiecePair {
  const ConvexView& a;
  const ConvexView& b;
  PlacedPose b_in_a;
  /// Generous bound on a coordinate's rounding: 2^-50 of the largest possible coordinate.
  double rounding_m;

  PiecePair(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
            const PlacedPose& pose_b);
  Vec3 vertex_of_a(std::size_t index) const { return a.vertices_m[index]; }
  Vec3 vertex_of_b(std::size_t index) const { return to_world(b_in_a, b.vertices_m[index]); }
  Vec3 in_b(const Vec3& direction) const { return transposed_product(b_in_a.rotation, direction); }
};

/// Like Closest, in A's frame.
struct LocalClosest {
  double gap_m = 0;
  Vec3 normal = Vec3::Zero();
  Vec3 point_a_m = Vec3::Zero();
  Vec3 point_b_m = Vec3::Zero();
  Feature a;
  Feature b;
  double normal_error_rad = 0;  ///< bound on the normal's rounding
};

/// Computes `out` without checking the rest of the pieces. Returns false if edges are parallel, a
/// foot is beyond a feature's end, or the gap is <= 0. Not for edge-face and face-face.
bool closest_of_features(const PiecePair& pair, Feature a, Feature b, LocalClosest& out);

/// Returns whether the pieces are beyond the planes that certify a result of closest_of_features().
bool certified(const PiecePair& pair, const LocalClosest& result);

/// Returns whether a certified result is unique. The margins are far larger than rounding. Every
/// search finds the features of a unique result, and so computes the same bits. Returns true only
/// for a face and a vertex, or for two edges. Polyhedra generally meet at such features.
///
/// Proof: let e = rounding_m and g the gap. If another pair's gap is within a few e of g, its line
/// of closest points is within sqrt(2 e / g) of the normal. So the other pair's points are within g
/// / 16 of the given points. The given points are inside their features by more than g / 16.
/// Suppose that GJK gives weight to a vertex that isn't on these features. Let f be the angle by
/// which the vertex's plane falls away. Then the origin's foot is outside by g f, some hundred e,
/// so GJK drops the vertex. If GJK wrongly finds overlap, face normals and products of edges
/// decide. This normal is one of them.
bool only_one(const PiecePair& pair, const LocalClosest& result);

/// Computes `out` for a face and a second feature, a face or an edge that is parallel up to
/// rounding. `point_a_m` and `point_b_m` are points on the features. The gap is measured along a
/// face's normal. Returns false if these points are not the closest ones, or the gap isn't
/// positive.
bool closest_of_parallel_features(const PiecePair& pair, Feature a, Feature b,
                                  const Vec3& point_a_m, const Vec3& point_b_m, LocalClosest& out);

}  // namespace sleight::physics
