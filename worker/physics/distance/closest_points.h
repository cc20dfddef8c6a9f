// Computes the closest points of two convex pieces, and the pieces' distance or overlap.
//
// Idea. The gap of two separate convex bodies is the least distance between a point of A and a
// point of B. The gap is also the greatest separation of A and B along any direction. This equality
// certifies a result: two points, each on a named feature (vertex, edge, face), are the closest if
// their distance equals the bodies' separation along the line between them. The searches below only
// propose features. One function then computes gap, normal and points by the plain formula for the
// features' kinds (vertex-face, edge-edge, ...). The result is checked against the features'
// neighbours; by convexity, this is enough. So a search's errors never reach the result.
//
//   1. closest_warm() first tries the features of the previous call. If these features are still
//      the closest, the search ends.
//   2. Otherwise GJK (Gilbert, Johnson and Keerthi 1988) runs. GJK computes a simplex's closest
//      points from signed areas and volumes (Montanari, Petrinic and Barbieri, "Improving the GJK
//      algorithm for faster and more reliable distance queries between two convex objects", ACM TOG
//      36 (2017)). Unlike that paper's algorithm, GJK here ignores how old a vertex is, so it
//      accepts any simplex.
//   3. If GJK's simplex is not certified (nearly parallel faces and edges at tiny gaps), a search
//      examines each pair of features that can contain closest points within GJK's bounds. The
//      search is exact. The search usually examines only a handful of pairs, because the gap is
//      known up to rounding.
//   4. If the pieces overlap, the result is the direction of least depth among all face normals and
//      products of edges (Gregorius, "The separating axis test between convex polyhedra", GDC
//      2013). This search takes 1 us for two cubes and 70 us for two icospheres of 42 vertices.
//
// Invariants
//   1. For separate pieces, gap_m's error is about 1e-15 of the coordinates in A's frame, however
//      small the gap. Here "coordinates" is the sum of both outer radii and the distance
//      of the frames. point_b_m - point_a_m = gap_m * normal to the same accuracy. The normal's
//      error is 1e-15 if a face is involved. Without a face, the error is 1e-15 / sine of the
//      edges' angle, or 1e-15 * coordinates / gap.
//   2. For overlapping pieces (gap_m <= 0), -gap_m is the depth: the length of the shortest shift
//      along `normal` that separates the pieces. If the depth is small compared with the features,
//      `normal` is the contact normal. One of the two points is on its piece's feature. The other
//      point is opposite it along the normal. Positive gaps below 8 * 2^-50 of the coordinates are
//      handled like overlaps, because the direction between two such points is noise. In this case
//      gap_m is a lower bound with an error of that size.
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

/// GJK on polytopes terminates. This limit only prevents an endless loop that rounding causes.
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

/// Data about a pair that closest_warm() stores for its next call. If the features exist in the
/// pieces, the result is right whatever the cache contains.
struct SeparationCache {
  Vec3 axis = Vec3::Zero();  ///< the last normal, in A's frame
  Feature a;
  Feature b;
  bool filled = false;
};

/// Computes the closest points from scratch. REQUIRES: rotations orthonormal up to rounding; poses
/// finite; no empty piece.
Closest closest_cold(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b);

/// Returns the same result, bit for bit; only `search` may differ. `hint` contains features found
/// by any means. If these features are certainly the only closest ones, the call is fast. Otherwise
/// it computes from scratch.
Closest closest_cold(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b, const SeparationCache& hint);

/// Computes the closest points, starting from the cache. Updates the cache. REQUIRES: as for
/// closest_cold.
Closest closest_warm(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b, SeparationCache& cache);

/// Returns the closest points of a piece and a point in world coordinates. For a sphere about the
/// point, subtract its radius from the gap.
Closest closest_to_point(const ConvexView& a, const PlacedPose& pose_a, const Vec3& point_m);

/// Returns the closest points of the half-space dot(normal, p) <= offset_m and a piece, in world
/// coordinates. In the result, A is the half-space, and the normal is the plane's normal. feature_b
/// is the piece's lowest vertex, the first one if several are equally low. REQUIRES: |normal| = 1.
Closest closest_to_plane(const Vec3& normal, double offset_m, const ConvexView& piece,
                         const PlacedPose& pose);

}  // namespace sleight::physics
