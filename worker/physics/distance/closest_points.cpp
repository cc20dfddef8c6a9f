#include "worker/physics/distance/closest_points.h"

#include <algorithm>
#include <array>

#include "worker/physics/distance/exhaustive.h"
#include "worker/physics/distance/feature_pairs.h"
#include "worker/physics/distance/gjk.h"
#include "worker/physics/distance/separation.h"

namespace sleight::physics {
namespace {

using math::dot;
using math::norm;

// If the gap is below this many roundings, the direction between the closest points is noise. Such
// pieces count as touching. Their normal is chosen as if they overlapped.
constexpr double k_touching_roundings = 8;

Closest in_world(const PlacedPose& pose_a, const LocalClosest& local, Search search) {
  return {.gap_m = local.gap_m,
          .normal = math::product(pose_a.rotation, local.normal),
          .point_a_m = to_world(pose_a, local.point_a_m),
          .point_b_m = to_world(pose_a, local.point_b_m),
          .feature_a = local.a,
          .feature_b = local.b,
          .search = search};
}

struct Corners {
  std::array<std::uint16_t, 3> vertex{};
  std::size_t count = 0;
  void add(std::uint16_t v) {
    for (std::size_t i = 0; i < count; ++i)
      if (vertex[i] == v) return;
    vertex[count++] = v;
  }
};

bool has_face(const ConvexView& piece, std::uint16_t vertex, std::uint16_t face) {
  for (std::size_t i = piece.ring_first[vertex]; i < piece.ring_first[vertex + std::size_t{1}]; ++i)
    if (piece.ring_faces[i] == face) return true;
  return false;
}

// Finds the smallest feature with these vertices. Returns false if there is no such feature (for a
// diagonal).
bool smallest_feature(const ConvexView& piece, const Corners& corners, Feature& feature) {
  const std::uint16_t first = corners.vertex[0];
  if (corners.count == 1) {
    feature = {FeatureKind::vertex, first};
    return true;
  }
  const std::size_t begin = piece.ring_first[first];
  const std::size_t end = piece.ring_first[first + std::size_t{1}];
  if (corners.count == 2) {
    for (std::size_t i = begin; i < end; ++i) {
      if (piece.ring_vertices[i] != corners.vertex[1]) continue;
      feature = {FeatureKind::edge, piece.ring_edges[i]};
      return true;
    }
  }
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint16_t face = piece.ring_faces[i];
    bool all = true;
    for (std::size_t k = 1; k < corners.count; ++k)
      all = all && has_face(piece, corners.vertex[k], face);
    if (!all) continue;
    feature = {FeatureKind::face, face};
    return true;
  }
  return false;
}

// Converts GJK's last simplex to features and their gap. Returns false if the features aren't
// certified.
bool finish(const PiecePair& pair, const Simplex& simplex, LocalClosest& result) {
  Corners corners_a;
  Corners corners_b;
  for (int i = 0; i < simplex.count; ++i) {
    corners_a.add(simplex.points[static_cast<std::size_t>(i)].a);
    corners_b.add(simplex.points[static_cast<std::size_t>(i)].b);
  }
  Feature a;
  Feature b;
  if (!smallest_feature(pair.a, corners_a, a) || !smallest_feature(pair.b, corners_b, b))
    return false;
  if (closest_of_features(pair, a, b, result)) return certified(pair, result);
  if (a.kind == FeatureKind::vertex || b.kind == FeatureKind::vertex) return false;
  if (a.kind == FeatureKind::edge && b.kind == FeatureKind::edge) return false;
  Vec3 point_a = Vec3::Zero();
  Vec3 point_b = Vec3::Zero();
  for (int i = 0; i < simplex.count; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    point_a += simplex.weights[slot] * pair.vertex_of_a(simplex.points[slot].a);
    point_b += simplex.weights[slot] * pair.vertex_of_b(simplex.points[slot].b);
  }
  return closest_of_parallel_features(pair, a, b, point_a, point_b, result);
}

// Used when the simplex isn't certified. The simplex's closest vector and points still bound the
// gap from both sides.
LocalClosest search_all(const PiecePair& pair, const Simplex& simplex, const Vec3& closest) {
  const double high_m = norm(closest);
  const Vec3 axis = closest / high_m;
  const Vec3 top = pair.vertex_of_a(furthest_vertex(pair.a, axis));
  const Vec3 bottom = pair.vertex_of_b(furthest_vertex(pair.b, -pair.in_b(axis)));
  // The upper bound uses actual points, because rounding may make `closest` too short.
  Vec3 apart = Vec3::Zero();
  for (int i = 0; i < simplex.count; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    apart += simplex.weights[slot] * simplex.points[slot].difference_m;
  }
  return closest_of_all(pair, axis, dot(axis, bottom - top), std::max(high_m, norm(apart)));
}

Closest overlap_or_touch(const PiecePair& pair, const PlacedPose& pose_a) {
  const LocalClosest least = least_overlap(pair);
  const double touching_m = k_touching_roundings * pair.rounding_m;
  if (least.gap_m <= touching_m) return in_world(pose_a, least, Search::overlap);
  // GJK reported overlap, but an axis separates the pieces. Search between the bounds that the axis
  // gives.
  const Vec3 apart = pair.vertex_of_b(0) - pair.vertex_of_a(0);
  const LocalClosest all = closest_of_all(pair, least.normal, least.gap_m, norm(apart));
  return in_world(pose_a, all, Search::exhaustive);
}

// Computes the result of closest_cold() or closest_warm() from GJK's outcome.
Closest concluded(const PiecePair& pair, const PlacedPose& pose_a, GjkOutcome outcome,
                  const Simplex& simplex, const Vec3& closest) {
  if (outcome == GjkOutcome::overlapping) return overlap_or_touch(pair, pose_a);
  const double touching_m = k_touching_roundings * pair.rounding_m;
  LocalClosest result;
  if (finish(pair, simplex, result)) {
    if (result.gap_m > touching_m) return in_world(pose_a, result, Search::simplex);
    return overlap_or_touch(pair, pose_a);
  }
  if (!(dot(closest, closest) > touching_m * touching_m)) return overlap_or_touch(pair, pose_a);
  result = search_all(pair, simplex, closest);
  if (result.gap_m > touching_m) return in_world(pose_a, result, Search::exhaustive);
  return overlap_or_touch(pair, pose_a);
}

Closest cold(const PiecePair& pair, const PlacedPose& pose_a) {
  Simplex simplex;
  Vec3 closest = to_world(pair.b_in_a, pair.b.centre_m) - pair.a.centre_m;
  if (!(dot(closest, closest) > 0)) closest = Vec3(1, 0, 0);
  const GjkOutcome outcome = descend(pair, false, simplex, closest);
  return concluded(pair, pose_a, outcome, simplex, closest);
}

void remember(const PlacedPose& pose_a, const Closest& result, SeparationCache& cache) {
  cache.filled = result.gap_m > 0;
  cache.a = result.feature_a;
  cache.b = result.feature_b;
  cache.axis = transposed_product(pose_a.rotation, result.normal);
}

std::uint16_t some_vertex(const ConvexView& piece, Feature feature) {
  if (feature.kind == FeatureKind::vertex) return feature.index;
  if (feature.kind == FeatureKind::edge) return piece.edges[feature.index].vertex[0];
  return piece.sides[piece.faces[feature.index].first_side].vertex;
}

}  // namespace

Closest closest_cold(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b) {
  return cold(PiecePair(a, pose_a, b, pose_b), pose_a);
}

Closest closest_cold(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b, const SeparationCache& hint) {
  const PiecePair pair(a, pose_a, b, pose_b);
  LocalClosest local;
  if (hint.filled && closest_of_features(pair, hint.a, hint.b, local) && only_one(pair, local))
    return in_world(pose_a, local, Search::features);
  return cold(pair, pose_a);
}

Closest closest_warm(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b, SeparationCache& cache) {
  const PiecePair pair(a, pose_a, b, pose_b);
  if (cache.filled) {
    // Use the last features if they are still the closest.
    LocalClosest local;
    if (closest_of_features(pair, cache.a, cache.b, local) &&
        local.gap_m > k_touching_roundings * pair.rounding_m && certified(pair, local)) {
      cache.axis = local.normal;
      return in_world(pose_a, local, Search::features);
    }
    // Otherwise descend from there.
    Simplex simplex;
    simplex.points[0].a = climbed_vertex(a, cache.axis, some_vertex(a, cache.a));
    simplex.points[0].b = climbed_vertex(b, -pair.in_b(cache.axis), some_vertex(b, cache.b));
    simplex.points[0].difference_m =
        pair.vertex_of_b(simplex.points[0].b) - pair.vertex_of_a(simplex.points[0].a);
    simplex.weights[0] = 1;
    simplex.count = 1;
    Vec3 closest = simplex.points[0].difference_m;
    if (dot(closest, closest) > 0 &&
        descend(pair, true, simplex, closest) == GjkOutcome::separated) {
      const Closest result = concluded(pair, pose_a, GjkOutcome::separated, simplex, closest);
      if (result.search != Search::overlap) {
        remember(pose_a, result, cache);
        return result;
      }
    }
  }
  const Closest result = cold(pair, pose_a);
  remember(pose_a, result, cache);
  return result;
}

Closest closest_to_point(const ConvexView& a, const PlacedPose& pose_a, const Vec3& point_m) {
  const PointPiece point{Vec3(Vec3::Zero())};
  return closest_cold(a, pose_a, point.view(),
                      {.rotation = Mat3::Identity(), .position_m = point_m});
}

Closest closest_to_plane(const Vec3& normal, double offset_m, const ConvexView& piece,
                         const PlacedPose& pose) {
  const std::uint16_t lowest = furthest_vertex(piece, -transposed_product(pose.rotation, normal));
  Closest result;
  result.point_b_m = to_world(pose, piece.vertices_m[lowest]);
  result.gap_m = dot(normal, result.point_b_m) - offset_m;
  result.normal = normal;
  result.point_a_m = result.point_b_m - result.gap_m * normal;
  result.feature_a = {FeatureKind::face, 0};
  result.feature_b = {FeatureKind::vertex, lowest};
  result.search = result.gap_m > 0 ? Search::features : Search::overlap;
  return result;
}

}  // namespace sleight::physics
