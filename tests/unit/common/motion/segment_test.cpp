// Goal: a segment's positions, velocities and rotations follow from its initial values and
// accelerations. Method: compare with difference quotients, with sequences of small rotations, and
// with known rotations.
#include "common/motion/segment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/random/stream.h"

namespace sleight::motion {
namespace {

using math::Quat;
using math::Vec3;

Vec3 any_vector(random::Stream& stream, double size) {
  return {size * (2 * stream.uniform() - 1), size * (2 * stream.uniform() - 1),
          size * (2 * stream.uniform() - 1)};
}

Segment any_segment(random::Stream& stream) {
  return {.body = 3,
          .start_s = stream.uniform(),
          .mode = Mode::sliding,
          .position_m = any_vector(stream, 1),
          .velocity_mps = any_vector(stream, 2),
          .acceleration_mps2 = any_vector(stream, 10),
          .orientation = math::quaternion_of_rotation_vector(any_vector(stream, 3)),
          .angular_velocity_radps = any_vector(stream, 40),
          .angular_acceleration_radps2 = any_vector(stream, 200)};
}

double apart_rad(const Quat& a, const Quat& b) {
  const Quat turn = math::composed(a, math::inverse(b));
  return 2 * std::atan2(math::norm(Vec3(turn.x(), turn.y(), turn.z())), std::fabs(turn.w()));
}

TEST(Segment, MovesOnAParabola) {
  random::Stream stream({.seed = 1, .purpose = random::Purpose::scene}, 0);
  for (int i = 0; i < 100; ++i) {
    const Segment segment = any_segment(stream);
    const double t_s = segment.start_s + stream.uniform();
    constexpr double k_step_s = 1e-5;
    const Vec3 rate =
        (position_at(segment, t_s + k_step_s) - position_at(segment, t_s - k_step_s)) /
        (2 * k_step_s);
    EXPECT_LT(math::norm(Vec3(rate - velocity_at(segment, t_s))), 1e-8);
    EXPECT_EQ(position_at(segment, segment.start_s), segment.position_m);
    // bow_m() must be the distance between the path of 0.2 s and its chord.
    const Vec3 middle = 0.5 * (position_at(segment, t_s) + position_at(segment, t_s + 0.2));
    EXPECT_NEAR(math::norm(Vec3(middle - position_at(segment, t_s + 0.1))), bow_m(segment, 0.2),
                1e-12);
  }
}

TEST(Segment, TurnsByItsAngularVelocity) {
  // Goal: rotations follow the angular velocity. Method: compare with 100,000 small rotations. A
  // small rotation uses the angular velocity in the middle of its step.
  random::Stream stream({.seed = 2, .purpose = random::Purpose::scene}, 0);
  for (int i = 0; i < 20; ++i) {
    const Segment segment = any_segment(stream);
    const double duration_s = 0.3 * stream.uniform();
    Quat q = segment.orientation;
    constexpr int k_steps = 100'000;
    const double step_s = duration_s / k_steps;
    for (int step = 0; step < k_steps; ++step) {
      const Vec3 w = segment.angular_velocity_radps +
                     ((step + 0.5) * step_s) * segment.angular_acceleration_radps2;
      q = math::composed(math::quaternion_of_rotation_vector(step_s * w), q);
    }
    EXPECT_LT(apart_rad(orientation_at(segment, segment.start_s + duration_s), q), 2e-6);
  }
}

TEST(Segment, WholeTurnsComeBack) {
  Segment segment{.angular_velocity_radps = {0, 0, 2 * std::numbers::pi}};
  EXPECT_LT(apart_rad(orientation_at(segment, 3), segment.orientation), 1e-12);
  EXPECT_NEAR(apart_rad(orientation_at(segment, 0.25), segment.orientation), std::numbers::pi / 2,
              1e-12);
  segment.mode = Mode::resting;
  EXPECT_EQ(orientation_at(segment, 0.25).coeffs(), segment.orientation.coeffs());
}

}  // namespace
}  // namespace sleight::motion
