#include <gtest/gtest.h>

#include <numbers>

#include "common/random/stream.h"
#include "tests/scenes/shared/scenes.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/simulator/plain_geometry.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "worker/physics/contact/resting.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

using testing::RecordedRun;

MotionMode mode_at(const RecordedRun& run, std::uint32_t body, Tick tick) {
  return run.recording.segment_at({body}, tick)->mode;
}

bool all_rest(const RecordedRun& run) {
  for (std::uint32_t body = 0; body < run.scene.bodies.size(); ++body) {
    if (mode_at(run, body, run.recording.end()) != MotionMode::resting) return false;
  }
  return true;
}

/// Latest time at which any body began its last segment.
double last_change_s(const RecordedRun& run) {
  Tick last{};
  for (std::uint32_t body = 0; body < run.scene.bodies.size(); ++body)
    last = std::max(last, run.recording.segments({body}).back().segment.flight.begin);
  return seconds(last - Tick{});
}

Scene floor_scene(const SurfaceLaw& law, const Vec3& normal = {0, 0, 1}) {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.contacts = ContactTable(1, law);
  scene.planes.push_back({.name = "floor", .outside = {.normal = normal, .offset_m = 0}});
  scene.slow = scenes::slow_contacts_of(0.02);
  return scene;
}

BodyDescription cube_at(const Vec3& place_m, const Quat& turn = Quat::Identity()) {
  const BodyShape solid =
      in_body_frame(std::vector{cube(0.02).value()}, 2500, InertiaSymmetry::spherical).value();
  return {.name = {},
          .shape = std::make_shared<const Compound>(Compound{.parts = solid.parts}),
          .inertia = solid.inertia,
          .start = {.pose = {.position_m = place_m, .orientation = turn}, .twist = {}}};
}

BodyDescription ball_at(const Vec3& place_m) {
  return {.name = {},
          .shape = Sphere{.radius_m = 0.01},
          .inertia = solid_ball_inertia(0.02, 0.01),
          .start = {.pose = {.position_m = place_m, .orientation = Quat::Identity()}, .twist = {}}};
}

/// Expects that all bodies rest after `within_s`, and that nothing changes for another `within_s`.
void expect_rest(const Scene& scene, double within_s, const std::string& name) {
  auto started = Simulation::start(scene, {});
  ASSERT_TRUE(started.ok()) << name;
  Simulation simulation = std::move(started).value();
  const auto failed = simulation.run_until(Tick{} + ticks_after(within_s));
  ASSERT_FALSE(failed) << name << ": " << failed->message;
  const RecordedRun run{scene, simulation.recording(), simulation.counts(), ""};
  EXPECT_TRUE(all_rest(run)) << name;
  EXPECT_EQ(simulation.kinetic_energy_j(), 0) << name;
  const Counts then = simulation.counts();
  std::printf(
      "%s: rests after %.3f s, %llu collisions, %llu with static geometry, %llu rest "
      "decisions\n",
      name.c_str(), last_change_s(run), static_cast<unsigned long long>(then.collisions),
      static_cast<unsigned long long>(then.static_collisions),
      static_cast<unsigned long long>(then.rest_decisions));
  const Pose before = simulation.pose({0}, simulation.now());
  ASSERT_FALSE(simulation.run_until(Tick{} + 2 * ticks_after(within_s)));
  EXPECT_EQ(simulation.kinetic_energy_j(), 0) << name;
  EXPECT_EQ(simulation.counts().collisions + simulation.counts().static_collisions,
            then.collisions + then.static_collisions)
      << name;
  EXPECT_EQ(simulation.counts().rest_decisions, then.rest_decisions) << name;
  EXPECT_EQ(simulation.pose({0}, simulation.now()).position_m, before.position_m) << name;
}

TEST(Resting, BodiesComeToRestInFinitelyManyEvents) {
  // Goal: bodies with friction and loss come to rest, and then stay at rest without further events.
  // Method: test a ball, cubes, stacks and a heap. At rest, the kinetic energy must be exactly 0.
  Scene ball = floor_scene({.restitution = 0.5, .friction = 0.4});
  ball.bodies.push_back(ball_at({0, 0, 0.1}));
  expect_rest(ball, 3, "ball");
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const std::string of = " of seed " + std::to_string(seed);
    expect_rest(scenes::cube_drop(1, seed).scene, 3, "cube" + of);
    expect_rest(scenes::cube_stack(3, seed).scene, 3, "stack of 3" + of);
  }
  expect_rest(scenes::grain_heap(25, 1).scene, 5, "heap of 25");
}

TEST(Resting, AHeapOfAHundredGrainsComesToRest) {
  // Goal: a heap of 100 grains comes to rest, as the project promises. Ordinary runs use a heap of
  // 40 grains.
  const std::uint32_t grains = property::long_run() ? 100 : 40;
  expect_rest(scenes::grain_heap(grains, 1).scene, 5, "heap of " + std::to_string(grains));
}

/// Angle between the vertical and the nearest axis of the body's frame.
double tilt_rad(const Quat& q) {
  const Vec3 up = math::rotated(math::inverse(q), Vec3(0, 0, 1));
  const double along = up.cwiseAbs().maxCoeff();
  return std::acos(std::min(1.0, along));
}

TEST(Resting, ACubeRestsOnAFace) {
  // Goal: a dropped cube comes to rest on a face, not on an edge or a corner. Method: drop cubes
  // with random orientations. A face must be level to 1e-3 rad (0.02 mm at the far edge). With
  // coarse slow contacts, 3e-3 rad suffices.
  const std::uint64_t seeds = property::long_run() ? 2000 : 100;
  for (const bool coarse : {false, true}) {
    double worst_rad = 0;
    std::uint64_t collisions = 0;
    for (const std::uint64_t seed : property::seeds(seeds)) {
      Scene scene = scenes::cube_drop(1, seed).scene;
      if (coarse) scene.slow = coarse_slow_contacts_of(0.02, 9.81);
      const RecordedRun run = testing::recorded(scene, 3);
      ASSERT_EQ(run.error, "") << "seed " << seed;
      EXPECT_TRUE(all_rest(run)) << "seed " << seed;
      const double tilt = tilt_rad(run.recording.segments({0}).back().segment.flight.orientation);
      EXPECT_LT(tilt, coarse ? 3e-3 : 1e-3) << "seed " << seed;
      worst_rad = std::max(worst_rad, tilt);
      collisions += run.counts.static_collisions;
    }
    std::printf("%llu cubes, %s: %.1f collisions each, at most %.2e rad from level\n",
                static_cast<unsigned long long>(seeds), coarse ? "coarse" : "fine",
                static_cast<double>(collisions) / static_cast<double>(seeds), worst_rad);
  }
}

TEST(Resting, ACubeSetOnItsEdgeFallsOver) {
  // Goal: slow toppling doesn't count as rest. Method: put one cube on an edge and another cube on
  // a corner. Each cube is a hundredth of a radian from balance.
  const Quat on_edge = math::quaternion_of_rotation_vector({std::numbers::pi / 4 + 0.01, 0, 0});
  const Quat on_corner =
      math::composed(math::quaternion_of_rotation_vector({std::atan(std::sqrt(0.5)) + 0.01, 0, 0}),
                     math::quaternion_of_rotation_vector({0, std::numbers::pi / 4, 0}));
  for (const Quat& turn : {on_edge, on_corner}) {
    Scene scene = floor_scene({.restitution = 0.3, .friction = 0.5});
    double lowest_m = 0;
    const ConvexPolyhedron solid = cube(0.02).value();
    for (const Vec3& v : solid.vertices_m())
      lowest_m = std::min(lowest_m, math::rotated(turn, v).z());
    scene.bodies.push_back(cube_at({0, 0, -lowest_m + 1e-6}, turn));
    const RecordedRun run = testing::recorded(scene, 2);
    ASSERT_EQ(run.error, "");
    EXPECT_TRUE(all_rest(run));
    EXPECT_LT(tilt_rad(run.recording.segments({0}).back().segment.flight.orientation), 1e-3);
  }
}

TEST(Resting, NothingRestsOnASlopeThatIsTooSteep) {
  // Goal: a body rests only if the forces on it can balance. Method: put a cube on a slope of 20
  // degrees. Friction 0.5 holds a cube on slopes of up to 26.6 degrees, and friction 0.2 on slopes
  // of up to 11.3 degrees. No friction holds a ball.
  const double angle = std::numbers::pi / 9;
  const Vec3 normal(std::sin(angle), 0, std::cos(angle));
  const Quat level = math::quaternion_of_rotation_vector({0, angle, 0});
  for (const double friction : {0.2, 0.5}) {
    Scene scene = floor_scene({.restitution = 0.2, .friction = friction}, normal);
    scene.bodies.push_back(cube_at(0.0101 * normal, level));
    const RecordedRun run = testing::recorded(scene, 1);
    ASSERT_EQ(run.error, "");
    EXPECT_EQ(all_rest(run), friction > std::tan(angle)) << friction;
    const Vec3 way_m =
        testing::place_at(run.recording.segments({0}).back().segment, run.recording.end()) -
        0.0101 * normal;
    const double along_m = way_m.x() / std::cos(angle);
    if (friction < std::tan(angle)) {
      const double known_m = 0.5 * 9.81 * (std::sin(angle) - friction * std::cos(angle));
      // During an impact of a body that is no sphere, friction has a single direction. That
      // direction differs slightly from the slip's direction (rigid_impact.h). So friction is too
      // small.
      EXPECT_GT(along_m, 0.95 * known_m);
      EXPECT_LT(along_m, 1.25 * known_m);
    } else {
      EXPECT_LT(std::fabs(along_m), 2e-4);
    }
  }
  Scene scene = floor_scene({.restitution = 0.2, .friction = 1}, normal);
  scene.bodies.push_back(ball_at(0.0101 * normal));
  const RecordedRun run = testing::recorded(scene, 1);
  ASSERT_EQ(run.error, "");
  EXPECT_FALSE(all_rest(run));
}

/// A cube on a cube on the floor, both at rest after half a second.
Scene two_cubes() {
  Scene scene = floor_scene({.restitution = 0.3, .friction = 0.5});
  scene.bodies.push_back(cube_at({0, 0, 0.0101}));
  scene.bodies.push_back(cube_at({0.001, 0, 0.0303}));
  return scene;
}

TEST(Resting, ASupporterThatIsPushedAwayWakesWhatItCarries) {
  // Goal: a resting body wakes at the tick at which its support moves. Method: knock away the lower
  // of two cubes. The upper cube falls to the floor and rests.
  const Tick push = Tick{} + ticks_after(0.5);
  Scene scene = two_cubes();
  scene.controls.push_back({.tick = push, .body = {0}, .velocity_change_mps = {3, 0, 0}});
  const RecordedRun run = testing::recorded(scene, 3);
  ASSERT_EQ(run.error, "");
  EXPECT_EQ(mode_at(run, 0, push - 1), MotionMode::resting);
  EXPECT_EQ(mode_at(run, 1, push - 1), MotionMode::resting);
  EXPECT_EQ(mode_at(run, 0, push), MotionMode::free);
  EXPECT_EQ(mode_at(run, 1, push), MotionMode::free);
  EXPECT_TRUE(all_rest(run));
  EXPECT_LT(run.recording.segments({1}).back().segment.flight.position_m.z(), 0.011);
}

TEST(Resting, WhatLiesOnABodyThatStaysInItsPlaceSleepsOn) {
  // Goal: if a body wakes with its support, the body on top wakes only when the lower body leaves
  // its place. Method: push the lowest of three resting cubes slightly, or knock it away. The
  // middle cube wakes at once in both cases. The top cube wakes and comes down only in the second
  // case.
  const Tick push = Tick{} + ticks_after(0.5);
  for (const double speed_mps : {0.002, 3.0}) {
    Scene scene = two_cubes();
    scene.bodies.push_back(cube_at({0, 0.001, 0.0505}));
    scene.controls.push_back({.tick = push, .body = {0}, .velocity_change_mps = {speed_mps, 0, 0}});
    const RecordedRun run = testing::recorded(scene, 3);
    ASSERT_EQ(run.error, "");
    for (std::uint32_t body = 0; body < 3; ++body)
      EXPECT_EQ(mode_at(run, body, push - 1), MotionMode::resting);
    EXPECT_EQ(mode_at(run, 1, push), MotionMode::free);
    EXPECT_EQ(mode_at(run, 2, push), MotionMode::resting);
    EXPECT_TRUE(all_rest(run));
    const FreeFlight& top = run.recording.segments({2}).back().segment.flight;
    if (speed_mps < 1) {
      EXPECT_LT(top.begin, push);
    } else {
      EXPECT_GT(top.begin, push);
      EXPECT_LT(top.position_m.z(), 0.045);
    }
  }
}

TEST(Resting, NothingHangsInTheAir) {
  // Goal: no body stays asleep in the air after its support has left. Method: knock the lowest
  // grains of heaps away. When all grains rest again, start them from their places in a scene where
  // nothing can rest. In 30 ms, a floating grain would fall by 4 mm, but a supported grain bounces
  // only by micrometres.
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Scene scene = scenes::grain_heap(20, seed).scene;
    for (std::uint32_t body = 0; body < 5; ++body) {
      scene.controls.push_back({.tick = Tick{} + ticks_after(1.5 + 0.1 * body),
                                .body = {body},
                                .velocity_change_mps = {0.8, 0.1 * body, 0}});
    }
    const RecordedRun run = testing::recorded(scene, 6);
    ASSERT_EQ(run.error, "");
    ASSERT_TRUE(all_rest(run)) << seed;
    Scene again = scene;
    again.controls.clear();
    again.slow.rest_speed_mps = 0;
    for (std::uint32_t body = 0; body < again.bodies.size(); ++body) {
      const FreeFlight& flight = run.recording.segments({body}).back().segment.flight;
      // Raise all grains, because some rest within the touch distance of the floor, and no body may
      // start there.
      again.bodies[body].start = {
          .pose = {flight.position_m + Vec3(0, 0, 2 * k_touch_m), flight.orientation}, .twist = {}};
      again.bodies[body].start_tick = {};
    }
    const RecordedRun released = testing::recorded(again, 0.03);
    ASSERT_EQ(released.error, "");
    double most_m = 0;
    for (std::uint32_t body = 0; body < again.bodies.size(); ++body) {
      const Vec3 end_m = testing::place_at(released.recording.segments({body}).back().segment,
                                           released.recording.end());
      most_m = std::max(most_m, math::norm(end_m - again.bodies[body].start.pose.position_m));
    }
    std::printf("let go at once, they move by %.2e m at most\n", most_m);
    EXPECT_LT(most_m, 2e-4) << seed;
  }
}

TEST(Resting, WhoeverRestsLaterIsNotLessCareful) {
  // Goal: if a cube topples with a short rest time, it also topples with a longer rest time.
  // Method: put a cube on a table. The cube's centre is 0.3 mm beyond the table's edge. Use the
  // usual rest time, and rest times that are 5 and 20 times as long.
  for (const double times : {1.0, 5.0, 20.0}) {
    Scene scene = floor_scene({.restitution = 0.3, .friction = 0.5});
    scene.slow.rest_time_s *= times;
    BodyDescription table = cube_at({0, 0, 0});
    const auto& parts = std::get<std::shared_ptr<const Compound>>(table.shape)->parts;
    std::vector<Vec3> corners_m;
    for (const Vec3& corner_m : parts[0].vertices_m())
      corners_m.push_back(corner_m + Vec3(0, 0, 0.03));
    scene.convexes.push_back(
        {.name = "table",
         .polyhedron = std::make_shared<const ConvexPolyhedron>(convex_hull(corners_m).value())});
    scene.bodies.push_back(cube_at({0.0103, 0, 0.0501}));
    const RecordedRun run = testing::recorded(scene, 6);
    ASSERT_EQ(run.error, "");
    EXPECT_TRUE(all_rest(run)) << times;
    EXPECT_LT(run.recording.segments({0}).back().segment.flight.position_m.z(), 0.045) << times;
  }
}

TEST(Resting, AHardBlowWakesAndASoftOneDoesNot) {
  // Goal: a hard blow wakes a resting body, but a soft blow doesn't. The body reflects a soft blow
  // like static geometry. Method: shoot a ball at a resting cube. The ball has half of the speed
  // that wakes the cube, or twice that speed.
  Resting rule;
  Scene scene = floor_scene({.restitution = 0.5, .friction = 0.4});
  rule.reset({}, scene.slow, ticks_after(1));
  scene.bodies.push_back(cube_at({0, 0, 0.0101}));
  scene.bodies.push_back(ball_at({-0.05, 0, 0.012}));
  // Ball and cube weigh 20 g. A fixed cube changes the ball's velocity by (1 + e) v.
  ASSERT_NEAR(scene.bodies[0].inertia.mass_kg, 0.02, 1e-12);
  for (const double share : {0.5, 2.0}) {
    Scene blow = scene;
    const Tick start = Tick{} + ticks_after(0.5);
    const double speed_mps = share * rule.wake_speed_mps() / 1.5;
    blow.bodies[1].start_tick = start;
    blow.bodies[1].start.pose.position_m = {-0.0201, 0, 0.014};
    blow.bodies[1].start.twist.velocity_mps = {speed_mps, 0, 0};
    const RecordedRun run = testing::recorded(blow, 0.52);
    ASSERT_EQ(run.error, "");
    EXPECT_EQ(mode_at(run, 0, start), MotionMode::resting);
    ASSERT_GE(run.recording.segments({1}).size(), 2U);
    EXPECT_EQ(run.recording.segments({1})[1].cause.lower, 0U);
    EXPECT_LT(run.recording.segments({1})[1].segment.flight.velocity_mps.x(), share < 1 ? 0 : 1);
    bool woke = false;
    for (const Recording::Entry& entry : run.recording.segments({0}))
      woke = woke || (entry.cause.tick > start && entry.segment.mode == MotionMode::free);
    EXPECT_EQ(woke, share > 1) << share;
  }
}

// ---- can_carry ----------------------------------------------------------------------------------

TouchRecord contact(const Vec3& arm_m, const Vec3& normal, double friction) {
  return {.tick = {},
          .partner = k_static_partner,
          .friction = friction,
          .normal = math::normalized(normal),
          .arm_m = arm_m};
}

bool carries(const std::vector<TouchRecord>& contacts) {
  return can_carry(contacts, {0, 0, -9.81}, 0.02);
}

TEST(CanCarry, OneContact) {
  // Goal: a single contact supports a body only if the body's centre is straight above the contact.
  // On a slope, friction must also suffice.
  const Vec3 up(0, 0, 1);
  EXPECT_TRUE(carries({contact({0, 0, -0.01}, up, 0)}));
  EXPECT_FALSE(carries({contact({0.005, 0, -0.01}, up, 0)}));
  EXPECT_FALSE(carries({contact({0.005, 0, -0.01}, up, 1)}));
  EXPECT_FALSE(carries({contact({0, 0, 0.01}, -up, 1)}));
  EXPECT_FALSE(carries({}));
  const Vec3 slope(0.3, 0, 1);
  EXPECT_FALSE(carries({contact({0, 0, -0.01}, slope, 0)}));
  EXPECT_FALSE(carries({contact({0, 0, -0.01}, slope, 0.2)}));
  EXPECT_TRUE(carries({contact({0, 0, -0.01}, slope, 0.5)}));
}

TEST(CanCarry, AnEdge) {
  // Goal: two contacts support a body only if its centre is above the line between them. Method:
  // test centres above the line, beside the line and beyond the line's end.
  const auto edge = [](double x_m, double y_m) {
    const Vec3 up(0, 0, 1);
    return carries(
        {contact({x_m - 0.01, y_m, -0.01}, up, 0.5), contact({x_m + 0.01, y_m, -0.01}, up, 0.5)});
  };
  EXPECT_TRUE(edge(0, 0));
  EXPECT_TRUE(edge(0.008, 0));
  EXPECT_FALSE(edge(0, 0.004));
  EXPECT_FALSE(edge(0.014, 0));
}

TEST(CanCarry, AFace) {
  // Goal: three or four contacts support a body only if its centre is above their polygon.
  const auto face = [](double x_m, double y_m, int corners) {
    const Vec3 up(0, 0, 1);
    std::vector<TouchRecord> contacts{contact({x_m - 0.01, y_m - 0.01, -0.01}, up, 0),
                                      contact({x_m + 0.01, y_m - 0.01, -0.01}, up, 0),
                                      contact({x_m + 0.01, y_m + 0.01, -0.01}, up, 0)};
    if (corners == 4) contacts.push_back(contact({x_m - 0.01, y_m + 0.01, -0.01}, up, 0));
    return carries(contacts);
  };
  EXPECT_TRUE(face(0, 0, 4));
  EXPECT_TRUE(face(0.009, -0.009, 4));
  EXPECT_FALSE(face(0.013, 0, 4));
  EXPECT_TRUE(face(-0.003, 0.003, 3));
  // The centre is beyond the long side of the triangle.
  EXPECT_FALSE(face(0.003, -0.003, 3));
}

TEST(CanCarry, Wedges) {
  // Goal: two slanting contacts hold a body between them, if necessary by friction. Method: test a
  // groove and upright walls. The groove needs no friction. The walls hold a body only by friction.
  // Also test a ladder, which slips on a smooth floor.
  const Vec3 left(-0.01, 0, 0);
  const Vec3 right(0.01, 0, 0);
  EXPECT_TRUE(carries({contact(left, {1, 0, 1}, 0), contact(right, {-1, 0, 1}, 0)}));
  EXPECT_FALSE(carries({contact(left, {1, 0, 0}, 0), contact(right, {-1, 0, 0}, 0)}));
  EXPECT_TRUE(carries({contact(left, {1, 0, 0}, 0.5), contact(right, {-1, 0, 0}, 0.5)}));
  // A wedge that opens downwards holds only if its friction exceeds its slope.
  EXPECT_FALSE(carries({contact(left, {1, 0, -0.3}, 0), contact(right, {-1, 0, -0.3}, 0)}));
  EXPECT_FALSE(carries({contact(left, {1, 0, -0.3}, 0.2), contact(right, {-1, 0, -0.3}, 0.2)}));
  EXPECT_TRUE(carries({contact(left, {1, 0, -0.3}, 0.6), contact(right, {-1, 0, -0.3}, 0.6)}));
  const Vec3 foot(0.01, 0, -0.02);
  const Vec3 top(-0.01, 0, 0.02);
  EXPECT_FALSE(carries({contact(foot, {0, 0, 1}, 0), contact(top, {1, 0, 0}, 0)}));
  EXPECT_TRUE(carries({contact(foot, {0, 0, 1}, 0.5), contact(top, {1, 0, 0}, 0.5)}));
}

TEST(CanCarry, WhatFallsOverIsNotLookedAtLonger) {
  // Goal: if falls_over() returns true, can_carry() finds no support. Method: test balls and other
  // bodies. Each has one or two random contacts. Every second set is almost in balance.
  random::Stream stream({.seed = 11, .purpose = random::Purpose::scene}, 0);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * stream.uniform();
  };
  int carried = 0;
  int falling = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double spread = i % 2 == 0 ? 1 : 4e-3;
    const std::size_t count = 1 + static_cast<std::size_t>(i / 2 % 2);
    std::vector<TouchRecord> once;
    for (std::size_t k = 0; k < count; ++k) {
      const double x = uniform(-0.5, 0.5) * (count == 2 ? 1 : spread);
      const double y = uniform(-1, 1) * spread;
      // The second contact is on the side opposite the first contact, up to the spread.
      const double side = k == 0 ? 1 : -1;
      const Vec3 normal = math::normalized(Vec3(side * x, y, 1));
      const Vec3 arm_m =
          i % 4 < 2 ? Vec3(-0.02 * normal) : Vec3(-0.02 * normal + Vec3(0, spread * 0.01, 0));
      once.push_back(contact(arm_m, normal, uniform(0, 0.6)));
    }
    const bool falls = falls_over(once, {0, 0, -1}, 0.02);
    EXPECT_FALSE(falls && carries(once)) << i;
    falling += falls ? 1 : 0;
    carried += carries(once) ? 1 : 0;
  }
  // Most unsupported bodies fall over.
  EXPECT_GT(carried, 1'000);
  EXPECT_GT(falling, 0.9 * (20'000 - carried));
}

}  // namespace
}  // namespace sleight::physics
