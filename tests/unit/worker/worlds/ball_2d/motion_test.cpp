#include "worker/worlds/ball_2d/motion.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "common/math/elementary.h"
#include "tests/support/property.h"
#include "tests/unit/worker/worlds/ball_2d/support.h"

namespace sleight::worlds::ball_2d {
namespace {

using testing::impact_speed;
using testing::k_degree_rad;
using testing::random_normals;
using testing::random_world;
using testing::stream_of;

constexpr std::uint64_t k_seed = 2024;

TEST(Motion, FlatTableSendsItStraightUp) {
  // Goal: without tilt the ball stays above its start and each bounce keeps the restitution's share
  // of its speed, its square of the energy. Method: flat normals, several restitutions; the time is
  // the geometric series of hops.
  for (const double restitution : {1.0, 0.70710678118654752, 0.3}) {
    WorldParameters world;
    world.restitution = restitution;
    const Motion motion = simulate_motion(world, {});
    const double speed = impact_speed(world);
    ASSERT_EQ(motion.flights.size(), 6U);
    EXPECT_EQ(motion.landing.x_m, 0);
    double time_s = speed / world.gravity_mps2;
    double energy = speed * speed / 2;
    for (std::size_t i = 1; i < 6; ++i) {
      const Flight& flight = motion.flights[i];
      energy *= restitution * restitution;
      EXPECT_EQ(flight.velocity_mps.x(), 0);
      EXPECT_GT(flight.velocity_mps.y(), 0);
      EXPECT_NEAR(flight.velocity_mps.y() * flight.velocity_mps.y() / 2, energy, 1e-14 * energy);
      EXPECT_EQ(flight.position_m, math::Vec2(0, 0));
      time_s += 2 * flight.velocity_mps.y() / world.gravity_mps2;
    }
    EXPECT_NEAR(motion.landing.time_s, time_s, 1e-14);
  }
}

TEST(Motion, OneBounceByHand) {
  // Goal: the landing after one collision. Method: the closed form. The ball falls by h, arrives at
  // u = sqrt(2 g h) and leaves a surface of tilt t with
  //   v_x = (1 + e) u sin t cos t        v_z = u ((1 + e) cos^2 t - 1),
  // hence lands at x = 4 h (1 + e) sin t cos t ((1 + e) cos^2 t - 1), or where it is when v_z <= 0.
  WorldParameters world;
  world.collisions = 1;
  for (const double e : {0.2, 0.70710678118654752, 1.0}) {
    world.restitution = e;
    const double h_m = world.drop_height_diameters * world.diameter_m;
    for (int degrees = -89; degrees <= 89; ++degrees) {
      NormalAngles normals{};
      normals[0] = degrees * k_degree_rad;
      const double sine = std::sin(normals[0]);
      const double cosine = std::cos(normals[0]);
      const double rise = (1 + e) * cosine * cosine - 1;
      const double expected_m = rise > 0 ? 4 * h_m * (1 + e) * sine * cosine * rise : 0;
      const Landing landing = simulate_landing(world, normals);
      EXPECT_NEAR(landing.x_m, expected_m, 1e-14) << degrees;
      const double fall_s = impact_speed(world) / world.gravity_mps2;
      EXPECT_NEAR(landing.time_s, fall_s * (1 + 2 * std::max(rise, 0.0)), 1e-14) << degrees;
    }
  }
}

TEST(Motion, BallThatDoesNotLeaveTheTableStays) {
  // Goal: a ball that a steep normal sends down along the table makes no hop, and meets the next
  // normal at once, in the same place. Method: a tilt of 60 degrees, then flat normals.
  WorldParameters world;
  world.restitution = 1;
  world.collisions = 3;
  NormalAngles normals{};
  normals[0] = 60 * k_degree_rad;
  const Motion motion = simulate_motion(world, normals);
  EXPECT_LT(motion.flights[1].velocity_mps.y(), 0);
  EXPECT_EQ(motion.flights[1].duration_s, 0);
  EXPECT_EQ(motion.flights[2].position_m, motion.flights[1].position_m);
  EXPECT_EQ(motion.flights[2].start_s, motion.flights[1].start_s);
  // The second, flat collision turns it up: now it hops.
  EXPECT_GT(motion.flights[2].velocity_mps.y(), 0);
  EXPECT_GT(motion.flights[2].duration_s, 0);
  EXPECT_GT(motion.landing.x_m, 0);
}

TEST(Reflected, ScalesTheNormalPartAndKeepsTheOther) {
  // Goal: the collision law. Method: random velocities, normals and restitutions; parts along the
  // normal and the tangent before and after.
  for (const std::uint64_t index : property::cases(2000)) {
    random::Stream stream = stream_of(k_seed, index);
    const double angle = 7 * (stream.uniform() - 0.5);
    const math::Vec2 normal{std::sin(angle), std::cos(angle)};
    const math::Vec2 tangent{normal.y(), -normal.x()};
    const math::Vec2 velocity{10 * (stream.uniform() - 0.5), 10 * (stream.uniform() - 0.5)};
    const double restitution = stream.uniform();
    const math::Vec2 after = reflected(velocity, normal, restitution);
    const double approach = math::dot(velocity, normal);
    EXPECT_NEAR(math::dot(after, tangent), math::dot(velocity, tangent), 1e-14);
    EXPECT_NEAR(math::dot(after, normal), approach < 0 ? -restitution * approach : approach, 1e-14);
    if (approach >= 0) {
      EXPECT_EQ(after, velocity);
    }
    EXPECT_LE(math::norm(after), math::norm(velocity) + 1e-14);
  }
}

TEST(Reflected, ATableOnlyPushes) {
  // Goal: a normal that faces away, or lies across, leaves the velocity as it is, bit for bit.
  // Method: both by hand, and a motion that meets such a normal.
  EXPECT_EQ(reflected({0.3, 2.5}, {0, 1}, 0.5), math::Vec2(0.3, 2.5));
  EXPECT_EQ(reflected({0.3, 0}, {0, 1}, 0.5), math::Vec2(0.3, 0));
  EXPECT_EQ(reflected({3, -4}, {0.8, 0.6}, 0.5), math::Vec2(3, -4));
  WorldParameters world;
  world.collisions = 2;
  NormalAngles normals{};
  normals[0] = 180 * k_degree_rad;
  const Motion motion = simulate_motion(world, normals);
  EXPECT_EQ(motion.flights[1].velocity_mps,
            math::Vec2(0, -world.gravity_mps2 * motion.flights[0].duration_s));
  EXPECT_EQ(motion.flights[1].duration_s, 0);
}

TEST(Motion, LandingIsTheMotionsLanding) {
  // Goal: both simulations are one. Method: random worlds and normals, equal bits; the number of
  // hops; hops follow one another in time and space.
  for (const std::uint64_t index : property::cases(1000)) {
    random::Stream stream = stream_of(k_seed, index);
    const WorldParameters world = random_world(stream);
    const NormalAngles normals = random_normals(world, 30 * k_degree_rad, stream);
    const Landing landing = simulate_landing(world, normals);
    const Motion motion = simulate_motion(world, normals);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(landing.x_m),
              std::bit_cast<std::uint64_t>(motion.landing.x_m));
    ASSERT_EQ(landing.time_s, motion.landing.time_s);
    ASSERT_EQ(motion.flights.size(), world.collisions + 1);
    for (std::size_t i = 0; i < motion.flights.size(); ++i) {
      const Flight& flight = motion.flights[i];
      const bool last = i + 1 == motion.flights.size();
      const double end_s = flight.start_s + flight.duration_s;
      const double end_x = flight.position_m.x() + flight.velocity_mps.x() * flight.duration_s;
      EXPECT_GE(flight.duration_s, 0);
      EXPECT_EQ(end_s, last ? landing.time_s : motion.flights[i + 1].start_s);
      EXPECT_EQ(end_x, last ? landing.x_m : motion.flights[i + 1].position_m.x());
    }
  }
}

TEST(Motion, ScalesWithDiameterAndGravity) {
  // Goal: diameter scales the picture only, gravity time only (parameters.h). Method: landings in
  // diameters and in times of fall, bit-equal for powers of four, close for other factors.
  for (const std::uint64_t index : property::cases(300)) {
    random::Stream stream = stream_of(k_seed, index);
    const WorldParameters world = random_world(stream);
    const NormalAngles normals = random_normals(world, 15 * k_degree_rad, stream);
    const Landing landing = simulate_landing(world, normals);
    for (const double factor : {4.0, 0.0625, 3.0, 1e3}) {
      const bool exact = factor == 4 || factor == 0.0625;
      WorldParameters larger = world;
      larger.diameter_m *= factor;
      const Landing far = simulate_landing(larger, normals);
      WorldParameters heavier = world;
      heavier.gravity_mps2 *= factor;
      const Landing fast = simulate_landing(heavier, normals);
      const double tolerance = exact ? 0 : 1e-11;
      const double size_m = world.diameter_m * world.drop_height_diameters;
      EXPECT_NEAR(far.x_m / factor, landing.x_m, tolerance * size_m);
      EXPECT_NEAR(far.time_s / std::sqrt(factor), landing.time_s, tolerance * landing.time_s);
      EXPECT_NEAR(fast.x_m, landing.x_m, tolerance * size_m);
      EXPECT_NEAR(fast.time_s * std::sqrt(factor), landing.time_s, tolerance * landing.time_s);
    }
  }
}

TEST(Motion, MirroredNormalsMirrorTheLanding) {
  // Goal: left and right are the same, bit for bit. Method: negated normals.
  for (const std::uint64_t index : property::cases(1000)) {
    random::Stream stream = stream_of(k_seed, index);
    const WorldParameters world = random_world(stream);
    const NormalAngles normals = random_normals(world, 40 * k_degree_rad, stream);
    NormalAngles mirrored = normals;
    for (double& angle : mirrored)
      angle = -angle;
    const Landing right = simulate_landing(world, normals);
    const Landing left = simulate_landing(world, mirrored);
    ASSERT_EQ(left.x_m, -right.x_m) << index;
    ASSERT_EQ(left.time_s, right.time_s) << index;
  }
}

TEST(Motion, IgnoresNormalsBeyondTheCollisions) {
  // Goal: only the first `collisions` entries count. Method: garbage in the others.
  WorldParameters world;
  NormalAngles normals{};
  normals[0] = 0.1;
  const Landing landing = simulate_landing(world, normals);
  normals[world.collisions] = 1;
  normals.back() = -2;
  EXPECT_EQ(simulate_landing(world, normals).x_m, landing.x_m);
  world.collisions = k_collisions_max;
  EXPECT_EQ(simulate_motion(world, normals).flights.size(), k_collisions_max + 1);
}

}  // namespace
}  // namespace sleight::worlds::ball_2d
