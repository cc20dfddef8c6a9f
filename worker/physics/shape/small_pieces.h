// Triangles and points as convex pieces, without allocation.
//
// Idea. The distance algorithms read ConvexViews. A static mesh has many triangles, and a sphere's
// centre is a point. For both, a ConvexPolyhedron's vectors would cost too much. The types here
// store the same arrays inline. A triangle is a polyhedron without thickness: it has three edges
// and two faces, (normal, offset) and (-normal, -offset). Seen from face 0's side, a triangle's
// corners run anticlockwise. A point has one vertex and nothing else.
//
// A view borrows the piece, so the piece must stay in place.
#pragma once

#include <array>

#include "worker/physics/shape/convex_polyhedron.h"

namespace sleight::physics {

class TrianglePiece {
 public:
  TrianglePiece() = default;
  /// REQUIRES: a, b, c are finite and not collinear.
  TrianglePiece(const Vec3& a_m, const Vec3& b_m, const Vec3& c_m);
  ConvexView view() const;

 private:
  std::array<Vec3, 3> vertices_m_{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::array<std::array<double, 4>, 3> by_axis_m_{};
  std::array<Face, 2> faces_{};
  std::array<Side, 6> sides_{};
  double r_outer_m_ = 0;
  Vec3 centre_m_ = Vec3::Zero();
};

class PointPiece {
 public:
  explicit PointPiece(const Vec3& point_m);
  ConvexView view() const;

 private:
  Vec3 point_m_;
  std::array<std::array<double, 4>, 3> by_axis_m_{};
};

}  // namespace sleight::physics
