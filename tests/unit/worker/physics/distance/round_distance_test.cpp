#include "worker/physics/distance/round_distance.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/math/rotation.h"
#include "common/random/angular_distributions.h"
#include "common/random/stream.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/distance/round_oracle.h"
#include "worker/physics/shape/round_solids.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

class Dice {
 public:
  explicit Dice(std::uint64_t n)
      : stream_({.seed = 20'261'128, .purpose = random::Purpose::prior}, n) {}
  double uniform(double low, double high) { return low + (high - low) * stream_.uniform(); }
  double spread(double low, double high) { return low * std::pow(high / low, stream_.uniform()); }
  Vec3 direction() { return random::UniformDirection3{}.draw(stream_); }
  PlacedPose pose() {
    PlacedPose pose;
    pose.rotation = math::matrix_of(random::UniformRotation{}.draw(stream_));
    return pose;
  }
  int below(int count) { return static_cast<int>(stream_.uniform() * count); }

 private:
  random::Stream stream_;
};

Compound round_of(int kind) {
  const auto parts_of = [](const RoundResult& made) {
    return Compound{.parts = {}, .round_parts = made.value().parts};
  };
  switch (kind) {
    case 0:
      return parts_of(cylinder(0.05, 0.12, 0.001, 1));
    case 1:
      return parts_of(coin(0.04, 0.006, 1));
    case 2:
      return parts_of(capsule(0.02, 0.1, 1));
    case 3:
      return parts_of(cone(0.05, 0.1, 0.0005, 1));
    case 4:
      return parts_of(rounded_box({0.1, 0.06, 0.04}, 0.005, 1));
    case 5: {
      // A round piece with rings and balls. Its axis isn't z.
      RoundDescription description{
          .origin_m = {0.01, 0, 0},
          .axis = math::normalized(Vec3(1, 2, 3)),
          .rings = {{.height_m = 0.02, .circle_m = 0.03, .radius_m = 0.002},
                    {.height_m = -0.03, .circle_m = 0.05, .radius_m = 0.01}},
          .balls = {{.centre_m = {0.05, -0.03, 0.02}, .radius_m = 0.015}}};
      return {.parts = {}, .round_parts = {RoundPiece::make(description).value()}};
    }
    case 6:
      return {.parts = {}, .round_parts = {bowling_pin(1.55).value().parts.front()}};
    default:
      return {.parts = {}, .round_parts = {bowling_pin(1.55).value().parts.back()}};
  }
}

Compound other_of(int kind) {
  if (kind < 8) return round_of(kind);
  if (kind == 8) return {.parts = {cube(0.08).value()}};
  if (kind == 9) return {.parts = {tetrahedron(0.08).value()}};
  return {.parts = {box({0.3, 0.2, 0.01}).value()}};
}

/// Two pieces that nearly touch, are apart, or overlap by micrometres.
struct Placed {
  PlacedPose a;
  PlacedPose b;
};
Placed random_places(Dice& dice, const ConvexView& a, const ConvexView& b, double gap_m) {
  Placed placed{dice.pose(), dice.pose()};
  if (dice.below(4) == 0) placed.b.rotation = placed.a.rotation;  // parallel faces and axes
  placed.a.position_m = dice.spread(1e-3, 1) * dice.direction();
  placed.b.position_m = placed.a.position_m + 0.3 * dice.direction();
  // Move the piece along the normal until the gap has the required size.
  for (int i = 0; i < 30; ++i) {
    const Closest closest = closest_round(a, placed.a, b, placed.b);
    placed.b.position_m += (gap_m - closest.gap_m) * closest.normal;
  }
  return placed;
}

TEST(RoundDistance, IsTheGreatestSeparation) {
  // Goal: closest_round() finds the right normal and points. The gap's error is at most
  // k_round_gap_error. Method: for random pairs, search slowly over all axes. The search must not
  // find a separation wider than the gap. One piece of each pair is round, and the other is round
  // or a polyhedron. Gaps range from a nanometre to 0.1 m, and overlaps are up to 3 micrometres
  // deep.
  const std::uint64_t count = property::long_run() ? 1'000'000 : property::of_tier(40, 500);
  double worst_m = 0;
  for (const std::uint64_t n : property::cases(count)) {
    Dice dice(n);
    const Compound first = round_of(dice.below(8));
    const Compound second = other_of(dice.below(11));
    const ConvexView a = first.view(0);
    const ConvexView b = second.view(0);
    const double gap_m = dice.below(4) == 0 ? -dice.spread(1e-9, 3e-6) : dice.spread(1e-9, 0.1);
    const Placed placed = random_places(dice, a, b, gap_m);
    const Closest closest = closest_round(a, placed.a, b, placed.b);
    // Skip the few pairs whose cores (pieces without margins) still overlap.
    if (closest.gap_m < -1e-5) continue;
    ASSERT_NEAR(math::norm(closest.normal), 1, 1e-12) << n;
    // The gap is the separation along the normal.
    const double along_m = -testing::plain_reach_m(a, placed.a, closest.normal) -
                           testing::plain_reach_m(b, placed.b, -closest.normal);
    ASSERT_NEAR(closest.gap_m, along_m, 1e-14) << n;
    // No axis has a wider separation.
    const double error_m =
        k_round_gap_error *
        (a.r_outer_m + b.r_outer_m + math::norm(placed.b.position_m - placed.a.position_m));
    const Closest turned = closest_round(b, placed.b, a, placed.a);
    worst_m = std::max(worst_m, std::fabs(turned.gap_m - closest.gap_m));
    ASSERT_NEAR(turned.gap_m, closest.gap_m, error_m) << n;
    // Long runs search only some pairs, since a search takes a thousand times as long as computing
    // a gap.
    if (!property::long_run() || n % 100 == 0) {
      const double oracle_m = testing::oracle_gap_m(a, placed.a, b, placed.b, closest.normal);
      worst_m = std::max(worst_m, oracle_m - closest.gap_m);
      ASSERT_LT(oracle_m - closest.gap_m, error_m) << n << ": gap " << closest.gap_m;
    }
    const Vec3 between_m = closest.point_b_m - closest.point_a_m;
    ASSERT_LT(math::norm(between_m - closest.gap_m * closest.normal),
              1e-4 * std::max(0.01, std::fabs(closest.gap_m)))
        << n;
  }
  fmt::print("largest shortfall of a gap: {:.2e} m\n", worst_m);
}

TEST(RoundDistance, OfAPointAndAPlaneAreClosedForms) {
  // Goal: the gap between a piece of revolution and a point or a half-space is right. Method: for a
  // point, compare the gap with the separation along the normal, and with a slow search over all
  // axes. For a half-space, compare the gap with the piece's reach along the half-space's normal.
  const PointPiece origin(Vec3::Zero());
  const ConvexView point = origin.view();
  for (std::uint64_t n = 0; n < 1000; ++n) {
    Dice dice(n);
    const int kinds[] = {0, 1, 2, 3, 6, 7};
    const Compound first = round_of(kinds[dice.below(6)]);
    const ConvexView a = first.view(0);
    PlacedPose pose = dice.pose();
    pose.position_m = dice.spread(1e-3, 1) * dice.direction();
    PlacedPose at;
    at.position_m = pose.position_m + dice.uniform(0.001, 0.3) * dice.direction();
    if (n % 10 == 0)  // on the axis
      at.position_m = pose.position_m + dice.uniform(-0.3, 0.3) * Vec3(pose.rotation.col(2));
    const Closest closest = closest_round(a, pose, point, at);
    const double along_m =
        -testing::plain_reach_m(a, pose, closest.normal) + math::dot(closest.normal, at.position_m);
    ASSERT_NEAR(closest.gap_m, along_m, 1e-14) << n;
    if (closest.gap_m > 1e-3) {
      const double oracle_m = testing::oracle_gap_m(a, pose, point, at, closest.normal);
      ASSERT_LT(oracle_m - closest.gap_m, 1e-12) << n;
    }
    const Vec3 normal = dice.direction();
    const double offset_m = dice.uniform(-1, 1);
    const Closest to_plane = closest_round_to_plane(normal, offset_m, a, pose);
    EXPECT_NEAR(to_plane.gap_m, -testing::plain_reach_m(a, pose, -normal) - offset_m, 1e-14);
    EXPECT_NEAR(math::dot(normal, to_plane.point_b_m) - offset_m, to_plane.gap_m, 1e-14);
  }
}

TEST(RoundDistance, SaysThatDeepOverlapsOverlap) {
  // Goal: two pieces have a negative gap if their centres are only 1 mm apart.
  for (std::uint64_t n = 0; n < 500; ++n) {
    Dice dice(n);
    const Compound first = round_of(dice.below(8));
    const Compound second = other_of(dice.below(9));
    PlacedPose pose_a = dice.pose();
    PlacedPose pose_b = dice.pose();
    const ConvexView a = first.view(0);
    const ConvexView b = second.view(0);
    pose_b.position_m = to_world(pose_a, a.centre_m) - math::product(pose_b.rotation, b.centre_m) +
                        1e-3 * dice.direction();
    EXPECT_LT(closest_round(a, pose_a, b, pose_b).gap_m, 0) << n;
  }
}

}  // namespace
}  // namespace sleight::physics
