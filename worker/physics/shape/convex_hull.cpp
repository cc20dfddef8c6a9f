// The convex hull: incremental, with exact signs on an integer grid. Coplanar triangles are merged.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "worker/physics/shape/convex_polyhedron.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

__extension__ using Wide = __int128;

// Grid coordinates are 0 to 2^52, so differences have 53 bits and a sign.
constexpr double k_grid = 0x1p52;
constexpr int k_split = 56;

using Grid = std::array<std::int64_t, 3>;

struct Triangle {
  std::array<std::uint16_t, 3> v{};
};

// Returns the exact sign of det(b - a, c - a, p - a). If the sign is positive, p is above the
// triangle: on the side from which the corners run anticlockwise. The 2x2 minors have at most 108
// bits. Each minor is split into a high part and 56 low bits, so that every sum below fits into 127
// bits.
int side_of(const Grid& a, const Grid& b, const Grid& c, const Grid& p) {
  std::array<std::int64_t, 3> u{}, v{}, w{};
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] = b[i] - a[i];
    v[i] = c[i] - a[i];
    w[i] = p[i] - a[i];
  }
  Wide high = 0;
  Wide low = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const Wide minor = static_cast<Wide>(u[j]) * v[k] - static_cast<Wide>(u[k]) * v[j];
    const Wide minor_high = minor >> k_split;
    const Wide minor_low = minor - minor_high * (static_cast<Wide>(1) << k_split);
    high += minor_high * w[i];
    low += minor_low * w[i];
  }
  const Wide carry = low >> k_split;
  const Wide rest = low - carry * (static_cast<Wide>(1) << k_split);
  const Wide total = high + carry;
  if (total != 0) return total > 0 ? 1 : -1;
  return rest > 0 ? 1 : 0;
}

struct Hull {
  std::vector<Vec3> points_m;  ///< without duplicates
  std::vector<Grid> grid;
  double extent_m = 0;
  double tolerance_m = 0;
  std::vector<Triangle> triangles;
};

// Rounds points to the grid. Omits each point that is within the tolerance of an earlier point.
std::optional<ShapeError> take_points(std::span<const Vec3> points_m, Hull& hull) {
  using Kind = ShapeError::Kind;
  if (points_m.size() < 4)
    return ShapeError{.kind = Kind::too_few_points, .index = points_m.size()};
  if (points_m.size() > k_hull_points_max)
    return ShapeError{.kind = Kind::too_many_points, .index = points_m.size()};
  Vec3 low = points_m[0];
  Vec3 high = points_m[0];
  double largest = 0;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double x = points_m[i][axis];
      // Squares and cubes of lengths must not overflow later.
      if (!(std::fabs(x) < 1e60)) return ShapeError{.kind = Kind::not_finite, .index = i};
      low[axis] = std::min(low[axis], x);
      high[axis] = std::max(high[axis], x);
      largest = std::max(largest, std::fabs(x));
    }
  }
  for (int axis = 0; axis < 3; ++axis)
    hull.extent_m = std::max(hull.extent_m, high[axis] - low[axis]);
  // If points are far from the origin, the spacing of doubles increases the tolerance.
  hull.tolerance_m = k_hull_coplanar * hull.extent_m + 8 * 0x1p-52 * largest;
  if (!(hull.extent_m > 1e-60) || hull.tolerance_m > 1e-3 * k_hull_flat * hull.extent_m)
    return ShapeError{.kind = Kind::flat};
  for (const Vec3& p : points_m) {
    const bool known = std::any_of(hull.points_m.begin(), hull.points_m.end(), [&](const Vec3& q) {
      return std::fabs(p.x() - q.x()) <= hull.tolerance_m &&
             std::fabs(p.y() - q.y()) <= hull.tolerance_m &&
             std::fabs(p.z() - q.z()) <= hull.tolerance_m;
    });
    if (known) continue;
    hull.points_m.push_back(p);
    Grid& cell = hull.grid.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      const double scaled = (p[axis] - low[axis]) / hull.extent_m * k_grid;
      cell[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(std::floor(scaled + 0.5));
    }
  }
  if (hull.points_m.size() < 4) return ShapeError{.kind = Kind::flat};
  return std::nullopt;
}

template <class Measure>
std::size_t furthest(const std::vector<Vec3>& points, const Measure& measure) {
  std::size_t best = 0;
  double best_value = -1;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double value = measure(points[i]);
    if (value > best_value) {
      best_value = value;
      best = i;
    }
  }
  return best;
}

// Finds a first tetrahedron. The tetrahedron is as thick as the points allow, up to a small factor.
std::optional<ShapeError> take_tetrahedron(Hull& hull, std::array<std::uint16_t, 4>& corner) {
  const auto& p = hull.points_m;
  const std::size_t i0 = furthest(p, [&](const Vec3& q) { return norm(q - p[0]); });
  const std::size_t i1 = furthest(p, [&](const Vec3& q) { return norm(q - p[i0]); });
  const Vec3 along = math::normalized(p[i1] - p[i0]);
  const std::size_t i2 = furthest(p, [&](const Vec3& q) { return norm(cross(along, q - p[i0])); });
  const Vec3 across = cross(along, p[i2] - p[i0]);
  const double width = norm(across);
  if (!(width > k_hull_flat * hull.extent_m))
    return ShapeError{.kind = ShapeError::Kind::flat, .measured = width / hull.extent_m};
  const Vec3 normal = across / width;
  const std::size_t i3 =
      furthest(p, [&](const Vec3& q) { return std::fabs(dot(normal, q - p[i0])); });
  const double thickness = std::fabs(dot(normal, p[i3] - p[i0]));
  if (!(thickness > k_hull_flat * hull.extent_m))
    return ShapeError{.kind = ShapeError::Kind::flat, .measured = thickness / hull.extent_m};
  corner = {static_cast<std::uint16_t>(i0), static_cast<std::uint16_t>(i1),
            static_cast<std::uint16_t>(i2), static_cast<std::uint16_t>(i3)};
  const auto& g = hull.grid;
  if (side_of(g[i0], g[i1], g[i2], g[i3]) > 0) std::swap(corner[1], corner[2]);
  const auto [a, b, c, d] = corner;
  hull.triangles = {{{a, b, c}}, {{a, d, b}}, {{b, d, c}}, {{c, d, a}}};
  return std::nullopt;
}

// Adds the points one by one. A triangle sees a point that is strictly above it. The triangles that
// see the new point form a region. Triangles from the region's rim to the point replace this
// region. A triangle doesn't see a point in its own plane, so coplanar triangles see the point
// together or not at all. The region is therefore a disc. No side of the rim is collinear with the
// point, because a triangle at this side sees the point.
void add_points(Hull& hull, const std::array<std::uint16_t, 4>& corner) {
  std::vector<Triangle> kept;
  std::vector<std::pair<std::uint16_t, std::uint16_t>> rim;
  for (std::size_t i = 0; i < hull.points_m.size(); ++i) {
    const auto p = static_cast<std::uint16_t>(i);
    if (std::find(corner.begin(), corner.end(), p) != corner.end()) continue;
    kept.clear();
    rim.clear();
    for (const Triangle& t : hull.triangles) {
      if (side_of(hull.grid[t.v[0]], hull.grid[t.v[1]], hull.grid[t.v[2]], hull.grid[p]) <= 0) {
        kept.push_back(t);
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k)
        rim.emplace_back(t.v[k], t.v[(k + 1) % 3]);
    }
    if (rim.empty()) continue;
    std::sort(rim.begin(), rim.end());
    for (const auto& [from, to] : rim) {
      if (!std::binary_search(rim.begin(), rim.end(), std::pair(to, from)))
        kept.push_back({{from, to, p}});
    }
    hull.triangles.swap(kept);
  }
}

struct Neighbours {
  std::vector<std::array<std::uint32_t, 3>> across;  ///< neighbour of triangle t across its side k
};

Neighbours neighbours_of(const std::vector<Triangle>& triangles) {
  struct Entry {
    std::uint16_t from, to;
    std::uint32_t triangle;
  };
  std::vector<Entry> entries;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k)
      entries.push_back(
          {triangles[t].v[k], triangles[t].v[(k + 1) % 3], static_cast<std::uint32_t>(t)});
  }
  const auto less = [](const Entry& a, const Entry& b) {
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  };
  std::sort(entries.begin(), entries.end(), less);
  Neighbours result;
  result.across.resize(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Entry wanted{triangles[t].v[(k + 1) % 3], triangles[t].v[k], 0};
      result.across[t][k] =
          std::lower_bound(entries.begin(), entries.end(), wanted, less)->triangle;
    }
  }
  return result;
}

// Returns each triangle's face number. A face starts with the largest triangle that has no face
// yet. The face grows over neighbours whose corners are in this triangle's plane.
std::vector<std::uint32_t> merge(const Hull& hull, const Neighbours& neighbours,
                                 std::uint32_t& count) {
  constexpr std::uint32_t k_none = UINT32_MAX;
  const auto& triangles = hull.triangles;
  std::vector<Vec3> normal(triangles.size());
  std::vector<double> area(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3& a = hull.points_m[triangles[t].v[0]];
    normal[t] = cross(hull.points_m[triangles[t].v[1]] - a, hull.points_m[triangles[t].v[2]] - a);
    area[t] = norm(normal[t]);
  }
  std::vector<std::uint32_t> order(triangles.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return area[a] > area[b]; });
  std::vector<std::uint32_t> face(triangles.size(), k_none);
  std::vector<std::uint32_t> open;
  count = 0;
  for (const std::uint32_t seed : order) {
    if (face[seed] != k_none) continue;
    face[seed] = count;
    const Vec3 anchor = hull.points_m[triangles[seed].v[0]];
    // A sliver has no reliable plane, so it doesn't grow and stays a face of its own. If this is
    // wrong, the checks below fail.
    const bool grows = area[seed] > hull.tolerance_m * hull.tolerance_m;
    const Vec3 unit = grows ? Vec3(normal[seed] / area[seed]) : Vec3(Vec3::Zero());
    if (grows) open.push_back(seed);
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      for (const std::uint32_t next : neighbours.across[t]) {
        if (face[next] != k_none) continue;
        const auto& v = triangles[next].v;
        const bool flat = std::all_of(v.begin(), v.end(), [&](std::uint16_t corner) {
          return std::fabs(dot(unit, hull.points_m[corner] - anchor)) <= hull.tolerance_m;
        });
        if (!flat) continue;
        face[next] = count;
        open.push_back(next);
      }
    }
    ++count;
  }
  return face;
}

// Returns each face's loop of vertices. Uses only vertices that at least three faces share. Empty
// if the loops aren't closed.
std::vector<std::vector<std::uint16_t>> loops_of(const Hull& hull, const Neighbours& neighbours,
                                                 const std::vector<std::uint32_t>& face,
                                                 std::uint32_t count, std::vector<bool>& corner) {
  constexpr std::uint16_t k_none = UINT16_MAX;
  const std::size_t points = hull.points_m.size();
  std::vector<std::vector<std::uint32_t>> faces_at(points);
  std::vector<std::vector<std::pair<std::uint16_t, std::uint16_t>>> rim(count);
  for (std::size_t t = 0; t < hull.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint16_t from = hull.triangles[t].v[k];
      auto& at = faces_at[from];
      if (std::find(at.begin(), at.end(), face[t]) == at.end()) at.push_back(face[t]);
      if (face[neighbours.across[t][k]] != face[t])
        rim[face[t]].emplace_back(from, hull.triangles[t].v[(k + 1) % 3]);
    }
  }
  corner.assign(points, false);
  for (std::size_t p = 0; p < points; ++p)
    corner[p] = faces_at[p].size() >= 3;
  std::vector<std::vector<std::uint16_t>> loops;
  std::vector<std::uint16_t> next(points, k_none);
  for (auto& sides : rim) {
    std::sort(sides.begin(), sides.end());
    for (const auto& [from, to] : sides) {
      if (next[from] != k_none) return {};
      next[from] = to;
    }
    auto& loop = loops.emplace_back();
    if (sides.empty()) return {};
    std::uint16_t at = sides.front().first;
    for (std::size_t step = 0; step < sides.size(); ++step) {
      if (at == k_none) return {};
      if (corner[at]) loop.push_back(at);
      at = next[at];
    }
    if (at != sides.front().first || loop.size() < 3) return {};
    for (const auto& side : sides)
      next[side.first] = k_none;
  }
  // Sort by vertices, so that face numbers do not depend on areas.
  for (auto& loop : loops)
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
  std::sort(loops.begin(), loops.end());
  return loops;
}

// Returns whether every side has its opposite and Euler's formula holds.
bool closed(const std::vector<std::vector<std::uint16_t>>& loops, std::size_t vertices) {
  std::vector<std::pair<std::uint16_t, std::uint16_t>> sides;
  for (const auto& loop : loops) {
    for (std::size_t i = 0; i < loop.size(); ++i)
      sides.emplace_back(loop[i], loop[(i + 1) % loop.size()]);
  }
  std::sort(sides.begin(), sides.end());
  if (std::adjacent_find(sides.begin(), sides.end()) != sides.end()) return false;
  for (const auto& [from, to] : sides) {
    if (!std::binary_search(sides.begin(), sides.end(), std::pair(to, from))) return false;
  }
  return vertices + loops.size() == sides.size() / 2 + 2;
}

// Returns whether every face is wider than the tolerance, so that it has a normal.
bool wide(const std::vector<std::vector<std::uint16_t>>& loops, const Hull& hull) {
  return std::all_of(loops.begin(), loops.end(), [&](const std::vector<std::uint16_t>& loop) {
    const Vec3& origin = hull.points_m[loop[0]];
    Vec3 area = Vec3::Zero();
    double longest = 0;
    for (std::size_t i = 1; i < loop.size(); ++i) {
      const Vec3 arm = hull.points_m[loop[i]] - origin;
      longest = std::max(longest, norm(arm));
      if (i > 1) area += cross(hull.points_m[loop[i - 1]] - origin, arm);
    }
    return norm(area) > hull.tolerance_m * longest;
  });
}

// Returns whether every point is below every face, and each face's corners are inside all its
// sides. The second condition may fail at sides as short as the tolerance, because their directions
// are arbitrary.
bool sound(const ConvexPolyhedron& polyhedron, const Hull& hull) {
  const double slack_m = 8 * hull.tolerance_m;
  for (const Face& face : polyhedron.faces()) {
    for (const Vec3& p : hull.points_m) {
      if (!(dot(face.normal, p) <= face.offset_m + slack_m)) return false;
    }
    const auto sides = polyhedron.sides_of(face);
    for (const Side& side : sides) {
      for (const Side& corner : sides) {
        const Vec3& p = polyhedron.vertices_m()[corner.vertex];
        if (!(dot(side.inward, p) >= side.offset_m - slack_m)) return false;
        if (!(dot(face.normal, p) >= face.offset_m - slack_m)) return false;
      }
    }
  }
  return true;
}

}  // namespace

base::Result<ConvexPolyhedron, ShapeError> convex_hull(std::span<const Vec3> points_m) {
  Hull hull;
  if (const auto error = take_points(points_m, hull)) return *error;
  std::array<std::uint16_t, 4> tetrahedron{};
  if (const auto error = take_tetrahedron(hull, tetrahedron)) return *error;
  add_points(hull, tetrahedron);
  const Neighbours neighbours = neighbours_of(hull.triangles);
  std::uint32_t face_count = 0;
  const std::vector<std::uint32_t> face = merge(hull, neighbours, face_count);
  std::vector<bool> corner;
  auto loops = loops_of(hull, neighbours, face, face_count, corner);
  // Number the vertices in the order of the points.
  std::vector<Vec3> vertices_m;
  std::vector<std::uint16_t> number(hull.points_m.size());
  for (std::size_t p = 0; p < hull.points_m.size(); ++p) {
    if (!corner[p]) continue;
    number[p] = static_cast<std::uint16_t>(vertices_m.size());
    vertices_m.push_back(hull.points_m[p]);
  }
  if (loops.empty() || !closed(loops, vertices_m.size()) || !wide(loops, hull))
    return ShapeError{.kind = ShapeError::Kind::degenerate};
  for (auto& loop : loops) {
    for (std::uint16_t& v : loop)
      v = number[v];
  }
  ConvexPolyhedron result = polyhedron_of_loops(vertices_m, loops);
  if (!sound(result, hull)) return ShapeError{.kind = ShapeError::Kind::degenerate};
  return result;
}

}  // namespace sleight::physics
