// Tests the motion of bodies on planes. The references are closed forms and a slab on springs. Also
// tests that the bodies gain no energy.
#include "worker/physics/response/plane_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/response/reference.h"

namespace sleight::physics {
namespace {

using std::numbers::pi;

constexpr double k_g_mps2 = 9.81;
const Vec3 k_gravity(0, 0, -k_g_mps2);

/// A box on the plane z = 0, given by its half sides and turned about z.
struct Box {
  Vec3 half_m;
  double mass_kg = 1;
  std::vector<PlaneSupport> supports{};
  Mat3 inertia = Mat3::Zero();

  Box(const Vec3& half, double friction, double yaw = 0) : half_m(half) {
    const Quat turn = math::quaternion_of_rotation_vector({0, 0, yaw});
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0})
        supports.push_back(
            {math::rotated(turn, Vec3(x * half.x(), y * half.y(), -half.z())), friction});
    }
    const auto moment = [&](double a, double b) { return mass_kg * (a * a + b * b) / 3; };
    inertia = inertia_in_world(
        {moment(half.y(), half.z()), moment(half.x(), half.z()), moment(half.x(), half.y())}, turn);
  }
  BodyOnPlane on_plane() const {
    return {.mass_kg = mass_kg,
            .inertia_kgm2 = inertia,
            .normal = {0, 0, 1},
            .supports = supports,
            .stick_mps = 1e-4};
  }
};

Vec3 on_slope(double angle) {
  return k_g_mps2 * Vec3(std::sin(angle), 0, -std::cos(angle));
}

TEST(PlaneMotion, ABoxSlidesInOneStraightPiece) {
  // Goal: friction decelerates a sliding box by mu g. The box's yaw doesn't matter. On a slope, the
  // box has the acceleration g (sin - mu cos).
  for (const double yaw : {0.0, 0.4, pi / 4}) {
    const Box box({0.05, 0.03, 0.02}, 0.3, yaw);
    const PlaneMotion thrown =
        plane_motion(box.on_plane(), {.velocity_mps = {0.6, 0.8, 0.001}}, k_gravity);
    ASSERT_TRUE(thrown.carried);
    EXPECT_NEAR(thrown.acceleration_mps2.x(), -0.3 * k_g_mps2 * 0.6, 1e-12);
    EXPECT_NEAR(thrown.acceleration_mps2.y(), -0.3 * k_g_mps2 * 0.8, 1e-12);
    EXPECT_EQ(thrown.start.velocity_mps.z(), 0);
    EXPECT_TRUE(is_zero(thrown.angular_acceleration_radps2));
    EXPECT_NEAR(thrown.lasts_s, 1 / (0.3 * k_g_mps2), 1e-9);
    const PlaneMotion slides = plane_motion(box.on_plane(), {}, on_slope(0.4));
    ASSERT_TRUE(slides.carried);
    EXPECT_FALSE(slides.stands);
    EXPECT_NEAR(slides.acceleration_mps2.x(), k_g_mps2 * (std::sin(0.4) - 0.3 * std::cos(0.4)),
                1e-12);
    EXPECT_GT(slides.lasts_s, 1e6);
  }
}

TEST(PlaneMotion, ABoxStandsUpToTheAngleOfFrictionAndTopplesBeyondItsEdge) {
  // Goal: a box on a slope stands if tan <= mu and tan < b / h. The box slides if only the first
  // condition fails and topples if the second fails. Method: test slopes slightly below and
  // slightly above each limit.
  const auto at = [](double half, double friction, double angle) {
    const Box box({half, half, 0.05}, friction);
    return plane_motion(box.on_plane(), {}, on_slope(angle));
  };
  EXPECT_TRUE(at(0.05, 0.3, std::atan(0.3) - 1e-6).stands);
  EXPECT_TRUE(at(0.05, 0.3, std::atan(0.3) + 1e-6).carried);
  EXPECT_FALSE(at(0.05, 0.3, std::atan(0.3) + 1e-6).stands);
  EXPECT_TRUE(at(0.01, 0.5, std::atan(0.2) - 1e-6).stands);
  EXPECT_FALSE(at(0.01, 0.5, std::atan(0.2) + 1e-6).carried);
  // A sliding box topples if mu > b / h, because only friction holds it.
  const Box tall({0.01, 0.01, 0.05}, 0.21);
  EXPECT_FALSE(plane_motion(tall.on_plane(), {.velocity_mps = {1, 0, 0}}, k_gravity).carried);
  const Box low({0.01, 0.01, 0.05}, 0.19);
  EXPECT_TRUE(plane_motion(low.on_plane(), {.velocity_mps = {1, 0, 0}}, k_gravity).carried);
}

TEST(PlaneMotion, WhatOnlySpinsStopsInOnePiece) {
  // Goal: friction at the corners decelerates a spinning square box evenly, with the torque mu m g
  // r. Here, r is the distance of the corners from the axis.
  const Box box({0.04, 0.04, 0.02}, 0.25);
  const PlaneMotion motion =
      plane_motion(box.on_plane(), {.angular_velocity_radps = {0, 0, -30}}, k_gravity);
  ASSERT_TRUE(motion.carried);
  const double rate = 0.25 * k_g_mps2 * 0.04 * std::sqrt(2.0) / box.inertia(2, 2);
  EXPECT_NEAR(motion.angular_acceleration_radps2.z() / rate, 1, 1e-9);
  EXPECT_NEAR(motion.lasts_s, 30 / rate, 1e-6);
  EXPECT_TRUE(is_zero(motion.acceleration_mps2));
}

/// The pieces of a body's motion, until the body stands.
struct Walk {
  Vec3 place_m = Vec3::Zero();
  double yaw = 0;
  int pieces = 0;
  double stops_s = 0;
  double gained_j = 0;  ///< largest energy gain of a piece
};
Walk walked(const Vec3& half_m, double friction, Twist twist, const Vec3& gravity_mps2) {
  Walk walk;
  const auto energy = [&](const Twist& t, const Mat3& inertia) {
    const Vec3& w = t.angular_velocity_radps;
    return 0.5 *
           (math::dot(t.velocity_mps, t.velocity_mps) + math::dot(w, math::product(inertia, w)));
  };
  for (; walk.pieces < 100'000; ++walk.pieces) {
    const Box box(half_m, friction, walk.yaw);
    const PlaneMotion motion = plane_motion(box.on_plane(), twist, gravity_mps2);
    EXPECT_TRUE(motion.carried);
    EXPECT_EQ(motion.acceleration_mps2.z(), 0);
    if (!motion.carried || motion.stands) break;
    const double h = motion.lasts_s;
    const double before_j = energy(twist, box.inertia) + math::dot(-gravity_mps2, walk.place_m);
    walk.place_m += h * motion.start.velocity_mps + (0.5 * h * h) * motion.acceleration_mps2;
    walk.yaw += h * (motion.start.angular_velocity_radps.z() +
                     0.5 * h * motion.angular_acceleration_radps2.z());
    twist.velocity_mps = motion.start.velocity_mps + h * motion.acceleration_mps2;
    twist.angular_velocity_radps =
        motion.start.angular_velocity_radps + h * motion.angular_acceleration_radps2;
    const double after_j = energy(twist, box.inertia) + math::dot(-gravity_mps2, walk.place_m);
    walk.gained_j = std::max(walk.gained_j, after_j - before_j);
    walk.stops_s += h;
  }
  return walk;
}

/// Integrates the motion of a slab in small time steps. The slab is on four stiff springs with
/// dampers. Assumes no law for the loads.
Walk on_springs(const Vec3& half_m, double friction, const Twist& start) {
  constexpr double k_step_s = 2e-6;
  constexpr double k_depth_m = 1e-6;  // spring depth under the body's weight
  const double stiffness = k_g_mps2 / (4 * k_depth_m);
  const double damping = std::sqrt(stiffness);
  const Box box(half_m, friction);
  Walk walk;
  Vec3 place(0, 0, -k_depth_m);
  Vec3 velocity = start.velocity_mps;
  Vec3 tilt = Vec3::Zero();  // small tilts, and the yaw
  Vec3 spin = start.angular_velocity_radps;
  for (int step = 0; step < 1'000'000; ++step) {
    if (math::norm(velocity) + 0.05 * math::norm(spin) < 2e-3) break;
    const double c = std::cos(tilt.z());
    const double s = std::sin(tilt.z());
    Vec3 force(0, 0, -k_g_mps2);
    Vec3 torque = Vec3::Zero();
    for (const PlaneSupport& support : box.supports) {
      const Vec3& a = support.arm_m;
      const Vec3 arm(c * a.x() - s * a.y(), s * a.x() + c * a.y(), a.z());
      const double height = place.z() + tilt.x() * arm.y() - tilt.y() * arm.x();
      const Vec3 moves = velocity + math::cross(spin, arm);
      const double load = std::max(0.0, -stiffness * height - damping * moves.z());
      const Vec3 slip(moves.x(), moves.y(), 0);
      const Vec3 push(Vec3(0, 0, load) - (friction * load / (math::norm(slip) + 1e-9)) * slip);
      force += push;
      torque += math::cross(arm, push);
    }
    velocity += k_step_s * force;
    const Vec3 moments(box.inertia(0, 0), box.inertia(1, 1), box.inertia(2, 2));
    // Tilts are so small that only the box's turn about z matters here.
    const Vec3 local(c * torque.x() + s * torque.y(), -s * torque.x() + c * torque.y(), torque.z());
    const Vec3 turns(local.x() / moments.x(), local.y() / moments.y(), local.z() / moments.z());
    spin +=
        k_step_s * Vec3(c * turns.x() - s * turns.y(), s * turns.x() + c * turns.y(), turns.z());
    place += k_step_s * velocity;
    tilt += k_step_s * spin;
    walk.stops_s += k_step_s;
  }
  walk.place_m = place;
  walk.yaw = tilt.z();
  return walk;
}

TEST(PlaneMotion, ASpinningSlabGoesWhereOneOnSpringsGoes) {
  // Goal: the motion of a spinning slab is right even while slips turn and loads shift. Method:
  // compare with a slab on four stiff springs. The reference slab's motion is integrated in steps
  // of 2 microseconds. Places must agree to 1% of the distance, and rotations to 0.02 rad.
  const Vec3 half_m(0.06, 0.04, 0.02);
  for (const double spin : {5.0, -20.0}) {
    const Twist start{.velocity_mps = {0.8, 0.3, 0}, .angular_velocity_radps = {0, 0, spin}};
    const Walk pieces = walked(half_m, 0.3, start, k_gravity);
    const Walk springs = on_springs(half_m, 0.3, start);
    const double way_m = math::norm(springs.place_m);
    EXPECT_LT(math::norm(Vec3(pieces.place_m.x() - springs.place_m.x(),
                              pieces.place_m.y() - springs.place_m.y(), 0)),
              0.01 * way_m)
        << spin;
    EXPECT_NEAR(pieces.yaw, springs.yaw, 0.02) << spin;
    EXPECT_NEAR(pieces.stops_s, springs.stops_s, 0.01) << spin;
    EXPECT_LT(pieces.pieces, 400) << spin;
  }
}

TEST(PlaneMotion, NoPieceGainsEnergy) {
  // Goal: no piece of motion gains energy (plane_motion.h, invariant 1), and every motion ends.
  // Method: follow random boxes piece by piece. Friction, slope and velocity are random.
  int walks = 0;
  for (const std::uint64_t seed : property::cases(property::long_run() ? 20'000 : 300)) {
    response_reference::Dice dice(seed);
    const auto uniform = [&](double low, double high) { return dice.uniform(low, high); };
    const double friction = uniform(0.05, 0.8);
    const Vec3 half_m(uniform(0.03, 0.1), uniform(0.03, 0.1), uniform(0.005, 0.03));
    const double slope = seed % 2 == 0 ? 0 : uniform(0, 0.9) * std::atan(friction);
    const Twist twist{.velocity_mps = {uniform(-1, 1), uniform(-1, 1), 0},
                      .angular_velocity_radps = {0, 0, uniform(-30, 30)}};
    const Walk walk = walked(half_m, friction, twist, on_slope(slope));
    ASSERT_LT(walk.pieces, 20'000) << seed;
    ASSERT_LT(walk.gained_j, 1e-12) << seed;
    ++walks;
  }
  EXPECT_GT(walks, 0);
}

// ---- bodies of revolution -----------------------------------------------------------------------

/// Outline of a solid cone that lies on its side on the plane. The cone's centre is above the
/// origin.
struct LyingCone {
  double half_angle;
  double depth_m;  ///< of the plane below the centre
  std::vector<PlaneSupport> supports;
  BodyOnPlane body(const Mat3& inertia, double rise) const {
    return {.mass_kg = 1,
            .inertia_kgm2 = inertia,
            .normal = {0, 0, 1},
            .supports = supports,
            .axis = {std::cos(rise), 0, std::sin(rise)},
            .stick_mps = 1e-5};
  }
};

TEST(PlaneMotion, AConeRollsInItsCircle) {
  // Goal: if a cone lies on its side and its axis is at the angle a to the plane, the cone rolls in
  // a circle at the rate w tan a. The circle's centre is the point where the axis meets the plane.
  // Above a certain speed, the inner support lifts. Method: compare the motion with the closed form
  // of the circle. A balance of torques gives the speed at which the inner support lifts. Compare
  // this speed too.
  const double rise = 0.127;
  const double depth_m = 0.06;
  const LyingCone cone{rise, depth_m, {{{-0.05, 0, -depth_m}, 0.5}, {{0.15, 0, -depth_m}, 0.5}}};
  const Quat turn = math::quaternion_of_rotation_vector({0, pi / 2 - rise, 0});
  const Mat3 inertia = inertia_in_world({0.0131 / 1.55, 0.0131 / 1.55, 0.00193 / 1.55}, turn);
  for (const double rate : {6.0, -6.0}) {
    const Twist twist{.velocity_mps = {0, -rate * depth_m, 0},
                      .angular_velocity_radps = {rate, 0, 0}};
    const PlaneMotion motion = plane_motion(cone.body(inertia, rise), twist, k_gravity);
    ASSERT_TRUE(motion.carried);
    EXPECT_EQ(motion.mode, MotionMode::rolling);
    EXPECT_NEAR(math::norm(motion.start.velocity_mps), std::fabs(rate) * depth_m, 1e-15);
    const double turns_radps = rate * std::tan(rise);
    // Mean of the centripetal acceleration over a 32nd of a radian.
    EXPECT_NEAR(math::norm(motion.acceleration_mps2), std::fabs(turns_radps) * 6 * depth_m, 1e-3);
    EXPECT_NEAR(motion.lasts_s * std::fabs(turns_radps), 1.0 / 32, 1e-5);
    // The acceleration points towards the point where the axis meets the plane.
    EXPECT_LT(motion.acceleration_mps2.x(), 0);
  }
  // At the limit, the outer support carries the whole weight. Only the weight, the path's
  // acceleration and the gyration cause torques about this support.
  const double moment = math::dot(Vec3::UnitX(), math::product(inertia, Vec3::UnitX()));
  const double per_rate2 = std::tan(rise) * (moment + depth_m * depth_m);
  const double limit = std::sqrt(k_g_mps2 * 0.15 / per_rate2);
  for (const double share : {0.99, 1.01}) {
    const double rate = share * limit;
    LyingCone gripping = cone;
    for (PlaneSupport& support : gripping.supports)
      support.friction = 10;
    const PlaneMotion motion = plane_motion(
        gripping.body(inertia, rise),
        {.velocity_mps = {0, -rate * depth_m, 0}, .angular_velocity_radps = {rate, 0, 0}},
        k_gravity);
    EXPECT_EQ(motion.carried, share < 1) << share;
  }
}

TEST(PlaneMotion, ACylinderSlidesThenRolls) {
  // Goal: the slip of a thrown cylinder decreases at the rate mu g (1 + 1/k) until the cylinder
  // rolls. On a slope, the cylinder rolls with the acceleration g sin / (1 + k).
  const double radius_m = 0.04;
  const LyingCone lying{0, radius_m, {{{-0.05, 0, -radius_m}, 0.3}, {{0.05, 0, -radius_m}, 0.3}}};
  const Mat3 inertia = inertia_in_world({0.002, 0.002, 0.5 * radius_m * radius_m},
                                        math::quaternion_of_rotation_vector({0, pi / 2, 0}));
  const PlaneMotion thrown =
      plane_motion(lying.body(inertia, 0), {.velocity_mps = {0, 1.5, 0}}, k_gravity);
  ASSERT_TRUE(thrown.carried);
  EXPECT_EQ(thrown.mode, MotionMode::sliding);
  EXPECT_NEAR(thrown.acceleration_mps2.y(), -0.3 * k_g_mps2, 1e-12);
  EXPECT_NEAR(thrown.lasts_s, 1.5 / (0.3 * k_g_mps2 * 3), 1e-9);
  const Vec3 down = k_g_mps2 * Vec3(0, std::sin(0.1), -std::cos(0.1));
  const PlaneMotion rolls = plane_motion(lying.body(inertia, 0), {}, down);
  ASSERT_TRUE(rolls.carried);
  EXPECT_EQ(rolls.mode, MotionMode::rolling);
  EXPECT_NEAR(rolls.acceleration_mps2.y(), k_g_mps2 * std::sin(0.1) / 1.5, 1e-12);
  EXPECT_NEAR(rolls.angular_acceleration_radps2.x() * radius_m, -rolls.acceleration_mps2.y(),
              1e-12);
  // As long as the line supports the body, friction up to its limit keeps the body from moving
  // along the axis.
  const Vec3 along = k_g_mps2 * Vec3(std::sin(0.2), 0, -std::cos(0.2));
  EXPECT_TRUE(plane_motion(lying.body(inertia, 0), {}, along).carried);
  const Vec3 steep = k_g_mps2 * Vec3(std::sin(0.4), 0, -std::cos(0.4));
  EXPECT_FALSE(plane_motion(lying.body(inertia, 0), {}, steep).carried);
}

}  // namespace
}  // namespace sleight::physics
