// Computes the overlap of bodies with plain geometry: separating axes for polyhedra, and distances
// to polygons for spheres. Shares no code with the distance library.
//
// Thread safety: values and pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/shape/convex_polyhedron.h"

namespace sleight::physics::testing {

struct PlainSolid {
  struct Polygon {
    Vec3 normal;
    double offset_m;
    std::vector<Vec3> corners_m;  ///< anticlockwise from outside
  };
  std::vector<Vec3> corners_m;
  std::vector<Polygon> faces;
  std::vector<std::array<Vec3, 2>> edges_m;
};

inline PlainSolid solid_at(const ConvexPolyhedron& polyhedron, const Pose& pose) {
  const Mat3 turn = math::matrix_of(pose.orientation);
  const auto placed = [&](const Vec3& v) -> Vec3 {
    return math::product(turn, v) + pose.position_m;
  };
  PlainSolid solid;
  for (const Vec3& v : polyhedron.vertices_m())
    solid.corners_m.push_back(placed(v));
  for (const Edge& edge : polyhedron.edges())
    solid.edges_m.push_back({solid.corners_m[edge.vertex[0]], solid.corners_m[edge.vertex[1]]});
  for (const Face& face : polyhedron.faces()) {
    PlainSolid::Polygon polygon;
    for (const Side& side : polyhedron.sides_of(face))
      polygon.corners_m.push_back(solid.corners_m[side.vertex]);
    // Compute the normal from the corners, independently of the polyhedron's own normal.
    Vec3 area = Vec3::Zero();
    for (std::size_t i = 2; i < polygon.corners_m.size(); ++i)
      area += math::cross(polygon.corners_m[i - 1] - polygon.corners_m[0],
                          polygon.corners_m[i] - polygon.corners_m[0]);
    polygon.normal = math::normalized(area);
    polygon.offset_m = math::dot(polygon.normal, polygon.corners_m[0]);
    solid.faces.push_back(std::move(polygon));
  }
  return solid;
}

inline PlainSolid solid_of_triangle(const std::array<Vec3, 3>& corners_m) {
  PlainSolid solid;
  for (std::size_t k = 0; k < 3; ++k) {
    solid.corners_m.push_back(corners_m[k]);
    solid.edges_m.push_back({corners_m[k], corners_m[(k + 1) % 3]});
  }
  const Vec3 normal =
      math::normalized(math::cross(corners_m[1] - corners_m[0], corners_m[2] - corners_m[0]));
  const double offset_m = math::dot(normal, corners_m[0]);
  solid.faces.push_back({normal, offset_m, {corners_m[0], corners_m[1], corners_m[2]}});
  solid.faces.push_back({-normal, -offset_m, {corners_m[0], corners_m[2], corners_m[1]}});
  return solid;
}

/// Least dot(axis, q - p) over all points p of `a` and q of `b`. Stops early at a value below
/// `enough`.
inline double clearance_along(const Vec3& axis, const PlainSolid& a, const PlainSolid& b,
                              double enough) {
  double highest = -std::numeric_limits<double>::infinity();
  for (const Vec3& v : a.corners_m)
    highest = std::max(highest, math::dot(axis, v));
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vec3& v : b.corners_m) {
    lowest = std::min(lowest, math::dot(axis, v));
    if (lowest - highest < enough) break;
  }
  return lowest - highest;
}

/// Signed clearance of two solids. A negative value is minus the depth, the length of the shortest
/// shift that separates the solids. A positive value is at most the solids' distance. Tries every
/// axis of the separating axis theorem: face normals and cross products of edges.
inline double clearance(const PlainSolid& a, const PlainSolid& b) {
  double best = -std::numeric_limits<double>::infinity();
  const auto offer = [&](const Vec3& axis) {
    best = std::max(best, clearance_along(axis, a, b, best));
  };
  for (const auto& face : a.faces)
    offer(face.normal);
  for (const auto& face : b.faces)
    offer(-face.normal);
  for (const auto& p : a.edges_m) {
    for (const auto& q : b.edges_m) {
      if (best > 0) return best;
      const Vec3 along_p = p[1] - p[0];
      const Vec3 along_q = q[1] - q[0];
      Vec3 axis = math::cross(along_p, along_q);
      const double length = math::norm(axis);
      if (length < 1e-6 * math::norm(along_p) * math::norm(along_q)) continue;
      axis /= length;
      // Along the axis, the solids' clearance is at most these two edges' clearance.
      const double edges_m = math::dot(axis, q[0] - p[0]);
      if (edges_m > best) offer(axis);
      if (-edges_m > best) offer(-axis);
    }
  }
  return best;
}

inline double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double share = std::clamp(math::dot(p - a, along) / math::dot(along, along), 0.0, 1.0);
  return math::norm(p - (a + share * along));
}

/// Signed distance from a point to a solid, negative inside.
inline double distance(const Vec3& p, const PlainSolid& solid) {
  double inside = -std::numeric_limits<double>::infinity();
  double outside = std::numeric_limits<double>::infinity();
  for (const auto& face : solid.faces) {
    const double height = math::dot(face.normal, p) - face.offset_m;
    inside = std::max(inside, height);
    bool above = true;
    for (std::size_t i = 0; i < face.corners_m.size(); ++i) {
      const Vec3& a = face.corners_m[i];
      const Vec3& b = face.corners_m[(i + 1) % face.corners_m.size()];
      outside = std::min(outside, distance_to_segment(p, a, b));
      above = above && math::dot(math::cross(face.normal, b - a), p - a) >= 0;
    }
    if (above) outside = std::min(outside, std::fabs(height));
  }
  return inside <= 0 ? inside : outside;
}

}  // namespace sleight::physics::testing
