// Tests the list of impacts. `Equality` and `Reuse` compare it between ways and with replays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/unit/worker/physics/simulator/noised_scenes.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "worker/physics/response/tangent.h"
#include "worker/physics/shape/mass_properties.h"

namespace sleight::physics::impacts_test {

constexpr double k_g_mps2 = 9.81;
constexpr double k_radius_m = 0.02;

BodyDescription ball(const Vec3& place_m, const Vec3& velocity_mps) {
  return {.name = {},
          .shape = Sphere{.radius_m = k_radius_m},
          .inertia = solid_ball_inertia(0.1, k_radius_m),
          .start = {.pose = {.position_m = place_m}, .twist = {.velocity_mps = velocity_mps}}};
}

BodyDescription box_at(const Vec3& place_m, const Twist& twist) {
  const ConvexPolyhedron polyhedron = box({0.1, 0.08, 0.05}).value();
  const BodyShape shape = in_body_frame({&polyhedron, 1}, 1000, InertiaSymmetry::general).value();
  return {.name = {},
          .shape = std::make_shared<const Compound>(Compound{shape.parts}),
          .inertia = shape.inertia,
          .start = {.pose = {.position_m = place_m}, .twist = twist}};
}

Simulation run(const Scene& scene, double duration_s) {
  Simulation simulation = Simulation::start(scene, {.keep_impacts = true}).value();
  EXPECT_FALSE(simulation.run_until(Tick{} + ticks_after(duration_s)));
  return simulation;
}

TEST(Impacts, ADroppedBallHitsTheFloorAtTheKnownTimeAndSpeed) {
  // Goal: tick, pair and speed are those of a fall by 1 m. Without the option, the list is empty.
  Scene scene = testing::floor_scene(k_radius_m, {.restitution = 0.8, .friction = 0.3});
  scene.bodies.push_back(ball({0, 0, 1 + k_radius_m + k_touch_m}, Vec3::Zero()));
  const Simulation simulation = run(scene, 1);
  ASSERT_FALSE(simulation.impacts().empty());
  const Impact& first = simulation.impacts().front();
  const auto fall = static_cast<double>(ticks_after(std::sqrt(2 / k_g_mps2)));
  EXPECT_NEAR(static_cast<double>(first.tick.value), fall, 1);
  EXPECT_EQ(first.lower, 0U);
  EXPECT_EQ(first.higher, k_static);
  EXPECT_NEAR(first.approach_mps, std::sqrt(2 * k_g_mps2), 1e-7);
  Simulation without = Simulation::start(scene, {}).value();
  EXPECT_FALSE(without.run_until(simulation.now()));
  EXPECT_TRUE(without.impacts().empty());
}

TEST(Impacts, TwoBodiesApproachAtTheirRelativeSpeed) {
  // Goal: the speed is relative, along the normal, and independent of spin and friction. Method:
  // let a ball meet a ball head-on, without and with friction, and the face of a box.
  for (const int way : {0, 1, 2}) {
    Scene scene;
    scene.contacts = ContactTable(1, {.restitution = 0.5, .friction = way == 0 ? 0 : 0.3});
    scene.bodies.push_back(ball({-0.5, 0, 0}, {1, 0, 0}));
    scene.bodies.push_back(way == 2 ? box_at({0.5, 0, 0}, {.velocity_mps = {-0.5, 0, 0}})
                                    : ball({0.5, 0, 0}, {-0.5, 0, 0}));
    if (way == 1) scene.bodies[0].start.twist.angular_velocity_radps = {0, 0, 7};
    const Simulation simulation = run(scene, 1);
    ASSERT_EQ(simulation.impacts().size(), 1U) << way;
    const Impact& impact = simulation.impacts().front();
    EXPECT_EQ(impact.lower, 0U);
    EXPECT_EQ(impact.higher, 1U);
    EXPECT_NEAR(impact.approach_mps, 1.5, 1e-12);
  }
}

TEST(Impacts, NoiseTiltsTheNormalAndChangesTheRestitution) {
  // Goal: the impact is that of the formulas in contact_noise.h, and its strength fades in. Method:
  // let a ball fall onto a floor without friction. Compare with the reflection in the tilted
  // normal. If the ball still approached the floor after it, its speed of separation is the floor
  // of slow contacts, or 0.
  struct Fall {
    double drop_m;
    double above_mps;
    NoiseValue value;
  };
  for (const Fall& fall :
       {Fall{1, 0.1, {0.7, -1.2, 0.4}}, Fall{1, 3, {0.7, -1.2, 0.4}}, Fall{1, 5, {0.7, -1.2, 0.4}},
        Fall{1, 0.1, {0, 0, 30}}, Fall{1, 0.1, {14, 0, -30}}}) {
    Scene scene = testing::floor_scene(k_radius_m, {.restitution = 0.8, .friction = 0});
    scene.bodies.push_back(ball({0, 0, fall.drop_m + k_radius_m + k_touch_m}, Vec3::Zero()));
    auto values = std::make_shared<testing::RandomNoise>();
    values->overrides[{0, k_static, 1}] = fall.value;
    scene.noise = {
        .above_mps = fall.above_mps, .tilt_sd_rad = 0.1, .restitution_sd = 0.1, .values = values};
    const Simulation simulation = run(scene, 0.5);
    const Impact& first = simulation.impacts().front();
    const double strength =
        std::clamp((first.approach_mps - fall.above_mps) / fall.above_mps, 0.0, 1.0);
    EXPECT_EQ(first.noise_number, strength > 0 ? 1U : 0U);
    const Vec3 aside = strength * 0.1 *
                       (fall.value[0] * any_tangent({0, 0, 1}) +
                        fall.value[1] * math::cross(Vec3(0, 0, 1), any_tangent({0, 0, 1})));
    const Vec3 normal = math::normalized(Vec3(0, 0, 1) + aside);
    const double e = std::clamp(0.8 + strength * 0.1 * fall.value[2], 0.0, 1.0);
    const Vec3 before(0, 0, -first.approach_mps);
    Vec3 after = before - (1 + e) * math::dot(before, normal) * normal;
    if (after.z() < 0) after.z() = scene.slow.separation_speed_mps;
    const auto segments = simulation.recording().segments({0});
    const Vec3& found = segments[1].segment.flight.velocity_mps;
    EXPECT_LT(math::norm(found - after), after.z() > 0.1 ? 1e-9 : 0.05) << fall.value[2];
    EXPECT_GE(found.z(), 0);
  }
}

TEST(Impacts, ATumblingBoxHitsWithTheSpeedOfItsLowestCorner) {
  // Goal: a box's speed includes its rotation. Method: compute the speed of the lowest corner from
  // the recording.
  Scene scene = testing::floor_scene(0.1, {.restitution = 0.4, .friction = 0.3});
  scene.bodies.push_back(
      box_at({0, 0, 0.3}, {.velocity_mps = {0.3, 0, 0}, .angular_velocity_radps = {5, 7, -3}}));
  const Simulation simulation = run(scene, 0.5);
  ASSERT_FALSE(simulation.impacts().empty());
  const Impact& first = simulation.impacts().front();
  EXPECT_EQ(first.higher, k_static);
  const Segment& flight = simulation.recording().segments({0}).front().segment;
  const Inertia& inertia = scene.bodies[0].inertia;
  const Quat turn = testing::turn_at(flight, inertia, first.tick);
  const Twist twist = testing::twist_in(flight, inertia, first.tick);
  Vec3 lowest_m = Vec3::Zero();
  const auto& compound = *std::get<std::shared_ptr<const Compound>>(scene.bodies[0].shape);
  for (const Vec3& corner_m : compound.parts.front().vertices_m()) {
    const Vec3 arm_m = math::rotated(turn, corner_m);
    if (arm_m.z() < lowest_m.z()) lowest_m = arm_m;
  }
  const double down_mps =
      -(twist.velocity_mps + math::cross(twist.angular_velocity_radps, lowest_m)).z();
  EXPECT_NEAR(first.approach_mps, down_mps, 1e-9);
  EXPECT_GT(std::fabs(first.approach_mps + twist.velocity_mps.z()), 0.05) << "no rotation";
}

}  // namespace sleight::physics::impacts_test
