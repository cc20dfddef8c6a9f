#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "worker/physics/shape/round_solids.h"

namespace sleight::physics::coulomb_stop_test {

using testing::RecordedRun;

constexpr double k_g_mps2 = 9.81;

struct Slider {
  std::string name;
  Compound shape;
  Inertia inertia;
  double height_m = 0;  ///< of the centre, when standing
};

Slider of_polyhedron(const std::string& name, const ConvexPolyhedron& polyhedron,
                     InertiaSymmetry symmetry, double height_m) {
  BodyShape body = in_body_frame({&polyhedron, 1}, 1000, symmetry).value();
  return {name, Compound{.parts = std::move(body.parts), .round_parts = {}}, body.inertia,
          height_m};
}

std::vector<Slider> sliders() {
  RoundSolid round = cylinder(0.05, 0.06, 0.001, 1000).value();
  return {of_polyhedron("cube", cube(0.1).value(), InertiaSymmetry::spherical, 0.05),
          of_polyhedron("plank", box({0.3, 0.1, 0.03}).value(), InertiaSymmetry::general, 0.015),
          of_polyhedron("standing prism of 24 sides", regular_prism(24, 0.05, 0.06).value(),
                        InertiaSymmetry::axial, 0.03),
          {"standing cylinder", Compound{.parts = {}, .round_parts = std::move(round.parts)},
           round.inertia, 0.03}};
}

/// Throws the standing body along x, turned by the yaw.
Scene thrown(const Slider& slider, double yaw, double speed_mps, const SurfaceLaw& law) {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -k_g_mps2};
  scene.contacts = ContactTable(1, law);
  scene.slow = slow_contacts_of(2 * slider.height_m, k_g_mps2);
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  scene.bodies.push_back(
      {.name = slider.name,
       .shape = std::make_shared<const Compound>(slider.shape),
       .inertia = slider.inertia,
       .start = {.pose = {.position_m = {0, 0, slider.height_m + 1e-6},
                          .orientation = math::quaternion_of_rotation_vector({0, 0, yaw})},
                 .twist = {.velocity_mps = {speed_mps, 0, 0}}}});
  return scene;
}

TEST(CoulombStop, WhatIsThrownFlatSlidesAsFarAsCoulombSays) {
  // Goal: a body that is thrown flat slides almost straight. The distance is v^2 / (2 mu g), to 2%.
  // The body's shape, yaw, friction and speed don't matter. Method: throw bodies along the floor,
  // and compare the distance at which they rest with the closed form. If every impulse were along Q
  // of response/restitution.h, bodies would slide up to 17% too far.
  for (const Slider& slider : sliders()) {
    for (const double yaw : {0.0, 0.3, std::numbers::pi / 4}) {
      for (const double friction : {0.2, 0.3}) {
        for (const double speed_mps : {0.5, 2.0}) {
          const std::string which = fmt::format("{}, yaw {:.2f}, friction {}, {} m/s", slider.name,
                                                yaw, friction, speed_mps);
          const RecordedRun run = testing::recorded(
              thrown(slider, yaw, speed_mps, {.restitution = 0.3, .friction = friction}),
              1.5 * speed_mps / (friction * k_g_mps2) + 1);
          ASSERT_EQ(run.error, "") << which;
          const Segment& last = run.recording.segments({0}).back().segment;
          ASSERT_EQ(last.mode, MotionMode::resting) << which;
          const double distance_m = speed_mps * speed_mps / (2 * friction * k_g_mps2);
          EXPECT_NEAR(last.flight.position_m.x() / distance_m, 1, 0.02) << which;
          EXPECT_LT(std::fabs(last.flight.position_m.y()), 0.02 * distance_m) << which;
        }
      }
    }
  }
}

}  // namespace sleight::physics::coulomb_stop_test
