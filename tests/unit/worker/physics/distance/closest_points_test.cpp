// Goal: closest_cold() finds the right gap, normal, points and features of separated convex pieces,
// up to rounding. Method: test random and degenerate placements of many kinds of pieces. Gaps are
// as small as 1e-9 of the size. In each result, each point must be in its piece, and the pieces
// must be the gap apart along the normal. The gap must equal a brute-force gap in long double. Also
// test placements with known features. The checks must reject a faulty distance function.
#include "worker/physics/distance/closest_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "common/math/elementary.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/distance/support.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

using math::norm;

// Error relative to the coordinates. The error is the header's bound of 2^-50 plus room for more
// rounding errors.
constexpr double k_accuracy = 1e-14;

// The normal between two points has an error of rounding / gap. The separation along this normal
// has the same error. A face's normal is exact up to rounding.
double certificate_tolerance(const Closest& result, double coordinates) {
  const bool face =
      result.feature_a.kind == FeatureKind::face || result.feature_b.kind == FeatureKind::face;
  const double rounding = k_accuracy * coordinates;
  return face ? rounding : rounding * (1 + 0.2 * coordinates / result.gap_m);
}

TEST(ClosestCold, proves_itself_for_pieces_of_all_kinds) {
  const std::uint64_t pairs = soaked(400);
  std::map<Search, int> searches;
  double worst = 0;
  for (const std::uint64_t i : property::cases(pairs)) {
    random::Stream stream = numbers(101, i);
    const double size = log_between(stream, 1e-3, 1e2);
    const auto piece_a = random_piece(stream, size);
    const auto piece_b = random_piece(stream, size * log_between(stream, 0.3, 3));
    const ConvexView a = piece_a->view(), b = piece_b->view();
    for (int k = 0; k < 250; ++k) {
      const Placement at = random_placement(stream, a, b, size);
      const Closest result = closest_cold(a, at.a, b, at.b);
      const double coordinates = coordinates_m(a, at.a, b, at.b) + 2 * size;
      const double defect = certificate_defect(a, at.a, b, at.b, result);
      ASSERT_GT(result.gap_m, 0) << i << ' ' << k;
      ASSERT_LE(defect, certificate_tolerance(result, coordinates))
          << i << ' ' << k << ' ' << piece_a->kind << '/' << piece_b->kind << " gap "
          << result.gap_m << " size " << size << " search " << static_cast<int>(result.search);
      worst = std::max(worst, defect / certificate_tolerance(result, coordinates));
      ++searches[result.search];
    }
  }
  if (!property::all_cases()) return;
  for (const auto& [search, count] : searches)
    std::printf("search %d: %d\n", static_cast<int>(search), count);
  std::printf("worst defect: %.3g of the tolerance\n", worst);
  // Fewer than one pair in 20 needs the exhaustive search.
  EXPECT_LT(searches[Search::exhaustive], pairs * 250 / 20);
  EXPECT_EQ(searches[Search::overlap], 0);
}

TEST(ClosestCold, equals_brute_force_in_long_double) {
  double worst = 0;
  for (const std::uint64_t i : property::cases(soaked(property::of_tier(60, 300)))) {
    random::Stream stream = numbers(102, i);
    const double size = log_between(stream, 1e-3, 1e2);
    const auto piece_a = random_piece(stream, size);
    const auto piece_b = random_piece(stream, size * log_between(stream, 0.3, 3));
    const ConvexView a = piece_a->view(), b = piece_b->view();
    const int poses = std::max(1, 20000 / (a.edge_count * b.edge_count + 20));
    for (int k = 0; k < poses; ++k) {
      const Placement at = random_placement(stream, a, b, size);
      const Closest result = closest_cold(a, at.a, b, at.b);
      const double coordinates = coordinates_m(a, at.a, b, at.b) + 2 * size;
      const auto reference = static_cast<double>(reference_gap(a, at.a, b, at.b));
      ASSERT_NEAR(result.gap_m, reference, k_accuracy * coordinates)
          << i << ' ' << k << ' ' << piece_a->kind << '/' << piece_b->kind << " size " << size;
      worst = std::max(worst, std::fabs(result.gap_m - reference) / coordinates);
    }
  }
  std::printf("worst error: %.3g of the coordinates\n", worst);
}

// Known features: a unit cube is above another cube. A corner, an edge or a face of the upper cube
// points down.
TEST(ClosestCold, names_the_features) {
  const ConvexPolyhedron solid = cube(1).value();
  const ConvexView c = solid.view();
  const PlacedPose origin;
  const auto turned = [](const Vec3& w) {
    return math::matrix_of(math::quaternion_of_rotation_vector(w));
  };
  const double quarter = 0.78539816339744831;
  // A corner straight above the top face: the upper cube's diagonal is vertical.
  const Vec3 x = math::normalized(Vec3(1, -1, 0)), z = math::normalized(Vec3(1, 1, 1));
  Mat3 on_corner;
  on_corner.row(0) = x;
  on_corner.row(1) = math::cross(z, x);
  on_corner.row(2) = z;
  const double half_diagonal = 0.5 * std::sqrt(3.0);
  const Closest corner = closest_cold(
      c, origin, c, {.rotation = on_corner, .position_m = {0.1, 0.2, 0.5 + half_diagonal + 1e-7}});
  EXPECT_EQ(corner.feature_a.kind, FeatureKind::face);
  EXPECT_EQ(corner.feature_b.kind, FeatureKind::vertex);
  EXPECT_NEAR(corner.gap_m, 1e-7, 1e-15);
  EXPECT_EQ(corner.normal, Vec3(0, 0, 1));
  EXPECT_LT(norm(corner.point_a_m - Vec3(0.1, 0.2, 0.5)), 1e-15);
  const double half_side = 0.5 * std::sqrt(2.0);
  const Closest crossed = closest_cold(
      c, {.rotation = turned({quarter, 0, 0}), .position_m = {0, 0, 0}}, c,
      {.rotation = turned({0, quarter, 0}), .position_m = {0.1, 0.2, 2 * half_side + 1e-7}});
  EXPECT_EQ(crossed.feature_a.kind, FeatureKind::edge);
  EXPECT_EQ(crossed.feature_b.kind, FeatureKind::edge);
  EXPECT_NEAR(crossed.gap_m, 1e-7, 2e-15);
  EXPECT_LT(norm(crossed.normal - Vec3(0, 0, 1)), 1e-15);
  EXPECT_LT(norm(crossed.point_b_m - Vec3(0.1, 0, half_side + 1e-7)), 1e-14);
  // Diagonal offsets: corner to corner, and corner to edge.
  const Closest corners = closest_cold(c, origin, c, {.position_m = {1.3, 1.4, 2.2}});
  EXPECT_EQ(corners.feature_a.kind, FeatureKind::vertex);
  EXPECT_EQ(corners.feature_b.kind, FeatureKind::vertex);
  EXPECT_NEAR(corners.gap_m, 1.3, 1e-15);
  // Face to face: many pairs of points have the same gap.
  const Closest faces = closest_cold(c, origin, c, {.position_m = {0.25, -0.5, 1 + 1e-9}});
  EXPECT_NEAR(faces.gap_m, 1e-9, 1e-15);
  EXPECT_EQ(faces.normal, Vec3(0, 0, 1));
}

TEST(ClosestToPoint, agrees_with_the_box_formula) {
  // A point's distance from a box, and its depth inside, have closed forms.
  const ConvexPolyhedron solid = box(Vec3(2, 4, 6)).value();
  random::Stream stream = numbers(106, 0);
  for (int i = 0; i < 20000; ++i) {
    const PlacedPose pose{.rotation = random_rotation(stream), .position_m = random_vector(stream)};
    const Vec3 local = 4 * random_vector(stream);
    const Closest result = closest_to_point(solid.view(), pose, to_world(pose, local));
    const Vec3 beyond = local.cwiseAbs() - Vec3(1, 2, 3);
    const double expected = beyond.maxCoeff() > 0 ? norm(beyond.cwiseMax(0)) : beyond.maxCoeff();
    ASSERT_NEAR(result.gap_m, expected, 2e-14) << i;
    ASSERT_EQ(result.overlapping(), expected <= 0);
    ASSERT_LT(norm(result.point_b_m - to_world(pose, local)), 2e-14);
  }
}

TEST(ClosestToPlane, is_the_lowest_vertex) {
  random::Stream stream = numbers(107, 0);
  for (int i = 0; i < 2000; ++i) {
    const auto piece = random_piece(stream, 1);
    const PlacedPose pose{.rotation = random_rotation(stream), .position_m = random_vector(stream)};
    const Vec3 normal = random_unit(stream);
    const Closest result = closest_to_plane(normal, 0.3, piece->view(), pose);
    double lowest = INFINITY;
    for (std::size_t v = 0; v < piece->view().vertex_count; ++v)
      lowest = std::min(lowest, math::dot(normal, to_world(pose, piece->view().vertices_m[v])));
    ASSERT_NEAR(result.gap_m, lowest - 0.3, 1e-14);
    ASSERT_NEAR(math::dot(normal, result.point_a_m), 0.3, 1e-14);
  }
}

// Both checks above must reject a distance function that considers only vertices.
TEST(Checks, catch_a_broken_distance) {
  int caught_by_certificate = 0;
  int caught_by_reference = 0;
  for (int i = 0; i < 100; ++i) {
    random::Stream stream = numbers(108, static_cast<std::uint64_t>(i));
    const auto piece_a = random_piece(stream, 1);
    const auto piece_b = random_piece(stream, 1);
    const ConvexView a = piece_a->view(), b = piece_b->view();
    const Placement at = random_placement(stream, a, b, 1);
    Closest broken;
    broken.gap_m = INFINITY;
    for (std::size_t v = 0; v < a.vertex_count; ++v) {
      for (std::size_t w = 0; w < b.vertex_count; ++w) {
        const Vec3 from = to_world(at.a, a.vertices_m[v]);
        const Vec3 to = to_world(at.b, b.vertices_m[w]);
        if (norm(to - from) >= broken.gap_m) continue;
        broken.gap_m = norm(to - from);
        broken.normal = math::normalized(to - from);
        broken.point_a_m = from;
        broken.point_b_m = to;
      }
    }
    const double coordinates = coordinates_m(a, at.a, b, at.b) + 2;
    caught_by_certificate +=
        certificate_defect(a, at.a, b, at.b, broken) > certificate_tolerance(broken, coordinates);
    caught_by_reference +=
        std::fabs(broken.gap_m - static_cast<double>(reference_gap(a, at.a, b, at.b))) >
        k_accuracy * coordinates;
  }
  EXPECT_GT(caught_by_certificate, 50);
  EXPECT_GT(caught_by_reference, 50);
}

}  // namespace
}  // namespace sleight::physics
