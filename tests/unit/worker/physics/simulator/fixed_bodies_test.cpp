// Tests fixed bodies and groups that don't meet. Random scenes are in Equality, Reuse and
// Conservation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "tests/support/facts.h"
#include "tests/support/numbers.h"
#include "tests/unit/worker/physics/collision/surface_tables.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "tests/unit/worker/physics/simulator/reuse_runs.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/shape/round_solids.h"

namespace sleight::physics::fixed_bodies_test {

using testing::RecordedRun;
using testing::RunResult;

constexpr double k_g_mps2 = 9.81;

BodyDescription ball(const Vec3& place_m, const Vec3& velocity_mps = Vec3::Zero(),
                     double mass_kg = 0.1) {
  return {.name = {},
          .shape = Sphere{.radius_m = 0.02},
          .inertia = solid_ball_inertia(mass_kg, 0.02),
          .start = {.pose = {.position_m = place_m}, .twist = {.velocity_mps = velocity_mps}}};
}

BodyDescription cube_at(const Vec3& place_m) {
  const ConvexPolyhedron polyhedron = cube(0.04).value();
  const BodyShape shape = in_body_frame({&polyhedron, 1}, 1000, InertiaSymmetry::spherical).value();
  return {.name = {},
          .shape = std::make_shared<const Compound>(Compound{shape.parts}),
          .inertia = shape.inertia,
          .start = {.pose = {.position_m = place_m}, .twist = {}}};
}

/// A fixed body, with an inertia that no moving body could have.
BodyDescription fixed_at(const Vec3& place_m, const RoundSolid& solid) {
  return {
      .name = "obstacle",
      .shape = std::make_shared<const Compound>(Compound{.parts = {}, .round_parts = solid.parts}),
      .inertia = {.mass_kg = k_nan},
      .start = {.pose = {.position_m = place_m}, .twist = {}},
      .fixed = true};
}
BodyDescription fixed_ball(const Vec3& place_m, double radius_m) {
  BodyDescription body = ball(place_m);
  body.shape = Sphere{.radius_m = radius_m};
  body.inertia = {};
  body.fixed = true;
  return body;
}
/// A fixed slab with rounded edges. Its top is at height 0.
BodyDescription slab(double side_m) {
  return fixed_at({0, 0, -0.05}, rounded_box({side_m, side_m, 0.1}, 0.01, 1000).value());
}

Scene scene_without_statics(const SurfaceLaw& law, double size_m) {
  Scene scene = testing::floor_scene(size_m, law);
  scene.planes.clear();
  return scene;
}

const Segment& last_of(const RecordedRun& run, std::uint32_t body) {
  return run.recording.segments({body}).back().segment;
}

void expect_unmoved(const RecordedRun& run, std::uint32_t body) {
  ASSERT_EQ(run.recording.segments({body}).size(), 1U);
  EXPECT_EQ(last_of(run, body).mode, MotionMode::resting);
  EXPECT_EQ(last_of(run, body).flight.position_m, run.scene.bodies[body].start.pose.position_m);
}

TEST(FixedBodies, ABallBouncesOffAFixedBall) {
  // Goal: an oblique impact on a fixed ball happens at the known time and gives the known velocity,
  // for no friction and for friction that stops all slip. Method: no gravity and no slow contacts.
  constexpr double k_reach_m = 0.02 + 0.3 + k_touch_m;
  constexpr double k_beside_m = 0.16;
  for (const double friction : {0.0, 10.0}) {
    Scene scene;
    scene.contacts = ContactTable(1, {.restitution = 0.7, .friction = friction});
    scene.bodies.push_back(fixed_ball({0, 0, 0}, 0.3));
    scene.bodies.push_back(ball({-1, k_beside_m, 0}, {2, 0, 0}));
    auto simulation = Simulation::start(scene, {}).value();
    ASSERT_FALSE(simulation.run_until(Tick{} + ticks_after(1)));
    EXPECT_EQ(simulation.counts().collisions, 1U);
    const auto entries = simulation.recording().segments({1});
    ASSERT_EQ(entries.size(), 2U);
    const double hit_x_m = -std::sqrt(k_reach_m * k_reach_m - k_beside_m * k_beside_m);
    EXPECT_NEAR(seconds(entries[1].segment.flight.begin - Tick{}), (hit_x_m + 1) / 2, 2e-9);
    const Vec3 normal = Vec3(hit_x_m, k_beside_m, 0) / k_reach_m;
    const double approach_mps = 2 * normal.x();
    const Vec3 along_mps = Vec3(2, 0, 0) - approach_mps * normal;
    const double kept = friction == 0 ? 1 : 5.0 / 7;
    const Vec3 expected_mps = kept * along_mps - 0.7 * approach_mps * normal;
    EXPECT_LT(math::norm(entries[1].segment.flight.velocity_mps - expected_mps), 1e-7);
    EXPECT_EQ(simulation.recording().segments({0}).size(), 1U);
    EXPECT_LT(simulation.kinetic_energy_j(), 0.5 * 0.1 * 2 * 2);  // of the moving ball
  }
}

TEST(FixedBodies, BodiesComeToRestOnThem) {
  // Goal: a ball and a cube come to rest on a fixed cylinder's flat top and on a fixed rounded box.
  // Method: the fixed body has the lowest or the highest id, and is sunk into a floor.
  for (const int way : {0, 1, 2, 3}) {
    Scene scene = testing::floor_scene(0.04, {.restitution = 0.4, .friction = 0.4});
    const RoundSolid solid = way % 2 == 0 ? cylinder(0.15, 0.2, 0.005, 1000).value()
                                          : rounded_box({0.3, 0.2, 0.2}, 0.01, 1000).value();
    scene.bodies = {fixed_at({0, 0, 0.05}, solid), ball({-0.05, 0, 0.2}), cube_at({0.05, 0, 0.2})};
    if (way / 2 == 1) std::swap(scene.bodies[0], scene.bodies[2]);
    const RecordedRun run = testing::recorded(scene, 2);
    ASSERT_EQ(run.error, "");
    for (std::uint32_t body = 0; body < 3; ++body) {
      EXPECT_EQ(last_of(run, body).mode, MotionMode::resting) << way << body;
      if (scene.bodies[body].fixed)
        expect_unmoved(run, body);
      else
        EXPECT_NEAR(last_of(run, body).flight.position_m.z(), 0.17, 1e-5);
    }
  }
}

TEST(FixedBodies, ManyBodiesTouchOneAtOnce) {
  // Goal: as on static geometry, a body's contacts with a fixed body don't depend on how many other
  // bodies touch it: neither its first bounce nor its rest. Method: drop 144 balls at once onto a
  // slab. Each must bounce and rest as one ball alone does.
  const auto dropped = [](int side) {
    Scene scene = scene_without_statics({.restitution = 0.6, .friction = 0.3}, 0.04);
    scene.bodies.push_back(slab(2));
    for (int i = 0; i < side * side; ++i)
      scene.bodies.push_back(ball({0.1 * (i % side) - 0.5, 0.1 * (i / side) - 0.5, 0.1}));
    return testing::recorded(scene, 2);
  };
  const RecordedRun alone = dropped(1);
  const RecordedRun all = dropped(12);
  ASSERT_EQ(all.error, "");
  const auto expected = alone.recording.segments({1});
  EXPECT_EQ(expected.back().segment.mode, MotionMode::resting);
  for (std::uint32_t body = 1; body <= 144; ++body) {
    const auto entries = all.recording.segments({body});
    ASSERT_EQ(entries.size(), expected.size()) << body;
    for (std::size_t i = 0; i < entries.size(); ++i)
      EXPECT_NEAR(entries[i].segment.flight.velocity_mps.z(),
                  expected[i].segment.flight.velocity_mps.z(), 1e-9);
  }
}

TEST(FixedBodies, AHeavyBallDoesNotMoveAPin) {
  // Goal: a ball of ten tons at 20 m/s bounces off a fixed pin, which stands in the floor.
  Scene scene = testing::floor_scene(0.12, {.restitution = 0.5, .friction = 0.2});
  scene.bodies.push_back(fixed_at({0, 0, 0.1}, bowling_pin(1.5).value()));
  scene.bodies.push_back(ball({-1, 0, 0.1}, {20, 0, 1}, 1e4));
  const RecordedRun run = testing::recorded(scene, 1);
  ASSERT_EQ(run.error, "");
  expect_unmoved(run, 0);
  EXPECT_LT(last_of(run, 1).flight.velocity_mps.x(), -1);
}

TEST(FixedBodies, TheyCarryBodiesThatStartAtRest) {
  // Goal: a stack that starts at rest on a fixed body stands without an event. Two stacks on one
  // fixed body are two structures. Method: the fixed body has the highest id.
  Scene scene = scene_without_statics({.friction = 0.5}, 0.04);
  for (const double x_m : {-0.2, 0.2}) {
    for (int i = 0; i < 25; ++i) {
      scene.bodies.push_back(cube_at({x_m, 0, 0.02 + 0.04 * i}));
      scene.bodies.back().rests = true;
    }
  }
  scene.bodies.push_back(slab(1));
  const RecordedRun run = testing::recorded(scene, 60);
  ASSERT_EQ(run.error, "");
  for (std::uint32_t body = 0; body < scene.bodies.size(); ++body)
    expect_unmoved(run, body);
  EXPECT_EQ(run.counts.collisions + run.counts.rest_decisions, 0U);
}

TEST(FixedBodies, OthersAvoidThemAtTheStart) {
  // Goal: fixed bodies may overlap each other and static geometry. A moving body inside one is
  // refused or takes another start, even if its id is lower.
  Scene scene = testing::floor_scene(0.04, {});
  scene.bodies = {ball({0, 0, 0}), fixed_ball({0, 0, 0}, 0.5), fixed_ball({0.3, 0, 0}, 0.5)};
  EXPECT_THAT(testing::recorded(scene, 1e-3).error,
              tests::HasFacts("body 0 can't start|overlaps body 1"));
  scene.bodies[0].start_again = [](std::uint32_t attempt) {
    return ball({0, 0, 0.2 * attempt}).start;
  };
  const RecordedRun run = testing::recorded(scene, 1e-3);
  EXPECT_EQ(run.error, "");
  EXPECT_EQ(run.counts.start_draws, 3U);
}

TEST(FixedBodies, TouchingOneMakesNothingElseLive) {
  // Goal: in a replay, a simulated body that touches an unchanged fixed body doesn't make the other
  // bodies on it live. A moved fixed body does. Method: eight balls on a slab; change one ball's
  // start, or raise the slab.
  Scene before = testing::balls_apart(8);
  before.planes.clear();
  before.bodies.push_back(slab(2));
  const RunResult earlier = testing::run(before, 2);
  Scene after = before;
  after.bodies[5].start.pose.position_m.z() += 0.01;
  const RunResult alone = testing::run(after, 2);
  const RunResult reused = testing::run(after, 2, earlier.history);
  EXPECT_EQ(reused.digest, alone.digest);
  EXPECT_LT(reused.counts.collisions, alone.counts.collisions / 4);
  EXPECT_GT(reused.counts.replayed, alone.counts.collisions / 2);
  after.bodies[8].start.pose.position_m.z() += 0.001;
  EXPECT_EQ(testing::run(after, 2, earlier.history).digest, testing::run(after, 2).digest);
}

TEST(Filters, FilteredPairsPassThroughEachOther) {
  // Goal: bodies and static geometry whose groups don't meet pass through each other; others
  // collide. Method: balls of two groups fall through each other, onto a floor that only group 0
  // meets, and through a block and a fixed ball that only group 1 meets.
  Scene scene = testing::floor_scene(0.04, {.restitution = 0.9});
  scene.slow = {};
  scene.filter.set_meet({0}, {1}, false);
  scene.convexes.push_back({.name = "block",
                            .polyhedron = std::make_shared<const ConvexPolyhedron>(
                                moved(cube(0.1).value(), Mat3::Identity(), {0, 0, 0.5})),
                            .group = {1}});
  scene.bodies = {ball({0, 0, 0.5}), ball({0, 0, 0.8}, {0, 0, -1}), ball({0, 0, 0.5}),
                  fixed_ball({0, 0, 0.25}, 0.1)};
  for (BodyDescription& body : scene.bodies)
    body.group = {1};
  scene.bodies[0].group = {0};
  scene.bodies[2].start_tick = Tick{} + ticks_after(0.9);  // inside the block
  EXPECT_THAT(testing::recorded(scene, 1).error, tests::HasFacts("body 2|overlaps|block"));
  scene.bodies[2].group = {0};
  const RecordedRun run = testing::recorded(scene, 1);
  ASSERT_EQ(run.error, "");
  // The first ball falls to the floor.
  EXPECT_NEAR(seconds(run.recording.segments({0})[1].segment.flight.begin - Tick{}),
              std::sqrt(2 * (0.48 - k_touch_m) / k_g_mps2), 1e-8);
  // The second ball bounces on the block's top.
  EXPECT_NEAR(run.recording.segments({1})[1].segment.flight.position_m.z(), 0.57, 1e-6);
}

TEST(Filters, OnlyBoxesMustMeetASurface) {
  // Goal: a ball that doesn't meet a spline surface falls through it, and a fixed cylinder may be
  // in it, although only boxes can meet surfaces. Method: a cube of another group bounces off.
  Scene scene = scene_without_statics({}, 0.04);
  scene.surfaces.push_back(
      {.name = "table",
       .controls = testing::table_of([](GridIndex) { return SurfaceControl{.restitution = 0.5}; }),
       .spacing_m = 0.1,
       .group = {1}});
  scene.filter.set_meet({0}, {1}, false);
  scene.bodies = {ball({0, 0, 0.1}), cube_at({1, 0, 0.1}),
                  fixed_at({0.3, 0, 0}, cylinder(0.1, 0.2, 0.005, 1000).value())};
  scene.bodies[1].group = {1};
  const RecordedRun run = testing::recorded(scene, 0.3);
  ASSERT_EQ(run.error, "");
  EXPECT_EQ(run.recording.segments({0}).size(), 1U);
  EXPECT_GT(run.recording.segments({1}).size(), 1U);
}

TEST(Filters, FilteredPairsDoNotCarryEachOther) {
  // Goal: a body that starts at rest isn't carried by what it doesn't meet.
  for (const CollisionGroup group : {CollisionGroup{0}, CollisionGroup{1}}) {
    Scene scene = testing::floor_scene(0.04, {.friction = 0.5});
    scene.bodies = {cube_at({0, 0, 0.02}), slab(1)};
    scene.bodies[0].rests = true;
    scene.bodies[0].group = group;
    scene.filter.set_meet({1}, {0}, false);
    EXPECT_EQ(Simulation::start(scene, {}).ok(), group == CollisionGroup{0});
  }
}

}  // namespace sleight::physics::fixed_bodies_test
