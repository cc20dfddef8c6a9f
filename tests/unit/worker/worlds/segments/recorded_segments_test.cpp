#include "worker/worlds/segments/recorded_segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "common/motion/path.h"
#include "common/random/stream.h"
#include "worker/physics/shape/round_solids.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::worlds {
namespace {

using math::Quat;
using math::Vec3;
using physics::Tick;

constexpr double k_end_s = 2;
const Vec3 k_domino_m{0.008, 0.024, 0.048};
const FixedFeature k_floor = [](std::uint32_t, std::uint32_t) { return 1; };

struct Thrown {
  physics::Compound compound;
  physics::Inertia inertia;
  physics::Pose frame{};
  Vec3 spin_radps;
};

/// Drops a body onto a floor.
physics::Recording recording_of(const Thrown& thrown) {
  physics::Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.contacts = physics::ContactTable(1, {.restitution = 0.6, .friction = 0.2});
  scene.slow = physics::coarse_slow_contacts_of(0.02, 9.81);
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  scene.bodies.push_back({.name = "body",
                          .shape = std::make_shared<const physics::Compound>(thrown.compound),
                          .inertia = thrown.inertia,
                          .start = {.pose = {.position_m = {0, 0, 1}},
                                    .twist = {.velocity_mps = {0.3, 0, 3},
                                              .angular_velocity_radps = thrown.spin_radps}}});
  auto started = physics::Simulation::start(scene, {});
  CHECK(started.ok());
  physics::Simulation simulation = std::move(started).value();
  CHECK(!simulation.run_until(Tick{} + physics::ticks_after(k_end_s)));
  return simulation.recording();
}

Thrown box_of(const Vec3& sides_m, physics::InertiaSymmetry symmetry, const Vec3& spin_radps) {
  const auto box = physics::box(sides_m);
  const auto shape = physics::in_body_frame({&box.value(), 1}, 1200, symmetry).value();
  return {.compound = {.parts = shape.parts}, .inertia = shape.inertia, .spin_radps = spin_radps};
}

Thrown round(const physics::RoundSolid& solid, const Vec3& spin_radps) {
  return {.compound = {.parts = {}, .round_parts = solid.parts},
          .inertia = solid.inertia,
          .spin_radps = spin_radps};
}

double angle_rad(const Quat& a, const Quat& b) {
  const Quat turn = math::composed(a, math::inverse(b));
  return 2 * math::norm(Vec3(turn.x(), turn.y(), turn.z()));
}

/// Compares the motion of a thrown body with the recording at random times. Returns by how many
/// segments it is longer than the recording.
std::size_t expect_simulators_motion(const Thrown& thrown) {
  const physics::Recording recording = recording_of(thrown);
  const double reach_m = thrown.compound.r_outer_m();
  const RecordedBody body{.frame = thrown.frame, .inertia = thrown.inertia, .reach_m = reach_m};
  const auto segments = recorded_segments(recording, {&body, 1}, k_floor);
  const auto motion = motion::Animation::of(segments, 1);
  EXPECT_TRUE(motion.ok());
  random::Stream stream({.seed = 5, .purpose = random::Purpose::prior}, 0);
  double off_rad = 0;
  double off_m = 0;
  for (int i = 0; i < 1000; ++i) {
    const Tick tick = Tick{} + physics::ticks_before(stream.uniform() * k_end_s);
    const physics::Segment& simulated = *recording.segment_at({0}, tick);
    const Quat turn = physics::orientation_of(simulated, thrown.inertia, tick);
    const Vec3 place_m =
        physics::position_at(simulated.flight, tick) + math::rotated(turn, thrown.frame.position_m);
    const auto shown = *motion.value().path(0).pose_at(physics::seconds(tick - Tick{}));
    off_rad = std::max(
        off_rad, angle_rad(shown.orientation, math::composed(turn, thrown.frame.orientation)));
    off_m = std::max(off_m, math::norm(Vec3(shown.centre_m - place_m)));
  }
  EXPECT_LE(off_rad, k_turn_off_rad);
  EXPECT_LE(off_m, k_place_off * reach_m);
  const auto hits = std::ranges::count(segments, motion::Cause::hit, &motion::Segment::cause);
  const auto recorded_hits =
      std::ranges::count_if(recording.segments({0}), [](const physics::Recording::Entry& entry) {
        return entry.cause.kind == physics::EventKind::collision;
      });
  EXPECT_EQ(hits, recorded_hits);
  EXPECT_GT(hits, 0);
  std::printf("%zu pieces of %zu segments, off by %.2g rad, %.2g reaches\n", segments.size(),
              recording.segment_count(), off_rad, off_m / reach_m);
  return segments.size() - recording.segment_count();
}

TEST(RecordedSegments, FollowTheSimulatorsMotion) {
  // Goal: at any time, an archived motion is the simulator's, and it has few pieces. Method: throw
  // bodies whose motion must be cut: a domino that flips about its intermediate axis, a symmetric
  // top, a pin that is shown from its foot, and a cube that is shown from a corner. Compare poses
  // at 1,000 random times. Limits of pieces are a third above the present numbers.
  EXPECT_LT(expect_simulators_motion(
                box_of(k_domino_m, physics::InertiaSymmetry::general, {0.1, 20, 0.1})),
            260);
  const auto top = physics::cylinder(0.02, 0.01, 0.001, 1000).value();
  EXPECT_LT(expect_simulators_motion(round(top, {12, 0, 20})), 155);
  const physics::RoundSolid solid = physics::bowling_pin(1.5).value();
  Thrown pin = round(solid, {3, 8, 1});
  pin.frame = {.position_m = {0, 0, -solid.foot_m},
               .orientation = math::quaternion_of_rotation_vector({0, 0, 1})};
  EXPECT_LT(expect_simulators_motion(pin), 50);
  Thrown corner = box_of({0.016, 0.016, 0.016}, physics::InertiaSymmetry::spherical, {5, 3, 1});
  corner.frame.position_m = {0.008, 0.008, 0.008};
  EXPECT_LT(expect_simulators_motion(corner), 660);
}

TEST(RecordedSegments, AreNotCutWithoutNeed) {
  // Goal: a steady motion has one segment per recorded segment, however far the body turns. Method:
  // let bodies spin about principal axes, and a cube about any axis.
  const Quat start = math::quaternion_of_rotation_vector({0, 0, 0.5});
  const auto top = physics::cylinder(0.02, 0.01, 0.001, 1000).value();
  for (const Thrown& thrown :
       {box_of({0.016, 0.016, 0.016}, physics::InertiaSymmetry::spherical, {50, 30, 10}),
        round(top, {0, 0, 100}), round(top, {100, 0, 0}),
        box_of(k_domino_m, physics::InertiaSymmetry::general, {100, 0, 0})}) {
    physics::Segment simulated;
    simulated.flight.velocity_mps = {1, 2, 3};
    simulated.flight.orientation = start;
    simulated.flight.angular_velocity_radps = math::rotated(start, thrown.spin_radps);
    physics::Recording recording;
    recording.reset(1, 1);
    recording.append({0}, simulated, {.tick = {}, .kind = physics::EventKind::start});
    recording.end_at(Tick{} + physics::ticks_after(10));
    const RecordedBody body{.inertia = thrown.inertia};
    const auto segments = recorded_segments(recording, {&body, 1}, k_floor);
    ASSERT_EQ(segments.size(), 1U);
    EXPECT_LT(angle_rad(motion::orientation_at(segments[0], 10),
                        physics::orientation_of(simulated, thrown.inertia, recording.end())),
              k_turn_off_rad);
  }
}

TEST(RecordedSegments, BodiesThatDoNotMoveAreOnlyPartners) {
  // Goal: a fixed body has no segments, but a hit names its feature.
  physics::Recording recording;
  recording.reset(2, 2);
  const physics::EventKey start{.tick = {}, .kind = physics::EventKind::start};
  recording.append({0}, {}, start);
  recording.append({1}, {}, start);
  physics::Segment after;
  after.flight.begin = Tick{1000};
  recording.append({0}, after,
                   {.tick = Tick{1000}, .kind = physics::EventKind::collision, .higher = 1});
  recording.end_at(Tick{2000});
  const RecordedBody bodies[]{{.feature = 4}, {.feature = 7, .moves = false}};
  const auto segments = recorded_segments(recording, bodies, k_floor);
  ASSERT_EQ(segments.size(), 2U);
  EXPECT_EQ(segments[1].body, 4U);
  EXPECT_EQ(segments[1].cause, motion::Cause::hit);
  EXPECT_EQ(segments[1].partner, 7);
}

}  // namespace
}  // namespace sleight::worlds
