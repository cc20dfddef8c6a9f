#include "worker/physics/shape/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "common/math/angle.h"
#include "common/math/elementary.h"

namespace sleight::physics {
namespace {

using Corners = std::array<std::size_t, 3>;

struct Globe {
  std::vector<Vec3> points;  ///< on the unit sphere
  std::vector<Corners> triangles;
};

Globe icosahedron() {
  // The vertices are the cyclic permutations of (0, 1, golden ratio), with all signs, scaled to the
  // sphere.
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  const double scale = 1 / std::sqrt(1 + golden * golden);
  Globe globe;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double one : {-scale, scale}) {
      for (const double long_side : {-golden * scale, golden * scale}) {
        Vec3 p = Vec3::Zero();
        p[(axis + 1) % 3] = one;
        p[(axis + 2) % 3] = long_side;
        globe.points.push_back(p);
      }
    }
  }
  // Before scaling, neighbours are 2 apart. All other pairs are at least twice the golden ratio
  // apart.
  const auto near = [&](std::size_t a, std::size_t b) {
    return math::norm(globe.points[a] - globe.points[b]) < 2.5 * scale;
  };
  for (std::size_t a = 0; a < 12; ++a) {
    for (std::size_t b = a + 1; b < 12; ++b) {
      for (std::size_t c = b + 1; c < 12; ++c) {
        if (near(a, b) && near(b, c) && near(a, c)) globe.triangles.push_back({a, b, c});
      }
    }
  }
  return globe;
}

Globe subdivided(const Globe& coarse) {
  Globe fine{.points = coarse.points, .triangles = {}};
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> middles;
  const auto middle = [&](std::size_t a, std::size_t b) {
    const auto [at, fresh] = middles.try_emplace(std::minmax(a, b), fine.points.size());
    if (fresh) fine.points.push_back(math::normalized(fine.points[a] + fine.points[b]));
    return at->second;
  };
  for (const auto& [a, b, c] : coarse.triangles) {
    const std::size_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const Corners& t :
         {Corners{a, ab, ca}, Corners{b, bc, ab}, Corners{c, ca, bc}, Corners{ab, bc, ca}})
      fine.triangles.push_back(t);
  }
  return fine;
}

}  // namespace

double Compound::r_outer_m() const {
  double r_m = 0;
  for (const ConvexPolyhedron& part : parts)
    r_m = std::max(r_m, part.r_outer_m());
  for (const RoundPiece& part : round_parts)
    r_m = std::max(r_m, part.r_outer_m());
  return r_m;
}

ConvexView Compound::view(std::size_t part) const {
  return part < parts.size() ? parts[part].view() : round_parts[part - parts.size()].view();
}

std::optional<RoundPiece> hull_of(const Compound& compound) {
  if (!compound.parts.empty() || compound.round_parts.size() < 2) return std::nullopt;
  const RoundPiece& first = compound.round_parts.front();
  RoundDescription all{
      .origin_m = first.origin_m(), .axis = first.axis(), .rings = {}, .balls = {}};
  for (const RoundPiece& part : compound.round_parts) {
    const bool on_axis = part.of_revolution() && part.axis() == first.axis() &&
                         length_across(first.axis(), part.origin_m() - first.origin_m()) == 0;
    if (!on_axis) return std::nullopt;
    const double up_m = math::dot(first.axis(), part.origin_m() - first.origin_m());
    for (const RoundFeature& feature : part.features()) {
      all.rings.push_back({.height_m = up_m + feature.height_m,
                           .circle_m = feature.circle_m,
                           .radius_m = feature.radius_m});
    }
  }
  auto hull = RoundPiece::make(all);
  if (!hull) return std::nullopt;
  return std::move(hull).value();
}

std::optional<Vec3> axis_of_revolution(const Compound& compound) {
  if (!compound.parts.empty() || compound.round_parts.empty()) return std::nullopt;
  // Makers compute a body's frame with rounding errors, so permit small differences.
  constexpr double k_off = 1e-12;
  const Vec3 z = Vec3::UnitZ();
  for (const RoundPiece& part : compound.round_parts) {
    if (!part.of_revolution() || length_across(z, part.axis()) > k_off ||
        length_across(z, part.origin_m()) > k_off * compound.r_outer_m())
      return std::nullopt;
  }
  return z;
}

ShapeResult box(const Vec3& sides_m) {
  std::vector<Vec3> corners;
  for (int axis = 0; axis < 3; ++axis) {
    if (!is_positive(sides_m[axis]))
      return not_positive(static_cast<std::size_t>(axis), sides_m[axis]);
  }
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      for (const double z : {-0.5, 0.5})
        corners.emplace_back(x * sides_m.x(), y * sides_m.y(), z * sides_m.z());
    }
  }
  return convex_hull(corners);
}

ShapeResult cube(double side_m) {
  return box({side_m, side_m, side_m});
}

ShapeResult tetrahedron(double circumradius_m) {
  if (!is_positive(circumradius_m)) return not_positive(0, circumradius_m);
  const double c = circumradius_m / std::sqrt(3.0);
  return convex_hull(
      std::array<Vec3, 4>{Vec3(c, c, c), Vec3(c, -c, -c), Vec3(-c, c, -c), Vec3(-c, -c, c)});
}

ShapeResult icosphere(double radius_m, int subdivisions) {
  if (!is_positive(radius_m)) return not_positive(0, radius_m);
  if (subdivisions < 0) return not_positive(1, subdivisions);
  if (subdivisions > 3) return ShapeError{.kind = ShapeError::Kind::too_many_points, .index = 2562};
  Globe globe = icosahedron();
  for (int i = 0; i < subdivisions; ++i)
    globe = subdivided(globe);
  for (Vec3& p : globe.points)
    p = radius_m * p;
  return convex_hull(globe.points);
}

ShapeResult regular_prism(int corners, double radius_m, double height_m) {
  if (corners < 3) return not_positive(0, corners);
  if (!is_positive(radius_m)) return not_positive(1, radius_m);
  if (!is_positive(height_m)) return not_positive(2, height_m);
  if (2 * static_cast<std::size_t>(corners) > k_hull_points_max)
    return ShapeError{.kind = ShapeError::Kind::too_many_points,
                      .index = 2 * static_cast<std::size_t>(corners)};
  std::vector<Vec3> points;
  for (const double z : {-0.5 * height_m, 0.5 * height_m}) {
    for (int i = 0; i < corners; ++i) {
      const math::SinCos turn = math::sincos(math::k_two_pi * i / corners);
      points.emplace_back(radius_m * turn.cos, radius_m * turn.sin, z);
    }
  }
  return convex_hull(points);
}

}  // namespace sleight::physics
