#include "worker/physics/marbles/marbles.h"

#include <gtest/gtest.h>

#include "common/random/distributions.h"
#include "common/random/stream.h"
#include "tests/scenes/shared/scenes.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/marbles/equal_marbles.h"
#include "tests/unit/worker/physics/marbles/same_balls.h"
#include "tests/unit/worker/physics/scene/random_friction.h"

namespace sleight::physics {
namespace {

/// With even seeds, all balls start at once. In every third scene, the floor's friction varies.
scenes::Setting equal_marbles(std::uint32_t balls, std::uint64_t seed) {
  scenes::Setting setting = testing::equal_marbles(balls, seed, seed % 2 == 0 ? 0 : 40'000'000);
  if (seed % 3 == 0) {
    random::Stream stream({.seed = seed, .purpose = random::Purpose::prior}, 0);
    StaticPlane& floor = setting.scene.planes.front();
    floor.friction_map = testing::random_friction(stream, floor.outside, 30, 0.1);
  }
  return setting;
}

std::uint64_t scene_count() {
  return property::long_run() ? 20'000 : property::of_tier(40, 200);
}

SimulationOptions places_only() {
  SimulationOptions options;
  options.record = false;
  return options;
}

TEST(Marbles, EqualASimulation) {
  // Goal: Marbles and Simulation compute the same results (marbles.h, invariant 1). Method: compare
  // both engines in random scenes of up to 40 balls. Compare twenty moments of each scene.
  for (const std::uint64_t seed : property::cases(scene_count())) {
    const scenes::Setting setting =
        equal_marbles(seed % 10 == 9 ? 40 : 1 + static_cast<std::uint32_t>(seed % 15), seed);
    const Scene& scene = setting.scene;
    ASSERT_TRUE(are_marbles(scene));
    auto started = Simulation::start(scene, places_only());
    const StaticGeometry statics(scene);
    const NearFeatures near(statics, std::get<Sphere>(scene.bodies[0].shape).radius_m);
    const Tick end = Tick{} + ticks_after(setting.duration_s);
    Marbles marbles;
    marbles.start(scene, near, end);
    ASSERT_EQ(started.ok(), !marbles.run_until(Tick{})) << "seed " << seed;
    if (!started) continue;
    Simulation simulation = std::move(started).value();
    bool goes_on = true;
    for (int look = 1; look <= 20 && goes_on; ++look) {
      ASSERT_TRUE(testing::alike_at(simulation, marbles, Tick{end.value * look / 20}, goes_on))
          << "seed " << seed;
    }
  }
}

TEST(Marbles, ComparerFindsADifference) {
  // Goal: alike_at() notices a difference. Method: in one of the two engines, start one ball a
  // nanometre higher.
  scenes::Setting setting = equal_marbles(5, 3);
  auto simulation = Simulation::start(setting.scene, places_only()).value();
  setting.scene.bodies[2].start.pose.position_m.z() += 1e-9;
  const StaticGeometry statics(setting.scene);
  const NearFeatures near(statics, std::get<Sphere>(setting.scene.bodies[0].shape).radius_m);
  Marbles marbles;
  const Tick end = Tick{} + ticks_after(0.2);
  marbles.start(setting.scene, near, end);
  bool goes_on = true;
  EXPECT_FALSE(testing::alike_at(simulation, marbles, end, goes_on));
}

TEST(Marbles, OverlapsAreErrors) {
  // Goal: Marbles reports the simulator's error if two balls start in one place or a ball starts
  // inside the floor.
  for (const bool in_floor : {false, true}) {
    scenes::Setting setting = equal_marbles(5, 4);
    auto& bodies = setting.scene.bodies;
    bodies[3].start.pose.position_m =
        in_floor ? Vec3(0, 0, -0.5) : Vec3(bodies[1].start.pose.position_m + Vec3(1e-3, 0, 0));
    auto started = Simulation::start(setting.scene, places_only());
    ASSERT_FALSE(started.ok());
    const StaticGeometry statics(setting.scene);
    const NearFeatures near(statics, std::get<Sphere>(bodies[0].shape).radius_m);
    Marbles marbles;
    marbles.start(setting.scene, near, Tick{});
    const auto error = marbles.run_until(Tick{});
    ASSERT_TRUE(error);
    EXPECT_EQ(error->kind, started.error().kind);
    EXPECT_EQ(error->message, started.error().message);
  }
}

TEST(Marbles, StartsInTouchAreErrors) {
  // Goal: like the simulator, Marbles refuses a ball that touches a face, an edge or a vertex at
  // the start. Marbles accepts a ball that is slightly further away. Method: place a ball near
  // random features of random scenes. Some gaps are below the touch distance, and some are above
  // it.
  std::uint64_t refused = 0;
  std::uint64_t started_well = 0;
  for (const std::uint64_t seed : property::cases(20)) {
    Scene scene = equal_marbles(1, seed).scene;
    random::Stream stream({.seed = 20'261'122, .purpose = random::Purpose::prior}, seed);
    const double radius_m = std::get<Sphere>(scene.bodies[0].shape).radius_m;
    const StaticGeometry statics(scene);
    const NearFeatures near(statics, radius_m);
    scene.bodies[0].start_tick = Tick{};
    for (int n = 0; n < 200; ++n) {
      const SphereFeature& feature = statics.feature({static_cast<std::uint32_t>(
          random::UniformInteger{.count = statics.feature_count()}.draw(stream))});
      const random::Uniform sides{.low = -1, .high = 1};
      Vec3 away;
      for (int axis = 0; axis < 3; ++axis)
        away[axis] = sides.draw(stream);
      away = feature.kind == FeatureKind::face ? feature.direction : math::normalized(away);
      const double gap_m = (n % 2 == 0 ? 0.5 : 2) * k_touch_m;
      scene.bodies[0].start.pose.position_m = feature.point_m + (radius_m + gap_m) * away;
      const auto started = Simulation::start(scene, places_only());
      Marbles marbles;
      marbles.start(scene, near, Tick{});
      const auto error = marbles.run_until(Tick{});
      ASSERT_EQ(started.ok(), !error) << "seed " << seed << ", place " << n;
      if (error) {
        EXPECT_EQ(error->message, started.error().message);
      }
      ++(error ? refused : started_well);
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(refused, 200U);
  EXPECT_GT(started_well, 100U);
}

TEST(Marbles, AreRecognised) {
  // Goal: are_marbles() rejects scenes that the engine doesn't support. Method: change one property
  // of a supported scene at a time.
  const Scene scene = equal_marbles(3, 1).scene;
  EXPECT_TRUE(are_marbles(scene));
  Scene other = scene;
  other.bodies[1].shape = Sphere{.radius_m = 0.001};
  EXPECT_FALSE(are_marbles(other));
  other = scene;
  other.bodies[1].inertia.mass_kg *= 2;
  EXPECT_FALSE(are_marbles(other));
  other = scene;
  other.bodies[1].material = MaterialId{1};
  EXPECT_FALSE(are_marbles(other));
  other = scene;
  other.controls.push_back({});
  EXPECT_FALSE(are_marbles(other));
  other = scene;
  other.slow = {};
  EXPECT_FALSE(are_marbles(other));
  other = scene;
  other.bodies[1].fixed = true;
  EXPECT_FALSE(are_marbles(other));
  other = scene;
  other.filter.set_meet({2}, {3}, false);
  EXPECT_FALSE(are_marbles(other));
  struct Zero final : NoiseValues {
    NoiseValue at(const NoiseAddress& /*address*/) const override { return {}; }
  };
  other = scene;
  other.noise.values = std::make_shared<Zero>();
  EXPECT_FALSE(are_marbles(other));
}

}  // namespace
}  // namespace sleight::physics
