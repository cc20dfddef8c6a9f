// Finds the points that support a piece on a flat face: the corners of pieces, and the crossings of
// their edges.
//
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/distance/round_distance.h"

namespace sleight::physics {

/// Calls found(point, in world coordinates) for a polyhedron's corners. For a round piece, calls
/// `found` for points within about `near_m` of the furthest extent along `direction`.
template <class Found>
void for_each_corner(const MovingPiece& of, const Vec3& direction, double near_m,
                     const Found& found) {
  if (is_round(of)) {
    for_each_point_near(*of.view, of.pose, direction, near_m, found);
    return;
  }
  for (std::size_t i = 0; i < of.view->vertex_count; ++i)
    found(to_world(of.pose, of.view->vertices_m[i]));
}

/// Calls found(point, in world coordinates) for each crossing of two polyhedra's edges near a
/// plane. Considers only edges whose ends are within `near_m` of the plane. The contact area's
/// corners are these crossings and each polyhedron's corners over the other polyhedron. `normal` is
/// the plane's unit normal, and `offset_m` is its offset along the normal. Round pieces have no
/// edges.
template <class Found>
void for_each_crossing(const MovingPiece& a, const MovingPiece& b, const Vec3& normal,
                       double offset_m, double near_m, const Found& found) {
  struct Line {
    Vec3 start_m;
    Vec3 along_m;
    double length_m;
  };
  const auto for_each_edge = [&](const MovingPiece& of, const auto& visit) {
    for (std::size_t i = 0; i < of.view->edge_count; ++i) {
      const Edge& edge = of.view->edges[i];
      const Vec3 start_m = to_world(of.pose, of.view->vertices_m[edge.vertex[0]]);
      const Vec3 end_m = to_world(of.pose, of.view->vertices_m[edge.vertex[1]]);
      if (std::abs(math::dot(normal, start_m) - offset_m) > near_m ||
          std::abs(math::dot(normal, end_m) - offset_m) > near_m)
        continue;
      const Vec3 along_m = end_m - start_m;
      visit(Line{start_m, along_m, math::norm(along_m)});
    }
  };
  const auto is_inside = [near_m](double share, const Line& line) {
    return share * line.length_m > near_m && (1 - share) * line.length_m > near_m;
  };
  for_each_edge(a, [&](const Line& one) {
    for_each_edge(b, [&](const Line& other) {
      const Vec3 across = math::cross(normal, other.along_m);
      const double crosses = math::dot(one.along_m, across);
      // If two edges are parallel to within `near_m`, rounding decides where they cross. Skipping
      // such edges loses no point, because a crossing so near an edge's end coincides with a
      // corner.
      if (!(std::abs(crosses) > near_m * std::max(one.length_m, other.length_m))) return;
      const Vec3 between_m = other.start_m - one.start_m;
      const double share_of_one = math::dot(between_m, across) / crosses;
      const double share_of_other =
          math::dot(between_m, math::cross(normal, one.along_m)) / crosses;
      if (is_inside(share_of_one, one) && is_inside(share_of_other, other))
        found(Vec3(one.start_m + share_of_one * one.along_m));
    });
  });
}

}  // namespace sleight::physics
