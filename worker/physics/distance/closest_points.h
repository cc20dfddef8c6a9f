// The closest points of two convex pieces, and their distance or overlap.
//
// Idea. The gap of two separate convex bodies is both the least distance of a point of A from a
// point of B and the greatest separation of A and B along any direction. This property certifies a
// result: two points, each on a named feature (vertex, edge, face), are the closest if they are as
// far apart as the bodies are along the line between the points. The searches below only propose
// features. One function then computes the gap, normal and points of a pair of features by the
// plain formula for its kind (vertex-face, edge-edge, ...). The result is checked against the
// features' neighbours, which suffices by convexity. So a search's errors never reach the result.
//
//   1. closest_warm() first tries the features of the previous call. If these features are still
//      the closest, the search ends.
//   2. Otherwise GJK (Gilbert, Johnson and Keerthi 1988) runs. It computes a simplex's closest
//      points from signed areas and volumes (Montanari, Petrinic and Barbieri, "Improving the GJK
//      algorithm for faster and more reliable distance queries between two convex objects", ACM TOG
//      36 (2017)). Unlike that paper's algorithm, this one ignores how old a vertex is, so it
//      accepts any simplex.
//   3. If GJK's simplex is not certified (nearly parallel faces and edges at tiny gaps), all pairs
//      of features are searched that can hold closest points within GJK's bounds. The search is
//      exact, and usually takes only a handful of pairs, because the gap is known up to rounding.
//   4. If the pieces overlap, the result is the direction of least depth among all face normals and
//      products of edges (Gregorius, "The separating axis test between convex polyhedra", GDC
//      2013). This search takes 1 us for two cubes and 70 us for two icospheres of 42 vertices.
//
// Invariants
//   1. For separate pieces, gap_m is right to some 1e-15 of the coordinates in A's frame, however
//      small the gap. The coordinates' size is the sum of both outer radii and the distance
//      of the frames. point_b_m - point_a_m = gap_m * normal to the same accuracy. The normal is
//      right to 1e-15 if a face is involved. Without a face, the normal is right to 1e-15 / sine of
//      the edges' angle, or to 1e-15 * coordinates / gap.
//   2. For overlapping pieces (gap_m <= 0), -gap_m is the depth, the length of the shortest shift
//      along `normal` that separates the pieces. If the depth is small against the features,
//      `normal` is the contact normal. One of the two points is on its piece's feature; the other
//      is opposite it along the normal. Positive gaps below 8 * 2^-50 of the coordinates are
//      handled like overlaps, because the direction between two such points is noise. In this case
//      gap_m is a lower bound, right to that size.
//   3. closest_cold()'s result depends only on shapes and poses, bit for bit.
//   4. closest_warm()'s gap differs from closest_cold()'s by at most the rounding of invariant 1.
//      Features may differ if several pairs are equally close. For gap_m <= 0, the results are the
//      same.
//   5. Nothing is allocated. After at most k_gjk_iterations_max iterations, step 3 or 4 follows.
// Thread safety: pure functions; only one thread at a time may use a SeparationCache.
#pragma once

#include <cstdint>

#include "worker/physics/distance/placed_pose.h"
#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/shape/small_pieces.h"

namespace sleight::physics {

/// GJK on polytopes terminates; this limit only guards against endless rounding.
inline constexpr int k_gjk_iterations_max = 64;

enum class FeatureKind : std::uint8_t { vertex, edge, face };

struct Feature {
  FeatureKind kind = FeatureKind::vertex;
  std::uint16_t index = 0;
  friend constexpr bool operator==(Feature, Feature) = default;
};

/// The step that produced the result; for tests and measurements.
enum class Search : std::uint8_t { features, simplex, exhaustive, overlap };

struct Closest {
  double gap_m = 0;               ///< distance; <= 0 if the pieces overlap
  Vec3 normal = Vec3::Zero();     ///< unit, from A to B, world
  Vec3 point_a_m = Vec3::Zero();  ///< world
  Vec3 point_b_m = Vec3::Zero();
  Feature feature_a;  ///< the smallest feature with point_a_m
  Feature feature_b;
  Search search = Search::simplex;
  bool overlapping() const { return gap_m <= 0; }
};

/// Data about a pair that closest_warm() stores for its next call. The result is right for any
/// cache contents whose features exist in the pieces. A new cache has no features.
struct SeparationCache {
  Vec3 axis = Vec3::Zero();  ///< the last normal, in A's frame
  Feature a;
  Feature b;
  bool filled = false;
};

/// Computes from scratch. REQUIRES: rotations orthonormal up to rounding; poses finite; no empty
/// piece.
Closest closest_cold(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b);

/// Returns the same result, bit for bit. `hint`: features found by any means. Fast if the hinted
/// features are certainly the only closest ones; otherwise computes from scratch. `search` may
/// differ.
Closest closest_cold(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b, const SeparationCache& hint);

/// Starts from the cache and updates it. REQUIRES: as for closest_cold.
Closest closest_warm(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b, SeparationCache& cache);

/// Returns the closest points of a piece and a point in world coordinates. For a sphere about the
/// point, subtract its radius from the gap.
Closest closest_to_point(const ConvexView& a, const PlacedPose& pose_a, const Vec3& point_m);

/// Returns the closest points of a piece and the half-space dot(normal, p) <= offset_m in world
/// coordinates. The half-space is A in the result. The result has the plane's normal, and feature_b
/// is the piece's lowest vertex (on a tie, the first). REQUIRES: |normal| = 1.
Closest closest_to_plane(const Vec3& normal, double offset_m, const ConvexView& piece,
                         const PlacedPose& pose);

}  // namespace sleight::physics
