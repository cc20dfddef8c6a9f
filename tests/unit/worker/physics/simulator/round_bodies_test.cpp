#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "tests/scenes/shared/random_starts.h"
#include "tests/scenes/shared/scenes.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/distance/round_oracle.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "worker/physics/distance/round_distance.h"
#include "worker/physics/motion/invariants.h"
#include "worker/physics/shape/round_solids.h"

namespace sleight::physics {
namespace {

using std::numbers::pi;
using testing::floor_scene;
using testing::RecordedRun;

constexpr double k_g_mps2 = 9.81;
/// A rolling body follows a circle along chords of 1/32 radian. In the middle of a chord, this
/// share of the body's kinetic energy is missing.
constexpr double k_chord_share = 1.0 / (64 * 64);

BodyDescription body_of(const RoundSolid& solid, const StartState& start) {
  return {
      .name = {},
      .shape = std::make_shared<const Compound>(Compound{.parts = {}, .round_parts = solid.parts}),
      .inertia = solid.inertia,
      .start = start};
}

const Segment& segment_at(const RecordedRun& run, std::uint32_t body, Tick tick) {
  return *run.recording.segment_at({body}, tick);
}
Vec3 place_after(const RecordedRun& run, double span_s) {
  const Tick tick = Tick{} + ticks_after(span_s);
  return testing::place_at(segment_at(run, 0, tick), tick);
}

TEST(RoundBodies, APinTopplesAtTheTiltOfItsRim) {
  // Goal: a tilted bowling pin falls over if its centre of mass is beyond the rim's circle;
  // otherwise, the pin falls back onto its foot. Method: test tilts 0.1 degree below and above the
  // limit.
  const RoundSolid pin = bowling_pin(1.55).value();
  // The rim is the ring with the lowest centre.
  double circle_m = 0;
  double rim_m = 0;
  double depth_m = 0;
  for (const RoundFeature& feature : pin.parts.front().features()) {
    if (-feature.centre_m.z() < depth_m) continue;
    depth_m = -feature.centre_m.z();
    circle_m = feature.circle_m;
    rim_m = feature.radius_m;
  }
  const double balance = std::atan2(circle_m, depth_m);
  for (const double off : {-0.1, 0.1}) {
    const double tilt = balance + off * pi / 180;
    Scene scene = floor_scene(0.12, {.restitution = 0.4, .friction = 0.5});
    // Height of the centre above the lowest point of the rim's circle.
    const double height_m = depth_m * std::cos(tilt) + circle_m * std::sin(tilt) + rim_m + 1e-6;
    scene.bodies.push_back(
        body_of(pin, {.pose = {.position_m = {0, 0, height_m},
                               .orientation = math::quaternion_of_rotation_vector({0, tilt, 0})},
                      .twist = {}}));
    const RecordedRun run = testing::recorded(scene, 4);
    ASSERT_EQ(run.error, "");
    EXPECT_EQ(place_after(run, 4).z() < 0.1, off > 0) << "tilt " << tilt * 180 / pi;
  }
}

TEST(RoundBodies, FlatOnesStayAndComeToRest) {
  // Goal: a cylinder on its end, a coin on its face, a rounded box and a bowling pin come to rest
  // where they stand. Method: drop the bodies from a tenth of a millimetre above the floor.
  const RoundSolid solids[] = {
      cylinder(0.03, 0.08, 0.001, 1000).value(), coin(0.012, 0.002, 8000).value(),
      rounded_box({0.05, 0.04, 0.03}, 0.003, 1000).value(), bowling_pin(1.55).value()};
  for (const RoundSolid& solid : solids) {
    Scene scene = floor_scene(2 * solid.foot_m, {.restitution = 0.4, .friction = 0.5});
    scene.bodies.push_back(
        body_of(solid, {.pose = {.position_m = {0, 0, solid.foot_m + 1e-4}}, .twist = {}}));
    const RecordedRun run = testing::recorded(scene, 3);
    ASSERT_EQ(run.error, "");
    const Segment& last = run.recording.segments({0}).back().segment;
    EXPECT_EQ(last.mode, MotionMode::resting) << solid.foot_m;
    EXPECT_NEAR(last.flight.position_m.z(), solid.foot_m, 2e-5);
  }
}

TEST(RoundBodies, KeepEnergyWithoutLoss) {
  // Goal: elastic and smooth round bodies keep their energy to 1e-9. Method: let bodies of several
  // kinds collide many times between six walls, without gravity.
  Scene scene = scenes::round_solids(12, 3).scene;
  scene.gravity_mps2 = Vec3::Zero();
  scene.slow = {};
  scene.contacts = ContactTable(1, {.restitution = 1, .friction = 0});
  scene.planes.push_back({.name = "lid", .outside = {.normal = {0, 0, -1}, .offset_m = -0.25}});
  const RecordedRun run = testing::recorded(scene, property::long_run() ? 200 : 20);
  ASSERT_EQ(run.error, "");
  const auto energy_at = [&](Tick tick) {
    double sum_j = 0;
    for (std::uint32_t body = 0; body < scene.bodies.size(); ++body) {
      const Segment& segment = segment_at(run, body, tick);
      const Inertia& inertia = scene.bodies[body].inertia;
      sum_j += kinetic_energy_j(inertia, testing::turn_at(segment, inertia, tick),
                                twist_of(segment, inertia, tick));
    }
    return sum_j;
  };
  const double first_j = energy_at(Tick{});
  const double last_j = energy_at(Tick{} + ticks_after(property::long_run() ? 200 : 20));
  EXPECT_GT(run.counts.collisions + run.counts.static_collisions, 400U);
  EXPECT_NEAR(last_j / first_j, 1, 1e-9);
}

TEST(RoundBodies, NeverGainEnergy) {
  // Goal: the energy of round bodies with friction and loss never increases, even in slow contacts.
  // Method: compare kinetic plus potential energy at regular times with the least value so far. A
  // body that rolls as a cone moves on chords. Each chord spans a 32nd of a radian. Within a chord,
  // part of the kinetic energy may be missing. This fraction is at most the square of half that
  // angle.
  for (const std::uint64_t seed :
       property::cases(property::long_run() ? 100 : property::of_tier(2, 6))) {
    const Scene scene = scenes::round_solids(10, seed + 1).scene;
    auto started = Simulation::start(scene, {});
    ASSERT_TRUE(started.ok());
    Simulation simulation = std::move(started).value();
    double least_j = 1e300;
    for (int look = 1; look <= 60; ++look) {
      const auto error = simulation.run_until(Tick{} + ticks_after(0.02 * look));
      ASSERT_FALSE(error) << error->message;
      double now_j = 0;
      double unseen_j = 0;
      for (std::uint32_t body = 0; body < scene.bodies.size(); ++body) {
        const Inertia& inertia = scene.bodies[body].inertia;
        const Pose pose = simulation.pose({body}, simulation.now());
        const double kinetic_j =
            kinetic_energy_j(inertia, pose.orientation, simulation.twist({body}, simulation.now()));
        const bool is_cone = inertia.symmetry != InertiaSymmetry::spherical;
        if (is_cone && simulation.mode({body}) == MotionMode::rolling)
          unseen_j += k_chord_share * kinetic_j;
        now_j += kinetic_j + inertia.mass_kg * k_g_mps2 * pose.position_m.z();
      }
      ASSERT_LT(now_j, least_j + 1e-12) << seed << ", look " << look;
      least_j = std::min(least_j, now_j + unseen_j);
    }
  }
}

TEST(RoundBodies, DontOverlapByMoreThanTwoMicrometres) {
  // Goal: round bodies overlap by at most two micrometres. Method: at random ticks, use
  // plain_reach_m() to compute the separation of each pair along closest_round()'s normal. Compute
  // the separation of each body from each plane in the same way.
  double deepest_m = 0;
  int near = 0;
  for (const std::uint64_t seed :
       property::cases(property::long_run() ? 100 : property::of_tier(2, 4))) {
    scenes::Setting setting = scenes::round_solids(8, seed + 11);
    const RecordedRun run = testing::recorded(setting.scene, 0.8);
    ASSERT_EQ(run.error, "");
    random::Stream stream = scenes::stream_of_scene(seed, 7);
    for (int look = 0; look < 150; ++look) {
      const Tick tick = Tick{} + ticks_after(scenes::between(stream, 0.05, 0.8));
      std::vector<PlacedPose> places;
      for (std::uint32_t body = 0; body < setting.scene.bodies.size(); ++body) {
        const Segment& segment = segment_at(run, body, tick);
        places.push_back(
            placed({testing::place_at(segment, tick),
                    testing::turn_at(segment, setting.scene.bodies[body].inertia, tick)}));
      }
      const auto compound_of = [&](std::uint32_t body) {
        const auto* shape =
            std::get_if<std::shared_ptr<const Compound>>(&setting.scene.bodies[body].shape);
        return shape != nullptr ? shape->get() : nullptr;
      };
      for (std::uint32_t a = 0; a < places.size(); ++a) {
        const Compound* first = compound_of(a);
        if (first == nullptr) continue;
        for (const StaticPlane& plane : setting.scene.planes) {
          const double gap_m =
              -testing::plain_reach_m(first->view(0), places[a], -plane.outside.normal) -
              plane.outside.offset_m;
          near += gap_m < 1e-5 ? 1 : 0;
          deepest_m = std::max(deepest_m, -gap_m);
        }
        for (std::uint32_t b = a + 1; b < places.size(); ++b) {
          const Compound* second = compound_of(b);
          if (second == nullptr) continue;
          const ConvexView of_a = first->view(0);
          const ConvexView of_b = second->view(0);
          if (of_a.round == nullptr && of_b.round == nullptr) continue;
          const Vec3 axis = closest_round(of_a, places[a], of_b, places[b]).normal;
          const double gap_m = -testing::plain_reach_m(of_a, places[a], axis) -
                               testing::plain_reach_m(of_b, places[b], -axis);
          near += gap_m < 1e-5 ? 1 : 0;
          deepest_m = std::max(deepest_m, -gap_m);
        }
      }
    }
  }
  fmt::print("deepest: {:.2e} m; {} within 10 micrometres\n", deepest_m, near);
  EXPECT_LT(deepest_m, 2e-6);
  if (property::all_cases()) {
    EXPECT_GT(near, 100);
  }
}

}  // namespace
}  // namespace sleight::physics
