// Helpers that build the bounding boxes and region sides of static geometry.
//
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/shape/triangle_mesh.h"

namespace sleight::physics {

/// Returns a box around a point, rounded outwards and widened by the distance of a touch.
inline Box box_around(const Vec3& point_m) {
  Box box;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    // Converting p to float changes it by at most 2^-24 |p|; the margin added here is larger.
    const double reach_m = 2 * k_touch_m + std::fabs(point_m[i]) * 0x1p-22;
    box.low_m[axis] = static_cast<float>(point_m[i] - reach_m);
    box.high_m[axis] = static_cast<float>(point_m[i] + reach_m);
  }
  return box;
}

inline Box joined(const Box& a, const Box& b) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low_m[axis] = std::min(a.low_m[axis], b.low_m[axis]);
    box.high_m[axis] = std::max(a.high_m[axis], b.high_m[axis]);
  }
  return box;
}

/// Widens a box by a margin, rounding outwards.
inline Box wider(const Box& box, double margin_m) {
  if (margin_m == 0) return box;
  constexpr float k_outwards = 1 + 0x1p-20F;
  Box wide;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float margin =
        k_outwards * (static_cast<float>(margin_m) +
                      0x1p-20F * std::max(std::fabs(box.low_m[axis]), std::fabs(box.high_m[axis])));
    wide.low_m[axis] = box.low_m[axis] - margin;
    wide.high_m[axis] = box.high_m[axis] + margin;
  }
  return wide;
}

inline Box box_around(std::span<const Vec3> points_m) {
  Box box = box_around(points_m[0]);
  for (const Vec3& point_m : points_m.subspan(1))
    box = joined(box, box_around(point_m));
  return box;
}

inline RegionSide open_side(const Vec3& normal, double offset_m) {
  return {.space = {normal, offset_m}, .strict = true};
}

/// Makes a closed side; the margin extends the region over its border.
inline RegionSide closed_side(const Vec3& normal, double offset_m, double margin_m) {
  return {.space = {normal, offset_m - margin_m}, .strict = false};
}

inline bool is_closed(const TriangleMesh& mesh) {
  return std::ranges::none_of(mesh.edges(),
                              [](const MeshEdge& edge) { return edge.kind == EdgeKind::boundary; });
}

/// Returns the volume that a closed mesh encloses; negative if its normals point inwards.
inline double enclosed_m3(const TriangleMesh& mesh) {
  double six_volumes_m3 = 0;
  for (const TriangleCorners& corners : mesh.triangles()) {
    const Vec3& a = mesh.vertices_m()[corners[0]];
    six_volumes_m3 += math::dot(
        a, math::cross(mesh.vertices_m()[corners[1]] - a, mesh.vertices_m()[corners[2]] - a));
  }
  return six_volumes_m3 / 6;
}

/// Whether a closed mesh's normals point inwards. The mesh is then a cavity in an infinite solid.
inline bool is_hollow(const TriangleMesh& mesh) {
  return enclosed_m3(mesh) < 0;
}

/// Returns whether a closed mesh stays hollow or stays solid, however its vertices move. Each
/// coordinate moves by at most slack_m.
inline bool keeps_side(const TriangleMesh& mesh, double slack_m) {
  // When one vertex moves by d, the volume changes by at most d / 3 times the area of the triangles
  // at the vertex. An edge grows by at most the sum of the distances that its two ends move.
  const double way_m = std::sqrt(3) * slack_m;
  double volume = 0;
  double change = 0;
  double rounding = 0;
  for (const TriangleCorners& corners : mesh.triangles()) {
    const Vec3& a = mesh.vertices_m()[corners[0]];
    const Vec3 ab = mesh.vertices_m()[corners[1]] - a;
    const Vec3 ac = mesh.vertices_m()[corners[2]] - a;
    const Vec3 bc = ac - ab;
    const Vec3 across = math::cross(ab, ac);
    const double around_m = math::norm(ab) + math::norm(ac) + math::norm(bc);
    const double term = math::dot(a, across);
    volume += term;
    rounding += std::fabs(term);
    change += 3 * math::norm(across) + 4 * way_m * around_m + 12 * way_m * way_m;
  }
  return std::fabs(volume) > 1.001 * way_m * change + 1e-6 * rounding;
}

}  // namespace sleight::physics
