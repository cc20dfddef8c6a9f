// The closest points of two convex pieces, and how far they are apart or overlap.
//
// Idea. The gap of two convex bodies that do not touch has two faces: it is the least distance of a
// point of A from a point of B, and the greatest separation of the two along any direction. So an
// answer can be certified: if two points, each on a named feature (vertex, edge, face), are as far
// apart as both bodies are separated along the line between them, nothing is closer. Every search
// below only proposes features; from these, gap, normal and points are computed by the plain
// formula of that kind of pair (vertex-face, edge-edge, ...), in one place, and checked against the
// neighbours of the features, which by convexity suffices. Hence errors of searching never show.
//
//   1. Features of last time (warm only): often still right, then nothing else is done.
//   2. GJK (E. Gilbert, D. Johnson, S. Keerthi 1988) with closest points of a simplex by signed
//      areas and volumes (M. Montanari, N. Petrinic, E. Barbieri, "Improving the GJK algorithm for
//      faster and more reliable distance queries between two convex objects", ACM TOG 36 (2017));
//      unlike there no vertex's seniority is used, so that any simplex may be handed over.
//   3. Where GJK's simplex is not certified (nearly parallel faces and edges at tiny gaps): all
//      pairs of features that can hold closest points, given the bounds that GJK reached. Exact,
//      and usually a handful of pairs, since the gap is known to within rounding by then.
//   4. Overlap: the direction of least depth among all face normals and products of edges
//      (D. Gregorius, "The separating axis test between convex polyhedra", GDC 2013). That takes
//      1 us for two cubes and 70 us for two icospheres of 42 vertices.
//
// Invariants
//   1. Separated pieces: gap_m is right to some 1e-15 of the coordinates as seen from A's frame
//      (both outer radii plus the distance of the frames), however small the gap; point_b_m -
//      point_a_m = gap_m * normal to the same accuracy. The normal is right to 1e-15 where a face
//      is involved, to 1e-15/sin of the edges' angle or 1e-15 * coordinates/gap for other pairs.
//   2. Overlapping pieces (gap_m <= 0): -gap_m is the depth, the length of the shortest shift along
//      `normal` that parts them; for depths that are small against the features this is the normal
//      of the contact. A point of one lies on its feature; the other's is its partner along the
//      normal. Results are of this kind also for positive gaps below 8 * 2^-50 of the coordinates,
//      where the direction between two points is noise: a lower bound of the gap, right to that.
//   3. closest_cold depends on shapes and poses alone, bit for bit.
//   4. closest_warm's gap differs from closest_cold's by at most rounding as in 1; features may be
//      others where several pairs are equally close. For gap_m <= 0 it is closest_cold's result.
//   5. No allocation. At most k_gjk_iterations_max iterations, then 3 or 4.
// Thread safety: pure functions; a SeparationCache belongs to one thread at a time.
#pragma once

#include <cstdint>

#include "worker/physics/distance/placed_pose.h"
#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/shape/small_pieces.h"

namespace sleight::physics {

/// GJK on polytopes ends by itself; this guards against rounding going in circles.
inline constexpr int k_gjk_iterations_max = 64;

enum class FeatureKind : std::uint8_t { vertex, edge, face };

struct Feature {
  FeatureKind kind = FeatureKind::vertex;
  std::uint16_t index = 0;
  friend constexpr bool operator==(Feature, Feature) = default;
};

/// Which step gave the result; for tests and measurements.
enum class Search : std::uint8_t { features, simplex, exhaustive, overlap };

struct Closest {
  double gap_m = 0;               ///< distance; <= 0 where the pieces overlap
  Vec3 normal = Vec3::Zero();     ///< unit, from A to B, world
  Vec3 point_a_m = Vec3::Zero();  ///< world
  Vec3 point_b_m = Vec3::Zero();
  Feature feature_a;  ///< the smallest feature that holds point_a_m
  Feature feature_b;
  Search search = Search::simplex;
  bool overlapping() const { return gap_m <= 0; }
};

/// What closest_warm remembers of a pair. Any contents give the right result as long as the pieces
/// have the features named; a fresh one names none.
struct SeparationCache {
  Vec3 axis = Vec3::Zero();  ///< the last normal, in A's frame
  Feature a;
  Feature b;
  bool filled = false;
};

/// From scratch. REQUIRES: rotations orthonormal to rounding; finite poses; non-empty pieces.
Closest closest_cold(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b);

/// The same result, bit for bit, given what was found by other means, however that was: quick if
/// those features are certain to be the only ones, else from scratch. `search` may differ.
Closest closest_cold(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b, const SeparationCache& hint);

/// From what was found last time, which it updates. REQUIRES: as closest_cold.
Closest closest_warm(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b, SeparationCache& cache);

/// Of a piece and a point of the world; a sphere about the point has this gap less its radius.
Closest closest_to_point(const ConvexView& a, const PlacedPose& pose_a, const Vec3& point_m);

/// Of a piece and the half-space dot(normal, p) <= offset_m of the world, which plays A's part: the
/// result's normal is the plane's, feature_b the piece's lowest vertex (the first, on a tie).
/// REQUIRES: |normal| = 1.
Closest closest_to_plane(const Vec3& normal, double offset_m, const ConvexView& piece,
                         const PlacedPose& pose);

}  // namespace sleight::physics
