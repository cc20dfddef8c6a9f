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

TEST(Motion, OneBounceByHand) {
  // Goal: after one collision, the ball lands at the right place and time. Method: compare with the
  // closed form. The ball falls by h, arrives with speed u = sqrt(2 g h), and leaves a surface of
  // tilt t with
  //   v_x = (1 + e) u sin t cos t and v_z = u ((1 + e) cos^2 t - 1).
  // The ball lands at x = 4 h (1 + e) sin t cos t ((1 + e) cos^2 t - 1) if v_z is positive.
  // Otherwise, it stays in place.
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

TEST(Reflected, ATableOnlyPushes) {
  // Goal: if a ball moves away from a surface or along it, the surface changes no bit of the ball's
  // velocity. Method: reflect such velocities. Then simulate a motion that meets a surface turned
  // by 180 degrees.
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
  // Goal: simulate_landing() and simulate_motion() return the same bits. The motion's hops follow
  // each other in time and space. Method: compare both functions for random worlds and normals.
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

}  // namespace
}  // namespace sleight::worlds::ball_2d
