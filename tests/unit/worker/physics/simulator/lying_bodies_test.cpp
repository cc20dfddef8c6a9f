#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "worker/physics/scene/friction_map.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/shape/round_solids.h"

namespace sleight::physics::lying_bodies_test {

using std::numbers::pi;
using testing::floor_scene;
using testing::RecordedRun;

constexpr double k_g_mps2 = 9.81;

/// A box standing a micrometre above the floor.
BodyDescription box_at(const Vec3& sides_m, double yaw, const Twist& twist) {
  const ConvexPolyhedron polyhedron = box(sides_m).value();
  const BodyShape shape = in_body_frame({&polyhedron, 1}, 1000, InertiaSymmetry::general).value();
  return {.name = {},
          .shape = std::make_shared<const Compound>(Compound{shape.parts}),
          .inertia = shape.inertia,
          .start = {.pose = {.position_m = {0, 0, 0.5 * sides_m.z() + 1e-6},
                             .orientation =
                                 math::composed(math::quaternion_of_rotation_vector({0, 0, yaw}),
                                                shape.frame.orientation)},
                    .twist = twist}};
}

std::uint64_t events_of(const RecordedRun& run) {
  return run.counts.static_collisions + run.counts.modes + run.counts.rests;
}
const Segment& last_segment(const RecordedRun& run) {
  return run.recording.segments({0}).back().segment;
}

TEST(LyingBodies, AnyThrowIsCaughtSoon) {
  // Goal: a tumbling box bounces until it lies flat, then slides in pieces of motion and comes to
  // rest. Method: throw boxes with different velocities and spins. Each box must rest after fewer
  // than 1000 events.
  for (int i = 0; i < 20; ++i) {
    Scene scene = floor_scene(0.1, {.restitution = 0.4, .friction = 0.3});
    scene.bodies.push_back(box_at(
        {0.1, 0.08, 0.05}, 0.1 * i,
        {.velocity_mps = {1.5, 0.2 * i, 0}, .angular_velocity_radps = {0.5 * i, 3, -0.7 * i}}));
    scene.bodies[0].start.pose.position_m.z() += 0.1;
    const RecordedRun run = testing::recorded(scene, 4);
    ASSERT_EQ(run.error, "");
    EXPECT_EQ(last_segment(run).mode, MotionMode::resting) << i;
    EXPECT_GT(run.counts.modes, 0U) << i;
    EXPECT_LT(events_of(run), 1000U) << i;
  }
}

TEST(LyingBodies, AWallEndsAStay) {
  // Goal: a collision with a wall ends a body's lasting contact with the floor. Method: let a cube
  // slide into a wall.
  Scene scene = floor_scene(0.1, {.restitution = 0.5, .friction = 0.1});
  scene.planes.push_back({.name = "wall", .outside = {.normal = {-1, 0, 0}, .offset_m = -0.5}});
  scene.bodies.push_back(box_at({0.1, 0.1, 0.1}, 0, {.velocity_mps = {2, 0, 0}}));
  const RecordedRun run = testing::recorded(scene, 3);
  ASSERT_EQ(run.error, "");
  EXPECT_EQ(last_segment(run).mode, MotionMode::resting);
  EXPECT_LT(last_segment(run).flight.position_m.x(), 0.4);
  for (const auto& [segment, cause] : run.recording.segments({0}))
    EXPECT_LT(segment.flight.position_m.x(), 0.45 + 1e-6);
}

TEST(LyingBodies, ABoxSlidesOverATablesEdge) {
  // Goal: up to the edge, a box slides on a static block's face as on a plane. The box stays if its
  // centre stays on the block, and falls otherwise. Method: throw two boxes so slowly that they
  // stop before the edge. Throw a third box so fast that it slides over the edge.
  for (const double way_m : {0.3, 0.45, 0.6}) {
    Scene scene = floor_scene(0.1, {.restitution = 0.3, .friction = 0.3});
    scene.convexes.push_back({.name = "table",
                              .polyhedron = std::make_shared<const ConvexPolyhedron>(
                                  convex_hull(std::vector<Vec3>{{-0.5, -0.5, 0},
                                                                {0.5, -0.5, 0},
                                                                {-0.5, 0.5, 0},
                                                                {0.5, 0.5, 0},
                                                                {-0.5, -0.5, 0.3},
                                                                {0.5, -0.5, 0.3},
                                                                {-0.5, 0.5, 0.3},
                                                                {0.5, 0.5, 0.3}})
                                      .value())});
    BodyDescription box = box_at({0.1, 0.1, 0.04}, 0.2,
                                 {.velocity_mps = {std::sqrt(2 * 0.3 * k_g_mps2 * way_m), 0, 0}});
    box.start.pose.position_m += Vec3(0, 0, 0.3);
    scene.bodies.push_back(box);
    const RecordedRun run = testing::recorded(scene, 3);
    ASSERT_EQ(run.error, "");
    EXPECT_EQ(last_segment(run).mode, MotionMode::resting) << way_m;
    const Vec3 end_m = last_segment(run).flight.position_m;
    EXPECT_EQ(end_m.z() > 0.3, way_m < 0.5) << way_m;
    // At the table's border the box bounces. The bounces add some friction.
    if (way_m > 0.5) continue;
    EXPECT_NEAR(end_m.x(), way_m, way_m < 0.4 ? 2e-3 : 2e-2);
    EXPECT_TRUE(way_m > 0.4 || events_of(run) <= 50) << events_of(run);
  }
}

TEST(LyingBodies, FrictionOfAMapBrakesFromItsBorderOn) {
  // Goal: each support of a sliding plank has the friction of its own place. Method: let a plank
  // slide from ice onto rough ground. Compute the plank's stop from the work of friction, and
  // compare. The front and the back each carry half of the weight.
  FrictionRectangle rough{
      .u_min_m = 1, .u_max_m = 100, .v_min_m = -10, .v_max_m = 10, .friction = 0.5};
  Scene scene = floor_scene(0.1, {.restitution = 0.3, .friction = 0});
  scene.planes[0].friction_map =
      std::make_shared<const FrictionMap>(FrictionMap::make({}, {rough}).value());
  // The height is almost zero, so the front and the back carry equal loads.
  scene.bodies.push_back(box_at({0.4, 0.1, 0.002}, 0, {.velocity_mps = {1.5, 0, 0}}));
  const RecordedRun run = testing::recorded(scene, 3);
  ASSERT_EQ(run.error, "");
  ASSERT_EQ(last_segment(run).mode, MotionMode::resting);
  // The rough ground carries half of the weight from 0.8 m on, and all of it from 1.2 m on.
  const double mu_g = 0.5 * k_g_mps2;
  const double left = 1.5 * 1.5 - 2 * (0.5 * mu_g) * 0.4;
  EXPECT_NEAR(last_segment(run).flight.position_m.x(), 1.2 + left / (2 * mu_g), 2e-3);
  EXPECT_LT(events_of(run), 50U);
}

TEST(LyingBodies, APinRollsInItsCircle) {
  // Goal: a lying bowling pin rolls in a circle, like a cone whose axis rises by 7.3 degrees. At
  // 0.4 m/s, the pin loses no energy and has fewer than 100 segments a second. Method: start a pin
  // that rolls, with its axis level. Test the circle's radius and the speed.
  Scene scene = floor_scene(0.12, {.restitution = 0.3, .friction = 0.5});
  const RoundSolid pin = bowling_pin(1.55).value();
  scene.bodies.push_back(
      {.name = "pin",
       .shape = std::make_shared<const Compound>(Compound{.parts = {}, .round_parts = pin.parts}),
       .inertia = pin.inertia,
       .start = {.pose = {.position_m = {0, 0, 0.064},
                          .orientation = math::quaternion_of_rotation_vector({-pi / 2, 0, 0})},
                 .twist = {.velocity_mps = {0.41, 0, 0},
                           .angular_velocity_radps = {0, 0.41 / 0.06, 0}}}});
  const RecordedRun run = testing::recorded(scene, 5);
  ASSERT_EQ(run.error, "");
  const auto at = [&](double span_s) -> const Segment& {
    return *run.recording.segment_at({0}, Tick{} + ticks_after(span_s));
  };
  ASSERT_EQ(at(1).mode, MotionMode::rolling);
  ASSERT_EQ(at(5).mode, MotionMode::rolling);
  std::size_t segments = 0;
  for (const auto& [segment, cause] : run.recording.segments({0})) {
    const double begin_s = seconds(segment.flight.begin - Tick{});
    if (begin_s > 1 && begin_s <= 2) ++segments;
  }
  EXPECT_LT(segments, 100U);
  const FreeFlight& early = at(1).flight;
  const FreeFlight& late = at(5).flight;
  EXPECT_NEAR(early.position_m.z(), late.position_m.z(), 1e-9);
  const double speed_mps = math::norm(early.velocity_mps);
  EXPECT_NEAR(speed_mps, 0.4, 0.03);
  EXPECT_NEAR(math::norm(late.velocity_mps) / speed_mps, 1, 1e-6);
  const Vec3 axis = math::rotated(late.orientation, Vec3::UnitZ());
  EXPECT_NEAR(std::asin(std::fabs(axis.z())) * 180 / pi, 7.3, 0.1);
  // The axis meets the plane at the circle's middle. The circle's radius is the distance from this
  // middle to the point below the body's centre.
  const double rise = std::asin(std::fabs(axis.z()));
  const double radius_m = late.position_m.z() / std::tan(rise);
  const double angle = speed_mps / radius_m * seconds(late.begin - early.begin);
  const double chord_m = math::norm(late.position_m - early.position_m);
  EXPECT_NEAR(chord_m, 2 * radius_m * std::fabs(std::sin(0.5 * angle)), 2e-3 * radius_m);
}

TEST(LyingBodies, ACylinderRollsWithoutBounces) {
  // Goal: a lying cylinder rolls for 5 seconds with fewer than 10 events, instead of bouncing 3,300
  // times a second.
  Scene scene = floor_scene(0.08, {.restitution = 0.3, .friction = 0.3});
  const RoundSolid solid = cylinder(0.04, 0.1, 0.001, 1000).value();
  scene.bodies.push_back(
      {.name = "cylinder",
       .shape = std::make_shared<const Compound>(Compound{.parts = {}, .round_parts = solid.parts}),
       .inertia = solid.inertia,
       .start = {.pose = {.position_m = {0, 0, 0.04 + 1e-6},
                          .orientation = math::quaternion_of_rotation_vector({-pi / 2, 0, 0})},
                 .twist = {.velocity_mps = {1.5, 0, 0}}}});
  const RecordedRun run = testing::recorded(scene, 5);
  ASSERT_EQ(run.error, "");
  EXPECT_LT(events_of(run), 10U);
  EXPECT_NEAR(last_segment(run).flight.velocity_mps.x(), 1, 1e-3);
}

}  // namespace sleight::physics::lying_bodies_test
