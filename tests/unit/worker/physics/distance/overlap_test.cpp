// Goal: closest_cold() finds the right depth of overlapping pieces. If rounding or a single time
// step can cause an overlap of this depth, the normal is usually the same as before the overlap.
// Method: from a known contact, push pieces into each other by 1e-9 to 1e-6 of their size. Also
// test deep overlaps. A shift by the depth along the normal must separate the pieces. No shorter
// shift in a sampled direction may separate the pieces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/distance/support.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

using math::norm;

TEST(Overlap, shallow_ones_keep_the_normal_of_the_contact) {
  int kept = 0;
  int all = 0;
  for (const std::uint64_t i : property::cases(soaked(6000))) {
    random::Stream stream = numbers(201, i);
    const double size = log_between(stream, 1e-3, 1e2);
    const auto piece_a = random_piece(stream, size);
    const auto piece_b = random_piece(stream, size);
    const ConvexView a = piece_a->view(), b = piece_b->view();
    Placement at = random_placement(stream, a, b, size);
    at.b = at_gap(a, at.a, b, at.b, size * 1e-3);
    const Closest before = closest_cold(a, at.a, b, at.b);
    const double depth = size * log_between(stream, 1e-9, 1e-6);
    at.b.position_m -= (before.gap_m + depth) * before.normal;
    const Closest inside = closest_cold(a, at.a, b, at.b);
    const double rounding = 1e-14 * (coordinates_m(a, at.a, b, at.b) + 2 * size);
    // A shift by `depth` along the old normal separates the pieces, so the least depth is at most
    // `depth`.
    ASSERT_GE(inside.gap_m, -depth - rounding) << i;
    ASSERT_NEAR(norm(inside.normal), 1, 1e-14);
    if (inside.overlapping()) {
      ASSERT_NEAR(inside.gap_m, separation_along(inside.normal, a, at.a, b, at.b), rounding) << i;
    }
    ASSERT_LE(norm(inside.point_b_m - inside.point_a_m - inside.gap_m * inside.normal), rounding);
    // A contact at a face or at crossed edges determines a normal, along which the pieces overlap.
    // A contact without a face or crossed edges determines no normal: two sharp corners can pass
    // each other.
    const bool own_normal =
        before.feature_a.kind == FeatureKind::face || before.feature_b.kind == FeatureKind::face ||
        (before.feature_a.kind == FeatureKind::edge && before.feature_b.kind == FeatureKind::edge);
    if (!own_normal) continue;
    ASSERT_LE(inside.gap_m, 8 * rounding) << i;
    ++all;
    kept += norm(inside.normal - before.normal) < 1e-6 ? 1 : 0;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(all, 1000);
  // The normal may differ for parallel features, and within a few depths of a feature's end.
  EXPECT_GT(kept, 0.97 * all);
}

TEST(Overlap, no_direction_needs_a_shorter_way_out) {
  for (const std::uint64_t i : property::cases(1500)) {
    random::Stream stream = numbers(202, i);
    const auto piece_a = random_piece(stream, 1);
    const auto piece_b = random_piece(stream, 1);
    const ConvexView a = piece_a->view(), b = piece_b->view();
    PlacedPose pose_a{.rotation = random_rotation(stream), .position_m = random_vector(stream)};
    PlacedPose pose_b{.rotation = random_rotation(stream), .position_m = pose_a.position_m};
    pose_b.position_m += 0.5 * random_vector(stream);
    Closest result = closest_cold(a, pose_a, b, pose_b);
    ASSERT_NEAR(
        result.gap_m > 0 ? 0 : result.gap_m - separation_along(result.normal, a, pose_a, b, pose_b),
        0, 1e-14)
        << i;
    if (!result.overlapping()) continue;
    for (int k = 0; k < 200; ++k) {
      // Sample directions on the whole sphere, and close to the found direction.
      Vec3 direction = random_unit(stream);
      if (k % 2 == 0)
        direction = math::normalized(result.normal + log_between(stream, 1e-6, 1) * direction);
      ASSERT_LE(separation_along(direction, a, pose_a, b, pose_b), result.gap_m + 1e-9) << i;
    }
    // The depth along the normal is just enough to separate the pieces.
    pose_b.position_m += (1e-9 - result.gap_m) * result.normal;
    result = closest_cold(a, pose_a, b, pose_b);
    ASSERT_NEAR(result.gap_m, 1e-9, 1e-13) << i;
  }
}

// Two cubes touch exactly, at all kinds of features. The gap is 0 up to rounding, and the normal
// separates the cubes.
TEST(Overlap, touching_pieces_have_a_usable_normal) {
  const ConvexPolyhedron solid = cube(1).value();
  for (const std::uint64_t i : property::cases(2000)) {
    random::Stream stream = numbers(204, i);
    const PlacedPose a{.rotation = quarter_turns(stream), .position_m = {0, 0, 0}};
    PlacedPose b{
        .rotation = stream.bits() % 2 == 0 ? quarter_turns(stream) : random_rotation(stream),
        .position_m = {3 * random_unit(stream)}};
    b = at_gap(solid.view(), a, solid.view(), b, 0);
    for (const double shift : {-1e-15, 0.0, 1e-16, 1e-15, 1e-14}) {
      PlacedPose near = b;
      near.position_m += shift * math::normalized(b.position_m);
      const Closest result = closest_cold(solid.view(), a, solid.view(), near);
      ASSERT_NEAR(result.gap_m, 0, 4e-14) << i;
      ASSERT_GE(separation_along(result.normal, solid.view(), a, solid.view(), near), -4e-14) << i;
    }
  }
}

TEST(Overlap, of_points_and_triangles) {
  // Pieces without volume: two equal points, and two crossing triangles.
  const PointPiece point(Vec3(1, 2, 3));
  const Closest same = closest_cold(point.view(), {}, point.view(), {});
  EXPECT_EQ(same.gap_m, 0);
  EXPECT_EQ(norm(same.normal), 1);
  const TrianglePiece flat(Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1, 0));
  const TrianglePiece upright(Vec3(0, 0, -0.25), Vec3(0.1, 0, 1), Vec3(-0.1, 0, 1));
  const Closest through = closest_cold(flat.view(), {}, upright.view(), {});
  EXPECT_NEAR(through.gap_m, -0.25, 1e-15);
  EXPECT_LT(norm(through.normal - Vec3(0, 0, 1)), 1e-15);
}

}  // namespace
}  // namespace sleight::physics
