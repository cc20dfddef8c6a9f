// Points of a box over a surface. Edges and faces of the box are split into parts between such
// points.
//
// Internal to surface_search.cpp. Thread safety: one thread per surface, because it caches lookups.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "worker/physics/collision/first_collision.h"
#include "worker/physics/collision/surface_search.h"

namespace sleight::physics::surface_points {

/// A point of the box with its gap to the surface.
struct Above {
  Vec3 own_m = Vec3::Zero();  ///< in the box's frame
  Vec3 place_m = Vec3::Zero();
  double gap_m = 0;      ///< vertical
  double allowed_m = 0;  ///< how far the point may move (NearPoints)
  double rate_mps = 0;   ///< vertical rate of the gap
  double pull_mps2 = 0;  ///< second derivative of the gap, if the box turns evenly
  double slope_x = 0;
  double slope_y = 0;
  std::uint32_t order = 0;  ///< in the lattice; equal for points visited in lattice order

  double spare_m() const { return gap_m - allowed_m; }
  Vec3 normal() const { return math::normalized(Vec3(-slope_x, -slope_y, 1)); }
  bool collides() const {
    return touches(gap_m) && approaches(rate_along_normal_mps(rate_mps, normal()));
  }
};

class Points {
 public:
  using Allowed = std::array<double, 8>;  ///< by corner
  Points(SplineSurface& surface, const MovingPiece& box, const Allowed& allowed_m = {})
      : surface_(surface), box_(box), allowed_m_(allowed_m) {}

  Above corner(std::size_t i) {
    Above point = above(box_.view->vertices_m[i]);
    point.allowed_m = allowed_m_[i];
    return point;
  }
  Vec3 place_m(const Vec3& own_m) const { return to_world(box_.pose, own_m); }
  Above of(const EdgeLattice& edge, std::int32_t i) {
    const Vec3& origin_m = box_.view->vertices_m[edge.end[0]];
    const double u = static_cast<double>(i) / edge.steps;
    Above point = above(origin_m + u * (box_.view->vertices_m[edge.end[1]] - origin_m));
    point.allowed_m = (1 - u) * allowed_m_[edge.end[0]] + u * allowed_m_[edge.end[1]];
    return point;
  }
  Above of(const FaceLattice& face, std::int32_t i, std::int32_t j) {
    const Vec3& origin_m = box_.view->vertices_m[face.corner[0]];
    const double u = static_cast<double>(i) / face.along;
    const double v = static_cast<double>(j) / face.across;
    Above point = above(origin_m + u * (box_.view->vertices_m[face.corner[1]] - origin_m) +
                        v * (box_.view->vertices_m[face.corner[3]] - origin_m));
    const auto allowed_m = [&](std::size_t k) { return allowed_m_[face.corner[k]]; };
    point.allowed_m = (1 - v) * ((1 - u) * allowed_m(0) + u * allowed_m(1)) +
                      v * ((1 - u) * allowed_m(3) + u * allowed_m(2));
    return point;
  }
  Above above(const Vec3& own_m) {
    Above point;
    point.own_m = own_m;
    const Vec3 arm_m = math::product(box_.pose.rotation, own_m);
    point.place_m = arm_m + box_.pose.position_m;
    const SurfacePlace below = surface_.at(point.place_m.x(), point.place_m.y());
    const Vec3 turning_mps = math::cross(box_.angular_velocity_radps, arm_m);
    const Vec3 v = box_.velocity_mps + turning_mps;
    const Vec3 a = box_.acceleration_mps2 + math::cross(box_.angular_velocity_radps, turning_mps);
    const double bend_mps2 =
        (below.bend_xx_per_m * (v.x() * v.x()) + 2 * below.bend_xy_per_m * (v.x() * v.y())) +
        below.bend_yy_per_m * (v.y() * v.y());
    const GapAndRate above = height_above(below, point.place_m, v);
    point.gap_m = above.gap_m;
    point.rate_mps = above.rate_mps;
    point.pull_mps2 = ((a.z() - below.slope_x * a.x()) - below.slope_y * a.y()) - bend_mps2;
    point.slope_x = below.slope_x;
    point.slope_y = below.slope_y;
    return point;
  }

 private:
  SplineSurface& surface_;
  const MovingPiece& box_;
  Allowed allowed_m_;
};

/// The part of an edge between two lattice points.
struct Stretch {
  const EdgeLattice* edge = nullptr;
  std::array<std::int32_t, 2> along{};
  std::array<Above, 2> ends{};

  std::int32_t steps() const { return along[1] - along[0]; }
  std::span<const Above> outermost() const { return ends; }
  /// For each end, the gap minus the distance that the point may move.
  std::array<double, 2> spare_m() const { return {ends[0].spare_m(), ends[1].spare_m()}; }
  double radius2_m2() const {
    const Vec3 half_m = 0.5 * (ends[1].place_m - ends[0].place_m);
    return math::dot(half_m, half_m);
  }
  /// Interpolates linearly between values[0] and values[1] at the ends. Returns the least value at
  /// a lattice point between the ends.
  double least_inside(const std::array<double, 2>& values) const {
    const double step = 1.0 / steps();
    const double change = values[1] - values[0];
    return std::min(values[0] + step * change, values[1] - step * change);
  }
};

/// A rectangular part of a face between four lattice points.
struct Cell {
  const FaceLattice* face = nullptr;
  std::array<std::int32_t, 2> along{};
  std::array<std::int32_t, 2> across{};
  std::array<Above, 4> corners{};  ///< (0, 0), (1, 0), (1, 1), (0, 1)

  std::int32_t steps() const { return std::max(along[1] - along[0], across[1] - across[0]); }
  std::span<const Above> outermost() const { return corners; }
  std::array<double, 4> spare_m() const {
    return {corners[0].spare_m(), corners[1].spare_m(), corners[2].spare_m(), corners[3].spare_m()};
  }
  double radius2_m2() const {
    const Vec3 one_m = 0.5 * (corners[2].place_m - corners[0].place_m);
    const Vec3 other_m = 0.5 * (corners[3].place_m - corners[1].place_m);
    return std::max(math::dot(one_m, one_m), math::dot(other_m, other_m));
  }
  /// Returns whether the side from corner `side` to the next corner is on an edge of the box.
  bool is_outer(std::size_t side) const {
    const std::array<bool, 4> outer{across[0] == 0, along[1] == face->along,
                                    across[1] == face->across, along[0] == 0};
    return outer[side];
  }
  /// Interpolates bilinearly between values[k] at the corners. Returns the least value at a lattice
  /// point of the cell, except at points on the box's edges.
  double least_inside(const std::array<double, 4>& values) const {
    const double step_u = 1.0 / (along[1] - along[0]);
    const double step_v = 1.0 / (across[1] - across[0]);
    const std::array<double, 2> u{is_outer(3) ? step_u : 0, is_outer(1) ? 1 - step_u : 1};
    const std::array<double, 2> v{is_outer(0) ? step_v : 0, is_outer(2) ? 1 - step_v : 1};
    if (u[0] > u[1] || v[0] > v[1]) return k_forever_s;
    double least = k_forever_s;
    for (const double a : u) {
      for (const double b : v) {
        const double low = values[0] + a * (values[1] - values[0]);
        const double high = values[3] + a * (values[2] - values[3]);
        least = std::min(least, low + b * (high - low));
      }
    }
    return least;
  }
};

using Corners = std::array<Above, 8>;

inline Cell cell_of(const FaceLattice& face, const Corners& corners) {
  Cell cell{.face = &face, .along = {0, face.along}, .across = {0, face.across}};
  for (std::size_t k = 0; k < 4; ++k)
    cell.corners[k] = corners[face.corner[k]];
  return cell;
}

/// Splits a part at lattice points between its ends or corners, if there are any. Calls note(point)
/// for each new point, then visit(part) for each smaller part.
template <class Note, class Visit>
void split(Points& points, const Stretch& stretch, const Note& note, const Visit& visit) {
  const auto [i0, i2] = stretch.along;
  if (i2 - i0 <= 1) return;
  const std::int32_t i1 = i0 + (i2 - i0) / 2;
  const Above middle = points.of(*stretch.edge, i1);
  note(middle);
  visit(Stretch{stretch.edge, {i0, i1}, {stretch.ends[0], middle}});
  visit(Stretch{stretch.edge, {i1, i2}, {middle, stretch.ends[1]}});
}

template <class Note, class Visit>
void split(Points& points, const Cell& cell, const Note& note, const Visit& visit) {
  const FaceLattice& face = *cell.face;
  const std::array<Above, 4>& c = cell.corners;
  const auto [i0, i2] = cell.along;
  const auto [j0, j2] = cell.across;
  const std::int32_t i1 = i0 + (i2 - i0) / 2;
  const std::int32_t j1 = j0 + (j2 - j0) / 2;
  const auto point = [&](std::int32_t i, std::int32_t j) {
    const Above one = points.of(face, i, j);
    // Border points belong to edges.
    if (i > 0 && i < face.along && j > 0 && j < face.across) note(one);
    return one;
  };
  if (j1 == j0) {
    if (i1 == i0) return;
    const Above low = point(i1, j0);
    const Above high = point(i1, j2);
    visit(Cell{&face, {i0, i1}, {j0, j2}, {c[0], low, high, c[3]}});
    visit(Cell{&face, {i1, i2}, {j0, j2}, {low, c[1], c[2], high}});
    return;
  }
  const Above left = point(i0, j1);
  const Above right = point(i2, j1);
  if (i1 == i0) {
    visit(Cell{&face, {i0, i2}, {j0, j1}, {c[0], c[1], right, left}});
    visit(Cell{&face, {i0, i2}, {j1, j2}, {left, right, c[2], c[3]}});
    return;
  }
  const Above low = point(i1, j0);
  const Above high = point(i1, j2);
  const Above middle = point(i1, j1);
  visit(Cell{&face, {i0, i1}, {j0, j1}, {c[0], low, middle, left}});
  visit(Cell{&face, {i1, i2}, {j0, j1}, {low, c[1], right, middle}});
  visit(Cell{&face, {i1, i2}, {j1, j2}, {middle, right, c[2], high}});
  visit(Cell{&face, {i0, i1}, {j1, j2}, {left, middle, high, c[3]}});
}

/// Calls note(point) for each point whose gap is at most limit() plus the point's allowed move, and
/// for some other points. Let S be the surface's height. S + bump |x|^2 / 2 is convex. So at a
/// weighted mean of points, S is at most the mean of S plus bump / 2 times the points' variance.
template <class Part, class Limit, class Note>
void visit_low(Points& points, const Part& part, double bump_per_m, const Limit& limit,
               const Note& note) {
  if (part.steps() <= 1) return;
  if (part.least_inside(part.spare_m()) - 0.5 * bump_per_m * part.radius2_m2() > limit()) return;
  split(points, part, note,
        [&](const Part& smaller) { visit_low(points, smaller, bump_per_m, limit, note); });
}

template <class Limit, class Note>
void visit_all_low(Points& points, const BoxLattice& lattice, const Corners& corners,
                   double bump_per_m, const Limit& limit, const Note& note) {
  for (const Above& corner : corners)
    note(corner);
  for (const EdgeLattice& edge : lattice.edges) {
    const Stretch all{&edge, {0, edge.steps}, {corners[edge.end[0]], corners[edge.end[1]]}};
    visit_low(points, all, bump_per_m, limit, note);
  }
  for (const FaceLattice& face : lattice.faces)
    visit_low(points, cell_of(face, corners), bump_per_m, limit, note);
}

inline Corners corners_of(Points& points) {
  Corners corners;
  for (std::size_t i = 0; i < corners.size(); ++i)
    corners[i] = points.corner(i);
  return corners;
}

}  // namespace sleight::physics::surface_points
