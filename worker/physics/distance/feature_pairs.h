// Pairs of features: gap, normal and points by the plain formula of each kind, and whether they are
// the closest of the whole pieces.
//
// All in A's frame. A pair is certified if its points lie on the features and both pieces lie
// beyond the planes through the points at right angles to the normal, which for convex pieces need
// only be asked of the neighbours. Internal to worker/physics/distance.
// Thread safety: pure functions.
#pragma once

#include "worker/physics/distance/closest_points.h"

namespace sleight::physics {

/// Two pieces, B's frame seen from A's.
struct PiecePair {
  const ConvexView& a;
  const ConvexView& b;
  PlacedPose b_in_a;
  /// What rounding does to a coordinate, with some room: 2^-50 of the largest that can occur.
  double rounding_m;

  PiecePair(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
            const PlacedPose& pose_b);
  Vec3 vertex_of_a(std::size_t index) const { return a.vertices_m[index]; }
  Vec3 vertex_of_b(std::size_t index) const { return to_world(b_in_a, b.vertices_m[index]); }
  /// A direction of A's frame in B's.
  Vec3 in_b(const Vec3& direction) const { return transposed_product(b_in_a.rotation, direction); }
};

/// As Closest, in A's frame.
struct LocalClosest {
  double gap_m = 0;
  Vec3 normal = Vec3::Zero();
  Vec3 point_a_m = Vec3::Zero();
  Vec3 point_b_m = Vec3::Zero();
  Feature a;
  Feature b;
  double normal_error_rad = 0;  ///< what rounding may have turned the normal by
};

/// Fills `out` for a pair of features with closest points inside both and a positive gap, without
/// asking whether the rest of the pieces is further away. False if there are none: parallel edges,
/// a foot beyond the feature's end, a gap <= 0. Not for edge-face and face-face.
bool closest_of_features(const PiecePair& pair, Feature a, Feature b, LocalClosest& out);

/// Whether the pieces lie beyond the planes of a result of closest_of_features.
bool certified(const PiecePair& pair, const LocalClosest& result);

/// Whether a certified result is the only one, by margins far beyond rounding: every search,
/// however it proceeds, then comes to these features, and so to the same bits. Only for the pairs
/// that two polyhedra meet at in general, a face and a vertex or two edges; false for others.
///
/// Why: let e = rounding_m, g the gap. Another pair with a gap of g to a few e has its line of
/// closest points within sqrt(2 e / g) of the normal; its points lie within g / 16 of the given
/// ones, which are further inside of their features. And where GJK weighs a vertex that is not of
/// these features, whose plane falls away by an angle f, the foot of the origin lies outside by g
/// f, some hundred e, so that it drops the vertex. Where it takes the pieces for overlapping by
/// mistake, face normals and edges' products decide, and they have this one.
bool only_one(const PiecePair& pair, const LocalClosest& result);

/// An edge or a face of one against a face of the other, parallel to rounding: the gap along a
/// face's normal, with the given points, which lie on the features. False if that is not the gap.
bool closest_of_parallel_features(const PiecePair& pair, Feature a, Feature b,
                                  const Vec3& point_a_m, const Vec3& point_b_m, LocalClosest& out);

}  // namespace sleight::physics
