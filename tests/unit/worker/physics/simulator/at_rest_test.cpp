// Tests which bodies may start at rest (pins, a stack, an arch), and what wakes them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "tests/scenes/shared/random_starts.h"
#include "tests/scenes/shared/scenes.h"
#include "tests/support/facts.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "tests/unit/worker/physics/simulator/reuse_runs.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/shape/round_solids.h"

namespace sleight::physics::at_rest_test {

using std::numbers::pi;
using testing::RecordedRun;

constexpr double k_g_mps2 = 9.81;

Scene floor_scene(double size_m, double friction) {
  return testing::floor_scene(size_m, {.restitution = 0.3, .friction = friction});
}

BodyDescription hull_at(const std::string& name, const std::vector<Vec3>& points_m) {
  const ConvexPolyhedron polyhedron = convex_hull(points_m).value();
  const BodyShape shape = in_body_frame({&polyhedron, 1}, 1000, InertiaSymmetry::general).value();
  return {.name = name,
          .shape = std::make_shared<const Compound>(Compound{shape.parts}),
          .inertia = shape.inertia,
          .start = {.pose = shape.frame, .twist = {}},
          .rests = true};
}
BodyDescription box_at(const std::string& name, const Vec3& sides_m, const Vec3& centre_m) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back(centre_m + 0.5 * Vec3((i & 1) != 0 ? sides_m.x() : -sides_m.x(),
                                            (i & 2) != 0 ? sides_m.y() : -sides_m.y(),
                                            (i & 4) != 0 ? sides_m.z() : -sides_m.z()));
  return hull_at(name, corners);
}

/// Ten pins on their spots, a foot apart.
Scene pins() {
  Scene scene = floor_scene(0.12, 0.5);
  const RoundSolid pin = bowling_pin(1.55).value();
  const auto shape =
      std::make_shared<const Compound>(Compound{.parts = {}, .round_parts = pin.parts});
  for (int row = 0; row < 4; ++row) {
    for (int i = 0; i <= row; ++i)
      scene.bodies.push_back(
          {.name = fmt::format("pin {}", scene.bodies.size() + 1),
           .shape = shape,
           .inertia = pin.inertia,
           .start = {.pose = {.position_m = {0.264 * row, 0.3048 * (i - 0.5 * row), pin.foot_m}},
                     .twist = {}},
           .rests = true});
  }
  return scene;
}

/// Stones that lean on each other in a semicircle of mean radius 1.
Scene arch(int count, double thickness, double friction) {
  Scene scene = floor_scene(0.2, friction);
  const double half = 0.5 * pi / count;
  for (int i = 0; i < count; ++i) {
    std::vector<Vec3> corners;
    for (const double angle : {2 * i * half, 2 * (i + 1) * half}) {
      for (const double r : {1 - 0.5 * thickness, 1 + 0.5 * thickness}) {
        for (const double y : {-0.1, 0.1})
          corners.emplace_back(r * std::cos(angle), y, r * std::sin(angle));
      }
    }
    scene.bodies.push_back(hull_at(fmt::format("stone {}", i + 1), corners));
  }
  return scene;
}

/// Expects no events for a minute.
void expect_nothing_happens(const Scene& scene) {
  const RecordedRun run = testing::recorded(scene, 60);
  ASSERT_EQ(run.error, "");
  EXPECT_EQ(run.counts.collisions + run.counts.static_collisions + run.counts.modes +
                run.counts.rest_decisions,
            0U);
  for (std::uint32_t body = 0; body < scene.bodies.size(); ++body) {
    ASSERT_EQ(run.recording.segments({body}).size(), 1U);
    EXPECT_EQ(run.recording.segments({body}).front().segment.mode, MotionMode::resting);
  }
}

TEST(AtRest, PinsAStackAndAnArchStandForAMinute) {
  // Goal: pins, a stack and an arch that start at rest have no events for a minute.
  expect_nothing_happens(pins());
  Scene stack = floor_scene(0.1, 0.5);
  for (int i = 0; i < 3; ++i)
    stack.bodies.push_back(
        box_at(fmt::format("cube {}", i), {0.1, 0.1, 0.1}, {0.01 * i, 0, 0.05 + 0.1 * i}));
  expect_nothing_happens(stack);
  expect_nothing_happens(arch(15, 0.13, 0.7));
}

/// A cube of side 10 cm, turned about the vertical.
BodyDescription turned_cube_at(const std::string& name, const Vec3& centre_m, double yaw_rad) {
  BodyDescription body = box_at(name, {0.1, 0.1, 0.1}, centre_m);
  body.start.pose.orientation = math::composed(math::quaternion_of_rotation_vector({0, 0, yaw_rad}),
                                               body.start.pose.orientation);
  return body;
}

TEST(AtRest, TwentyCubesStandForAMinute) {
  // Goal: a stack of 20 cubes that lie askew on each other starts at rest and stays at rest. A
  // stack that is dropped from slightly above comes to rest and stays at rest. Method: count the
  // events of the first stack. Test that the dropped cubes rest after one second. In one stack, all
  // cubes have the same yaw. Neighbouring cubes then touch at two crossings of edges and at one
  // corner of each cube. In the other stack, yaws differ.
  for (const bool alike : {true, false}) {
    Scene stack = floor_scene(0.1, 0.5);
    random::Stream stream = scenes::stream_of_scene(1, alike ? 0 : 1);
    for (int i = 0; i < 20; ++i) {
      const double x_m = scenes::between(stream, 0, 0.005);
      const double y_m = scenes::between(stream, 0, 0.005);
      const double yaw_rad = scenes::between(stream, 0, alike ? 0 : pi);
      stack.bodies.push_back(
          turned_cube_at(fmt::format("cube {}", i), {x_m, y_m, 0.05 + 0.1 * i}, yaw_rad));
    }
    expect_nothing_happens(stack);

    Scene let_go = stack;
    let_go.slow = coarse_slow_contacts_of(0.1, k_g_mps2);
    for (std::size_t i = 0; i < let_go.bodies.size(); ++i) {
      let_go.bodies[i].rests = false;
      let_go.bodies[i].start.pose.position_m.z() += 1e-4 * static_cast<double>(i + 1);
    }
    const RecordedRun run = testing::recorded(let_go, 60);
    ASSERT_EQ(run.error, "");
    for (std::uint32_t body = 0; body < let_go.bodies.size(); ++body) {
      const auto& last = run.recording.segments({body}).back().segment;
      EXPECT_EQ(last.mode, MotionMode::resting);
      EXPECT_LT(seconds(last.flight.begin - Tick{}), 1);
      EXPECT_LT(math::norm(last.flight.position_m - stack.bodies[body].start.pose.position_m),
                1e-3);
    }
  }
}

std::string refusal_of(const Scene& scene) {
  const auto started = Simulation::start(scene, {});
  return started.ok() ? "" : started.error().message;
}

TEST(AtRest, WhatIsNotInBalanceIsNamed) {
  // Goal: if a body can't start at rest, an error names the body and the reason. The error doesn't
  // count as a failure of the simulation. Method: test a thin arch, blocks that slide, lean, float
  // or overlap, and bodies that may not start at rest.
  const Scene thin = arch(15, 0.09, 0.7);
  EXPECT_NE(refusal_of(thin).find("stone"), std::string::npos) << refusal_of(thin);
  EXPECT_NE(refusal_of(thin).find("topple or fall"), std::string::npos) << refusal_of(thin);
  EXPECT_FALSE(is_failure(Simulation::start(thin, {}).error().kind));

  Scene slope = floor_scene(0.1, 0.3);
  slope.gravity_mps2 = k_g_mps2 * Vec3(std::sin(0.35), 0, -std::cos(0.35));
  slope.bodies.push_back(box_at("block", {0.1, 0.1, 0.03}, {0, 0, 0.015}));
  EXPECT_THAT(refusal_of(slope), tests::HasFacts("body 'block'|at rest|friction"));

  Scene leans = floor_scene(0.1, 0.5);
  leans.bodies.push_back(box_at("lower", {0.1, 0.1, 0.1}, {0, 0, 0.05}));
  leans.bodies.push_back(box_at("upper", {0.1, 0.1, 0.1}, {0.06, 0, 0.15}));
  EXPECT_NE(refusal_of(leans).find("'upper'"), std::string::npos) << refusal_of(leans);
  EXPECT_NE(refusal_of(leans).find("body 'lower'"), std::string::npos) << refusal_of(leans);

  Scene air = floor_scene(0.1, 0.5);
  air.bodies.push_back(box_at("kite", {0.1, 0.1, 0.1}, {0, 0, 0.0501}));
  EXPECT_THAT(refusal_of(air), tests::HasFacts("body 'kite'|neither static geometry"));

  Scene overlaps = floor_scene(0.1, 0.5);
  overlaps.bodies.push_back(box_at("one", {0.1, 0.1, 0.1}, {0, 0, 0.05}));
  overlaps.bodies.push_back(box_at("other", {0.1, 0.1, 0.1}, {0, 0, 0.14}));
  EXPECT_NE(refusal_of(overlaps).find("it overlaps body 'one'"), std::string::npos)
      << refusal_of(overlaps);

  Scene late = pins();
  late.bodies[3].start_tick = Tick{5};
  EXPECT_NE(refusal_of(late).find("'pin 4'"), std::string::npos) << refusal_of(late);
  Scene restless = pins();
  restless.slow.rest_speed_mps = 0;
  EXPECT_NE(refusal_of(restless).find("rest_speed_mps"), std::string::npos) << refusal_of(restless);
}

TEST(AtRest, ABallWakesThePinsThatItHits) {
  // Goal: a body that starts at rest wakes if another body hits it, or if its support moves away.
  // Method: roll a bowling ball into the pins, and knock a stone out of the arch.
  Scene scene = pins();
  scene.bodies.push_back(
      {.name = "ball",
       .shape = Sphere{.radius_m = 0.108},
       .inertia = solid_ball_inertia(6.8, 0.108),
       .start = {.pose = {.position_m = {-0.6, 0.02, 0.1081}},
                 .twist = {.velocity_mps = {7, 0, 0}, .angular_velocity_radps = {0, 60, 0}}}});
  const RecordedRun run = testing::recorded(scene, 2);
  ASSERT_EQ(run.error, "");
  int fallen = 0;
  for (std::uint32_t pin = 0; pin < 10; ++pin)
    fallen += run.recording.segments({pin}).size() > 1 ? 1 : 0;
  EXPECT_GT(fallen, 5);

  Scene vault = arch(15, 0.14, 0.7);
  vault.controls.push_back(
      {.tick = Tick{} + ticks_after(0.5), .body = {3}, .velocity_change_mps = {0, 4, 0}});
  const RecordedRun falls = testing::recorded(vault, 3);
  ASSERT_EQ(falls.error, "");
  for (std::uint32_t stone = 4; stone < 12; ++stone) {
    const Segment& last = falls.recording.segments({stone}).back().segment;
    EXPECT_LT(testing::place_at(last, falls.recording.end()).z(), 0.5) << stone;
  }
}

TEST(AtRest, WhatToppledIsNotHeldByEdgesThatAreParallel) {
  // Goal: parallel edges of stacked cubes never count as crossing edges. Yaw and rounding errors
  // don't matter. Method: for up to 8,000 yaws, stack two cubes of equal yaw. The upper cube's
  // centre is 1 mm outside or 1 mm inside the lower cube's edge. If rounding made parallel edges
  // cross, some of the outer cubes would be supported.
  random::Stream stream = scenes::stream_of_scene(2, 0);
  for (std::uint64_t i = 0; i < property::of_tier(500, 8000); ++i) {
    const double yaw_rad = scenes::between(stream, 0, 2 * pi);
    for (const double beyond_m : {0.001, -0.001}) {
      Scene scene = floor_scene(0.1, 0.5);
      const Quat turn = math::quaternion_of_rotation_vector({0, 0, yaw_rad});
      const Vec3 aside_m = math::rotated(turn, Vec3(0.05 + beyond_m, 0, 0));
      scene.bodies.push_back(turned_cube_at("lower", {0, 0, 0.05}, yaw_rad));
      scene.bodies.push_back(turned_cube_at("upper", aside_m + Vec3(0, 0, 0.15), yaw_rad));
      EXPECT_EQ(refusal_of(scene).empty(), beyond_m < 0) << yaw_rad << " " << refusal_of(scene);
    }
  }
}

TEST(AtRest, ReplaysAreTheSame) {
  // Goal: a history changes no result of a scene that starts at rest. Method: record the histories
  // of two scenes: a ball that rolls into pins, and a ball that hits a wall. Move the ball's start
  // or a pin. Then compare a run that uses the history with a run without a history.
  const auto differ_in_the_ball = [](const Scene& one, const Vec3& aside_m) {
    Scene other = one;
    other.bodies.back().start.pose.position_m += aside_m;
    const testing::RunResult first = testing::run(one, 0.3);
    EXPECT_EQ(testing::run(other, 0.3, first.history).digest, testing::run(other, 0.3).digest)
        << aside_m.transpose();
  };
  for (const Vec3& aside_m : {Vec3(0.05, 0, 0), Vec3(0, -0.2, 0), Vec3(3, 0, 0)})
    differ_in_the_ball(scenes::wall(12, 1).scene, aside_m);

  Scene scene = pins();
  scene.bodies.push_back({.name = "ball",
                          .shape = Sphere{.radius_m = 0.108},
                          .inertia = solid_ball_inertia(6.8, 0.108),
                          .start = {.pose = {.position_m = {-0.6, 0.02, 0.1081}},
                                    .twist = {.velocity_mps = {5, 0, 0}}}});
  constexpr double k_run_s = 0.3;
  const testing::RunResult first = testing::run(scene, k_run_s);
  for (const double y_m : {0.1, -0.3, 1.0}) {
    Scene other = scene;
    other.bodies.back().start.pose.position_m.y() = y_m;
    EXPECT_EQ(testing::run(other, k_run_s, first.history).digest,
              testing::run(other, k_run_s).digest)
        << y_m;
    other.bodies[9].start.pose.position_m.x() += 0.01;
    EXPECT_EQ(testing::run(other, k_run_s, first.history).digest,
              testing::run(other, k_run_s).digest)
        << y_m;
  }
}

}  // namespace sleight::physics::at_rest_test
