#include "worker/physics/marbles/path_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/random/stream.h"
#include "tests/unit/worker/physics/scene/random_meshes.h"
#include "worker/physics/marbles/ball_boxes.h"
#include "worker/physics/marbles/surroundings.h"
#include "worker/physics/motion/free_flight.h"
#include "worker/physics/scene/static_geometry.h"

namespace sleight::physics::path_bounds_test {

using testing::vector_between;

constexpr double k_radius_m = 0.1;

double between(random::Stream& stream, double low, double high) {
  return low + (high - low) * stream.uniform();
}

Scene scene_of(std::uint64_t n, random::Stream& stream) {
  Scene scene;
  scene.bodies.resize(1);
  scene.bodies[0].shape = Sphere{.radius_m = k_radius_m};
  const testing::Raw raw =
      n % 2 == 0 ? testing::sheet(3, 0.1, 0.05, stream) : testing::star(stream, 0.4);
  scene.meshes = {{.name = "it", .mesh = testing::open_mesh(raw)}};
  return scene;
}

/// First tick up to `stop` at which a ball collides with a feature. Judges single ticks only.
Tick first_collision(const StaticGeometry& statics, const SphereFeature& feature,
                     const FreeFlight& flight, Tick stop) {
  for (Tick tick{}; tick <= stop;) {
    const MovingPoint centre{.position_m = position_at(flight, tick),
                             .velocity_mps = velocity_at(flight, tick),
                             .acceleration_mps2 = flight.acceleration_mps2};
    const Examined examined = examine(feature, statics.sides(feature), centre, k_radius_m, tick);
    if (examined.collides) return tick;
    tick = examined.next;
  }
  return k_never;
}

TEST(PathBounds, ComeBeforeEveryCollision) {
  // Goal: no collision is earlier than its lower bound, and the surroundings contain every feature
  // that a ball hits. Method: start flights close to a feature of a random mesh. The ball falls
  // back onto the feature or passes it. Compare the bounds with a search that tests single ticks.
  random::Stream stream({.seed = 11, .purpose = random::Purpose::scene}, 0);
  int met = 0;
  for (std::uint64_t n = 0; n < 40; ++n) {
    const StaticGeometry statics(scene_of(n, stream));
    const NearFeatures near(statics, k_radius_m);
    for (int i = 0; i < 500; ++i) {
      const FeatureId index{
          static_cast<std::uint32_t>(between(stream, 0, statics.feature_count()))};
      if (statics.is_absent(index)) continue;
      const SphereFeature& feature = statics.feature(index);
      const Vec3 away = math::normalized(vector_between(stream, -1, 1));
      const double gap_m = i % 3 == 0 ? between(stream, 0, 1e-7) : between(stream, 0, 0.01);
      const double speed_mps = i % 2 == 0 ? 0.5 : 0.01;
      const FreeFlight flight{.begin = {},
                              .position_m = feature.point_m + (k_radius_m + gap_m) * away,
                              .velocity_mps = vector_between(stream, -speed_mps, speed_mps),
                              .acceleration_mps2 = 10 * vector_between(stream, -1, 1)};
      PathPart path{.place_m = Four::of(flight.position_m),
                    .velocity_mps = Four::of(flight.velocity_mps),
                    .pull_mps2 = Four::of(flight.acceleration_mps2)};
      path.span_s = between(stream, 0, 0.05);
      const Tick stop = Tick{} + ticks_before(path.span_s);
      path.sets_margins(near.coordinates_m(), k_radius_m);
      const PathExtent extent =
          extent_of(path.place_m, path.velocity_mps, path.pull_mps2, path.span_s);
      path.goes(sum(extent.high_m - extent.low_m));
      const Tick tick = first_collision(statics, feature, flight, stop);
      if (tick == k_never) continue;
      ++met;
      const CornerWay way = corner_way(path, feature);
      const bool is_face = feature.kind == FeatureKind::face;
      const double bound_s =
          is_face ? face_not_before_s(path, feature) : corner_not_before_s(path, way, k_radius_m);
      ASSERT_LE(bound_s, seconds(tick - Tick{})) << "mesh " << n << ", flight " << i;
      ASSERT_TRUE(is_face || way.c_c <= path.near_m2) << "mesh " << n << ", flight " << i;
      ASSERT_FALSE(stays_outside(statics.sides(feature), path, bound_s, path.span_s))
          << "mesh " << n << ", flight " << i;
      Surroundings surroundings;
      surroundings.settle(near, near.cell_at(path.place_m), path.place_m);
      const Four there = Four::of(position_at(flight, tick));
      if (!surroundings.holds(there)) continue;
      const NearFeatures::Cell cell = surroundings.cell();
      const std::span<const FeatureId> known = is_face ? cell.faces : cell.corners;
      ASSERT_TRUE(std::ranges::find(known, index) != known.end())
          << "mesh " << n << ", flight " << i;
    }
  }
  EXPECT_GT(met, 500);
}

TEST(PathBounds, ATimeThatAPlaceStaysIsSafe) {
  // Goal: a moving point stays between a box's walls for the time stays_s(). Slightly later, the
  // point is outside. Method: test points on random parabolas.
  random::Stream stream({.seed = 12, .purpose = random::Purpose::scene}, 0);
  for (int i = 0; i < 20'000; ++i) {
    const Four low = Four::of(std::array<double, 4>{-1, -1, -1, -1});
    const Four high = Four::of(std::array<double, 4>{1, 1, 1, 1});
    const Four place = Four::of(vector_between(stream, -1, 1));
    const Four speed = Four::of(vector_between(stream, -2, 2));
    const Four pull = i % 4 == 0 ? Four::zero() : Four::of(vector_between(stream, -9, 9));
    const double stay_s = stays_s(place, speed, pull, low, high);
    const PathExtent within = extent_of(place, speed, pull, stay_s);
    EXPECT_FALSE(is_any_negative(within.low_m - low) || is_any_negative(high - within.high_m));
    const PathExtent beyond = extent_of(place, speed, pull, stay_s * (1 + 1e-6) + 1e-12);
    EXPECT_TRUE(is_any_negative(beyond.low_m - low) || is_any_negative(high - beyond.high_m));
  }
}

TEST(BallBoxes, FindWhatOverlaps) {
  // Goal: for_each_overlapping() visits exactly the overlapping boxes, in order. Method: compare
  // the visited boxes with a loop over all boxes.
  random::Stream stream({.seed = 13, .purpose = random::Purpose::scene}, 0);
  const auto box_of = [&] {
    TouchBox box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low_m[axis] = static_cast<float>(stream.uniform());
      box.high_m[axis] = box.low_m[axis] + 0.4F * static_cast<float>(stream.uniform());
    }
    return box;
  };
  for (std::uint32_t count = 1; count < 20; ++count) {
    BallBoxes boxes;
    boxes.assign(count);
    std::vector<TouchBox> plain;
    for (BodyId ball{}; ball < count; ++ball) {
      plain.push_back(box_of());
      boxes.set(ball, plain.back());
      EXPECT_EQ(boxes.of(ball).high_m, plain.back().high_m);
    }
    for (int i = 0; i < 50; ++i) {
      const TouchBox box = box_of();
      std::vector<std::uint32_t> found;
      boxes.for_each_overlapping(box, [&](std::uint32_t ball) { found.push_back(ball); });
      std::vector<std::uint32_t> expected;
      for (BodyId ball{}; ball < count; ++ball) {
        if (overlaps(box, plain[ball])) expected.push_back(ball);
      }
      EXPECT_EQ(found, expected);
    }
  }
}

}  // namespace sleight::physics::path_bounds_test
