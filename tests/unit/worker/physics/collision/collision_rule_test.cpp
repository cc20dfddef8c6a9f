// Tests the rule that decides when two things collide, and its closed form for free spheres.
#include "worker/physics/collision/collision_rule.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/scene/random_meshes.h"
#include "worker/physics/collision/sphere_search.h"

namespace sleight::physics::collision_rule_test {

using testing::vector_between;

TEST(CollisionRule, TouchIncludesItsLimitAndApproachDoesNot) {
  // Goal: a gap equal to the touch distance counts as a touch, but a rate equal to the approach
  // limit doesn't count as an approach. Method: test the limits, neighbouring floats and NaN.
  const double slow_mps = -k_approach_mps;
  const double fast_mps = std::nextafter(slow_mps, -1);
  EXPECT_TRUE(collides(k_touch_m, fast_mps));
  EXPECT_FALSE(collides(k_touch_m, slow_mps));
  EXPECT_FALSE(collides(std::nextafter(k_touch_m, 1), fast_mps));
  EXPECT_TRUE(collides(-1, -1));
  EXPECT_FALSE(collides(-1, 1));
  EXPECT_FALSE(collides(0.5 * k_touch_m, -1, 0.25 * k_touch_m));
  EXPECT_FALSE(collides(std::nan(""), -1));
  EXPECT_FALSE(collides(0, std::nan("")));
}

TEST(CollisionRule, BordersBelongToOneFeature) {
  // Goal: a place on the border between a face and an edge belongs only to the face's region.
  // Method: the face's region is a closed half-space, and the edge's region is the opposite open
  // half-space. Test in which region each place is.
  const RegionSide of_face{.space = {.normal = {1, 0, 0}, .offset_m = 0.5}, .strict = false};
  const RegionSide of_edge{.space = {.normal = {-1, 0, 0}, .offset_m = -0.5}, .strict = true};
  for (const double x_m : {0.25, 0.5, 0.75}) {
    const Vec3 place_m(x_m, 3, -2);
    EXPECT_NE(is_inside(std::span(&of_face, 1), place_m),
              is_inside(std::span(&of_edge, 1), place_m));
  }
  EXPECT_TRUE(is_inside(std::span(&of_face, 1), {0.5, 0, 0}));
  EXPECT_TRUE(is_inside(std::span<const RegionSide>{}, {0, 0, 0}));
}

/// Distance between a place and a feature. Doesn't use the rule's formulas.
double distance_m(const SphereFeature& feature, const Vec3& place_m) {
  const Vec3 from_m = place_m - feature.point_m;
  if (feature.kind == FeatureKind::face) return math::dot(from_m, feature.direction);
  if (feature.kind == FeatureKind::vertex) return math::norm(from_m);
  return math::norm(math::cross(from_m, feature.direction));
}

Vec3 feature_direction(std::uint64_t n) {
  return n % 3 == 0 ? Vec3(0, 0, 1) : Vec3(0, 1, 0);
}

TEST(CollisionRule, GapAndRateAreTheDistanceAndItsDerivative) {
  // Goal: the gap between a sphere and a feature, and the gap's rate of change, are right for each
  // kind of feature. Method: compute a distance with a different formula, and compare the gap with
  // it. Compare the rate with a central difference of that distance.
  for (const std::uint64_t n : property::cases(3000)) {
    random::Stream stream({.seed = 23, .purpose = random::Purpose::scene}, n);
    const SphereFeature feature{
        .kind = std::array{FeatureKind::face, FeatureKind::edge, FeatureKind::vertex}[n % 3],
        .point_m = vector_between(stream, -1, 1),
        .direction = math::normalized(vector_between(stream, -1, 1))};
    const MovingPoint centre{.position_m = feature.point_m + vector_between(stream, 0.1, 1),
                             .velocity_mps = vector_between(stream, -3, 3),
                             .acceleration_mps2 = Vec3::Zero()};
    const double radius_m = 0.3 * stream.uniform();
    const double now_m = distance_m(feature, centre.position_m);
    if (feature.kind == FeatureKind::edge && now_m < 0.05) continue;
    const GapAndRate gap = gap_between(feature, centre, radius_m);
    EXPECT_NEAR(gap.gap_m, now_m - radius_m, 1e-14);
    constexpr double k_step_s = 1e-6;
    const auto after = [&](double s) -> double {
      return distance_m(feature, centre.position_m + s * centre.velocity_mps);
    };
    EXPECT_NEAR(gap.rate_mps, (after(k_step_s) - after(-k_step_s)) / (2 * k_step_s), 1e-7);
    // A search starts from gap_state(), which must return the same gap and rate, bit for bit.
    const GapState state = gap_state(feature, centre, radius_m);
    EXPECT_EQ(state.now.gap_m, gap.gap_m);
    EXPECT_EQ(state.now.rate_mps, gap.rate_mps);
  }
}

TEST(CollisionRule, SearchesOfSpheresJudgeByIt) {
  // Goal: for a sphere near a feature and for two spheres, a search finds a collision exactly if
  // the collision rule finds one. For each condition of the rule, a search computes how long the
  // condition will stay unmet. If all these times are 0, the search finds a collision. Method: for
  // random spheres near features, compare the search's verdict with the rule's verdict. Each sphere
  // is exactly at a limit of the rule, or slightly to one side of it.
  std::array<std::uint64_t, 2> verdicts{};
  for (const std::uint64_t n : property::cases(100'000)) {
    random::Stream stream({.seed = 31, .purpose = random::Purpose::scene}, n);
    const auto near = [&](double limit, double by) {
      return stream.bits() % 4 == 0 ? limit : limit + by * (stream.uniform() - 0.5);
    };
    const SphereFeature feature{
        .kind = std::array{FeatureKind::face, FeatureKind::edge, FeatureKind::vertex}[n % 3],
        .point_m = {0, 0, 0},
        .direction = feature_direction(n)};
    const double radius_m = 0.125;
    // The sphere is above the feature's point. The region's border is at x = 0.
    const std::array sides{RegionSide{.space = {.normal = {1, 0, 0}, .offset_m = 0},
                                      .strict = feature.kind != FeatureKind::face}};
    const MovingPoint centre{
        .position_m = {near(0, 1e-7), 0, radius_m + near(k_touch_m, 1e-7)},
        .velocity_mps = {stream.uniform() - 0.5, 0, near(-k_approach_mps, 1e-8)},
        .acceleration_mps2 = {0, 0, -9.81}};
    const bool expected = collides(feature, sides, centre, radius_m);
    ++verdicts[expected ? 1 : 0];
    EXPECT_EQ(examine(feature, sides, centre, radius_m, Tick{}).collides, expected) << n;
    const GapAndRate apart = gap_to_round(centre.position_m, centre.velocity_mps, radius_m);
    EXPECT_EQ(examine_spheres(centre, radius_m, radius_m, k_touch_m, Tick{}).collides,
              collides(apart))
        << n;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(verdicts[0], 5'000U);
  EXPECT_GT(verdicts[1], 5'000U);
}

/// Returns the first tick at which the rule finds a collision of two spheres. There is no gravity.
Tick first_by_rule(const Vec3& between_m, const Vec3& relative_mps, double radii_m) {
  for (Tick tick{}; tick != k_never;) {
    const MovingPoint relative{.position_m = between_m + seconds(tick - Tick{}) * relative_mps,
                               .velocity_mps = relative_mps,
                               .acceleration_mps2 = Vec3::Zero()};
    const double coordinates_m = math::norm(relative.position_m);
    const Examined examined = examine_spheres(relative, radii_m, coordinates_m, k_touch_m, tick);
    if (examined.collides) return tick;
    tick = examined.next;
  }
  return k_never;
}

TEST(CollisionRule, ClosedFormOfFreeSpheresKeepsIt) {
  // Goal: the closed form for two free spheres finds the rule's first collision tick, or none.
  // Method: compare the closed form with the search on random flights. On some flights, the spheres
  // only graze each other, hardly approach, or touch at the start. Rounding may shift the collision
  // by one tick. Rounding may also change the verdict on a grazing flight, if the touch lasts at
  // most two ticks or the distance from the limit is a rounding error.
  std::uint64_t hits = 0;
  std::uint64_t same = 0;
  std::uint64_t misses = 0;
  std::uint64_t grazing = 0;
  for (const std::uint64_t n : property::cases(property::long_run() ? 10'000'000 : 100'000)) {
    random::Stream stream({.seed = 29, .purpose = random::Purpose::scene}, n);
    const double radii_m = 0.002 + 0.2 * stream.uniform();
    const double reach_m = radii_m + k_touch_m;
    const Vec3 away = math::normalized(vector_between(stream, -1, 1));
    const double speed_mps = std::pow(10, -2 + 3 * stream.uniform());
    Vec3 relative_mps = speed_mps * math::normalized(vector_between(stream, -1, 1));
    if (n % 4 == 1) {  // hardly approaches at the touch
      relative_mps -= math::dot(relative_mps, away) * away;
      relative_mps += std::pow(10, -12 + 8 * stream.uniform()) * (stream.uniform() - 0.7) * away;
    }
    const double off_m = n % 2 == 0 ? 0 : 1e-7 * (stream.uniform() - 0.5);
    const double back_s = n % 8 == 3 ? 0 : std::pow(10, -6 + 5 * stream.uniform());
    const Vec3 between_m = (reach_m + off_m) * away - back_s * relative_mps;

    const TickCount span = collision_of_free_spheres(between_m, relative_mps, radii_m);
    const Tick by_form = span == k_tick_max.value ? k_never : Tick{} + span;
    const Tick by_rule = first_by_rule(between_m, relative_mps, radii_m);
    if ((by_form == k_never) == (by_rule == k_never)) {
      misses += by_form == k_never ? 1 : 0;
      hits += by_form == k_never ? 0 : 1;
      same += by_form != k_never && by_form == by_rule ? 1 : 0;
      // At the spheres' relative speed, the gap's rounding error is less than one tick.
      if (by_form != k_never) {
        EXPECT_LE(std::abs(by_form - by_rule), 1) << n;
      }
      continue;
    }
    ++grazing;
    const double towards = math::dot(between_m, relative_mps);
    const double speed2 = math::dot(relative_mps, relative_mps);
    const double distance2 = math::dot(between_m, between_m);
    const double discriminant = towards * towards - speed2 * (distance2 - reach_m * reach_m);
    const double slowest = k_approach_mps * reach_m;
    const double rounding =
        0x1p-49 * (towards * towards + speed2 * (distance2 + reach_m * reach_m));
    EXPECT_TRUE(std::fabs(discriminant - slowest * slowest) <= rounding ||
                std::sqrt(discriminant) <= 2 * k_seconds_per_tick * speed2)
        << n;
  }
  std::printf("%llu collide, %llu of them at the same tick; %llu don't; %llu graze\n",
              static_cast<unsigned long long>(hits), static_cast<unsigned long long>(same),
              static_cast<unsigned long long>(misses), static_cast<unsigned long long>(grazing));
  if (!property::all_cases()) return;
  EXPECT_GT(hits, misses / 4);
  EXPECT_GT(misses, hits / 20);
  EXPECT_GT(same, hits * 99 / 100);
}

}  // namespace sleight::physics::collision_rule_test
