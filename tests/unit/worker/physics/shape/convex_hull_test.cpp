// Goal: convex_hull() returns the convex hull of its points, with whole polygons as faces. Method:
// build hulls of known solids and of random points. Check the volume and Euler's formula. Check
// that all points are inside all faces, and that each vertex is necessary. Also test inputs with
// many coplanar, collinear or nearly equal points. Cause every typed error.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "common/math/rotation.h"
#include "common/random/stream.h"
#include "tests/support/property.h"
#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics::convex_hull_test {

using math::cross;
using math::dot;
using math::norm;
using Kind = ShapeError::Kind;

double between(random::Stream& stream, double low, double high) {
  return low + (high - low) * stream.uniform();
}

Vec3 random_vector(random::Stream& stream) {
  const double x = between(stream, -1, 1);
  const double y = between(stream, -1, 1);
  return {x, y, between(stream, -1, 1)};
}

random::Stream numbers(std::uint64_t test, std::uint64_t index) {
  return random::Stream({.seed = test, .purpose = random::Purpose::prior}, index);
}

Mat3 random_rotation(random::Stream& stream) {
  return math::matrix_of(math::quaternion_of_rotation_vector(3 * random_vector(stream)));
}

double volume(const ConvexPolyhedron& p) {
  // By the divergence theorem, the volume is a third of the sum of offset times area.
  double sum = 0;
  for (const Face& face : p.faces()) {
    const auto sides = p.sides_of(face);
    for (std::size_t i = 1; i + 1 < sides.size(); ++i) {
      const Vec3& a = p.vertices_m()[sides[0].vertex];
      const Vec3 ab = p.vertices_m()[sides[i].vertex] - a;
      const Vec3 ac = p.vertices_m()[sides[i + 1].vertex] - a;
      sum += face.offset_m * 0.5 * norm(cross(ab, ac)) / 3;
    }
  }
  return sum;
}

// Expects that the arrays have all properties that the header promises.
void expect_sound(const ConvexPolyhedron& p, std::span<const Vec3> points) {
  const double size = p.r_outer_m();
  ASSERT_EQ(p.vertices_m().size() + p.faces().size(), p.edges().size() + 2);
  for (const Face& face : p.faces()) {
    ASSERT_NEAR(norm(face.normal), 1, 1e-15);
    for (const Vec3& point : points)
      ASSERT_LE(dot(face.normal, point), face.offset_m + 1e-11 * size);
    const auto sides = p.sides_of(face);
    ASSERT_GE(sides.size(), 3U);
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const Vec3& from = p.vertices_m()[sides[i].vertex];
      const Vec3& to = p.vertices_m()[sides[(i + 1) % sides.size()].vertex];
      ASSERT_NEAR(dot(face.normal, from), face.offset_m, 1e-11 * size);
      ASSERT_NEAR(dot(sides[i].inward, face.normal), 0, 1e-15);
      // Anticlockwise from outside: inward is normal x direction.
      ASSERT_GT(dot(cross(face.normal, to - from), sides[i].inward), 0);
      for (const Side& other : sides)
        ASSERT_GE(dot(sides[i].inward, p.vertices_m()[other.vertex]),
                  sides[i].offset_m - 1e-11 * size);
    }
  }
  for (std::size_t e = 0; e < p.edges().size(); ++e) {
    const Edge& edge = p.edges()[e];
    ASSERT_NE(edge.face[0], edge.face[1]);
    for (const std::size_t k : {0U, 1U}) {
      ASSERT_EQ(p.sides()[edge.side[k]].edge, e);
      ASSERT_EQ(p.sides()[edge.side[k]].vertex, edge.vertex[k]);
      const auto near = p.neighbours_of(edge.vertex[k]);
      ASSERT_EQ(std::count(near.begin(), near.end(), edge.vertex[1 - k]), 1);
    }
  }
  double r_inner = std::numeric_limits<double>::infinity();
  for (const Face& face : p.faces())
    r_inner = std::min(r_inner, face.offset_m);
  ASSERT_EQ(p.r_inner_m(), r_inner);
}

TEST(ConvexHull, of_known_solids_has_their_faces) {
  struct Known {
    ConvexPolyhedron solid;
    std::size_t vertices, edges, faces;
    double volume;
  };
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  const double edge = 1 / std::sqrt(golden * golden + 1) * 2;
  const std::vector<Known> solids{
      {cube(2).value(), 8, 12, 6, 8},
      {box(Vec3(1, 2, 3)).value(), 8, 12, 6, 6},
      {tetrahedron(std::sqrt(3.0)).value(), 4, 6, 4, 8.0 / 3},
      {icosphere(1, 0).value(), 12, 30, 20, 5.0 / 12 * (3 + std::sqrt(5.0)) * edge * edge * edge},
      {icosphere(1, 1).value(), 42, 120, 80, 3.659},
      {icosphere(1, 2).value(), 162, 480, 320, 4.047},
      {regular_prism(6, 1, 2).value(), 12, 18, 8, 3 * std::sqrt(3.0)},
      {regular_prism(100, 1, 1).value(), 200, 300, 102, 3.1395},
  };
  for (const Known& known : solids) {
    expect_sound(known.solid, known.solid.vertices_m());
    EXPECT_EQ(known.solid.vertices_m().size(), known.vertices);
    EXPECT_EQ(known.solid.edges().size(), known.edges);
    EXPECT_EQ(known.solid.faces().size(), known.faces);
    EXPECT_NEAR(volume(known.solid), known.volume, known.volume * 2e-3);
  }
  EXPECT_NEAR(volume(solids[3].solid), solids[3].volume, 1e-14);
  EXPECT_NEAR(volume(solids[6].solid), solids[6].volume, 1e-14);
  EXPECT_NEAR(solids[0].solid.r_outer_m(), std::sqrt(3.0), 1e-15);
  EXPECT_EQ(solids[0].solid.r_inner_m(), 1);
  for (const Face& face : solids[0].solid.faces()) {
    EXPECT_EQ(face.side_count, 4);
    EXPECT_EQ(norm(face.normal), 1);
  }
}

TEST(ConvexHull, of_random_points_holds_them_and_needs_its_vertices) {
  for (const std::uint64_t i : property::cases(150)) {
    random::Stream stream = numbers(1, i);
    const auto count = 4 + stream.bits() % (i % 10 == 0 ? 500 : 60);
    const bool on_sphere = i % 3 == 0;
    std::vector<Vec3> points;
    while (points.size() < count) {
      const Vec3 p = random_vector(stream);
      if (!on_sphere) points.push_back(p);
      if (on_sphere && norm(p) > 0.1) points.push_back(math::normalized(p));
    }
    const auto hull = convex_hull(points);
    ASSERT_TRUE(hull.ok()) << i;
    const ConvexPolyhedron& p = hull.value();
    expect_sound(p, points);
    if (on_sphere) {
      ASSERT_EQ(p.vertices_m().size(), count);
    }
    // The hull's vertices are input points in input order. Removing a vertex makes the hull
    // smaller.
    auto at = points.begin();
    for (const Vec3& v : p.vertices_m()) {
      at = std::find(at, points.end(), v);
      ASSERT_NE(at, points.end());
    }
    if (count > 40) continue;
    for (std::size_t leave = 0; leave < p.vertices_m().size() && p.vertices_m().size() > 4;
         ++leave) {
      std::vector<Vec3> rest;
      for (std::size_t v = 0; v < p.vertices_m().size(); ++v)
        if (v != leave) rest.push_back(p.vertices_m()[v]);
      const auto smaller = convex_hull(rest);
      if (smaller) {
        ASSERT_LT(volume(smaller.value()), volume(p) - 1e-13) << i;
      }
    }
  }
}

// Grids of points on a box: many coplanar, collinear, interior and double points. A rotation and a
// shift make the points coplanar only up to rounding.
TEST(ConvexHull, merges_coplanar_faces_and_drops_what_is_no_corner) {
  for (const std::uint64_t i : property::cases(200)) {
    random::Stream stream = numbers(3, i);
    const Mat3 turn = i % 4 == 0 ? Mat3(Mat3::Identity()) : random_rotation(stream);
    const double scale = std::ldexp(1.0, static_cast<int>(stream.bits() % 20) - 10);
    const Vec3 shift = i % 2 == 0 ? Vec3(Vec3::Zero()) : Vec3(10 * scale * random_vector(stream));
    std::vector<Vec3> points;
    for (int x = 0; x <= 4; ++x) {
      for (int y = 0; y <= 3; ++y) {
        for (int z = 0; z <= 2; ++z) {
          const Vec3 p = math::product(turn, scale * Vec3(x, y, 1.5 * z));
          points.emplace_back(p + shift);
        }
      }
    }
    for (int k = 0; k < 10; ++k)
      points.push_back(points[stream.bits() % points.size()]);
    for (std::size_t k = points.size() - 1; k > 0; --k)
      std::swap(points[k], points[stream.bits() % (k + 1)]);
    const auto hull = convex_hull(points);
    ASSERT_TRUE(hull.ok()) << i << ' ' << describe(hull.error());
    expect_sound(hull.value(), points);
    ASSERT_EQ(hull.value().vertices_m().size(), 8U) << i;
    ASSERT_EQ(hull.value().faces().size(), 6U) << i;
    ASSERT_NEAR(volume(hull.value()) / (36 * scale * scale * scale), 1, 1e-12);
  }
}

// If features are about as small as the tolerance, the result must be a sound hull or the typed
// error.
TEST(ConvexHull, is_sound_or_refuses_when_features_are_tiny) {
  int refused = 0;
  const ConvexPolyhedron solid = cube(2).value();
  for (const std::uint64_t i : property::cases(3000)) {
    random::Stream stream = numbers(4, i);
    const double by = std::ldexp(1.0, -static_cast<int>(stream.bits() % 52));
    // Three points around each corner. Odd cases also have points along the edges.
    std::vector<Vec3> points;
    for (const Vec3& v : solid.vertices_m()) {
      for (int k = 0; k < 3; ++k)
        points.emplace_back(v + by * random_vector(stream));
    }
    for (const Edge& edge : solid.edges()) {
      const Vec3 from = solid.vertices_m()[edge.vertex[0]];
      const Vec3 to = solid.vertices_m()[edge.vertex[1]];
      for (int k = 1; k < 4 && i % 2 == 1; ++k)
        points.emplace_back(from + 0.3 * k * (to - from) +
                            (i % 4 == 1 ? by : 0) * random_vector(stream));
    }
    const auto hull = convex_hull(points);
    if (!hull) {
      ASSERT_EQ(hull.error().kind, Kind::degenerate);
      ++refused;
      continue;
    }
    ASSERT_NO_FATAL_FAILURE(expect_sound(hull.value(), points)) << i;
    ASSERT_NEAR(volume(hull.value()), 8, 40 * by + 1e-10) << i;
  }
  if (!property::all_cases()) return;
  EXPECT_LT(refused, 300);
  EXPECT_GT(refused, 0);
}

TEST(ConvexHull, refuses_with_a_reason) {
  const auto kind_of = [](std::vector<Vec3> points) {
    const auto hull = convex_hull(points);
    EXPECT_FALSE(hull.ok());
    EXPECT_FALSE(describe(hull.error()).empty());
    return hull.error();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  const Vec3 o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  EXPECT_EQ(kind_of({o, x, y}).kind, Kind::too_few_points);
  EXPECT_EQ(kind_of({}).kind, Kind::too_few_points);
  EXPECT_EQ(kind_of({o, x, Vec3(0, nan, 0), z}), (ShapeError{Kind::not_finite, 2, 0}));
  EXPECT_EQ(kind_of({o, x, y, Vec3(-infinite, 0, 0)}), (ShapeError{Kind::not_finite, 3, 0}));
  EXPECT_EQ(kind_of({o, o, o, o}).kind, Kind::flat);
  EXPECT_EQ(kind_of({o, x, 2 * x, 3 * x}).kind, Kind::flat);
  EXPECT_EQ(kind_of({o, x, y, x + y}).kind, Kind::flat);
  EXPECT_EQ(kind_of({o, x, y, x + y + 1e-8 * z}).kind, Kind::flat);
  EXPECT_EQ(kind_of({o, x, y, o, x, y}).kind, Kind::flat);
  const Vec3 far = 1e14 * x;
  EXPECT_EQ(kind_of({o + far, x + far, y + far, z + far}).kind, Kind::flat);
  EXPECT_EQ(kind_of(std::vector<Vec3>(k_hull_points_max + 1, o)).kind, Kind::too_many_points);
  EXPECT_TRUE(convex_hull(std::array<Vec3, 4>{o, x, y, 1e-5 * z}).ok());
}

TEST(Shapes, refuse_sizes_that_are_not_positive) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(box(Vec3(1, 0, 1)).error().index, 1U);
  EXPECT_EQ(cube(-1).error().kind, Kind::dimension_not_positive);
  EXPECT_EQ(tetrahedron(nan).error().kind, Kind::dimension_not_positive);
  EXPECT_EQ(icosphere(1, -1).error().index, 1U);
  EXPECT_EQ(icosphere(1, 4).error().kind, Kind::too_many_points);
  EXPECT_EQ(regular_prism(2, 1, 1).error().index, 0U);
  EXPECT_EQ(regular_prism(1000, 1, 1).error().kind, Kind::too_many_points);
  EXPECT_EQ(regular_prism(3, 1, 0).error().index, 2U);
  EXPECT_EQ(box(Vec3(1, 1, 1e-7)).error().kind, Kind::flat);
}

TEST(Moved, keeps_the_numbers_and_turns_the_planes) {
  random::Stream stream = numbers(5, 0);
  for (int i = 0; i < 50; ++i) {
    const ConvexPolyhedron before = icosphere(1, 1).value();
    const Mat3 turn = random_rotation(stream);
    const Vec3 shift = random_vector(stream);
    const ConvexPolyhedron after = moved(before, turn, shift);
    ASSERT_EQ(before.faces().size(), after.faces().size());
    for (std::size_t f = 0; f < before.faces().size(); ++f) {
      const Vec3 turned = math::product(turn, before.faces()[f].normal);
      ASSERT_LT(norm(turned - after.faces()[f].normal), 1e-14);
    }
    expect_sound(after, after.vertices_m());
  }
}

}  // namespace sleight::physics::convex_hull_test
