// The corners of pieces: what carries them on what is flat.
//
// Thread safety: pure functions.
#pragma once

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/distance/round_distance.h"

namespace sleight::physics {

/// Calls found(point, in the world) for the corners of a polyhedron, or for the points of a round
/// piece that reach about as far as it does along a direction.
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

}  // namespace sleight::physics
