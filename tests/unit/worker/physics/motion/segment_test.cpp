// Goal: a segment's orientation and motion are right in every mode. Method: for bodies in contact,
// compare with many small exact rotations in long double, and with the closed form for a fixed
// axis. For free and resting bodies, compare with the functions for these modes.
#include "worker/physics/motion/segment.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "common/math/elementary.h"
#include "common/random/angular_distributions.h"
#include "common/random/stream.h"
#include "tests/support/property.h"

namespace sleight::physics {
namespace {

using math::norm;
using Long4 = std::array<long double, 4>;  ///< w, x, y, z
using Long3 = std::array<long double, 3>;

random::Stream numbers(std::uint64_t test, std::uint64_t index) {
  return random::Stream({.seed = test, .purpose = random::Purpose::prior}, index);
}

double spread(random::Stream& stream, double low, double high) {
  return low * math::exp(stream.uniform() * math::log(high / low));
}

Vec3 direction(random::Stream& stream) {
  return random::UniformDirection3{}.draw(stream);
}

Segment random_segment(random::Stream& stream, double speed_max, double rate_max) {
  Segment segment;
  segment.flight = {.begin = Tick{static_cast<TickCount>(stream.bits() >> 14)},
                    .position_m = direction(stream),
                    .velocity_mps = direction(stream),
                    .acceleration_mps2 = direction(stream),
                    .orientation = math::normalized(random::UniformRotation{}.draw(stream)),
                    .angular_velocity_radps = spread(stream, 1e-2, speed_max) * direction(stream)};
  segment.angular_acceleration_radps2 = spread(stream, 1e-2, rate_max) * direction(stream);
  segment.mode = stream.bits() % 2 == 0 ? MotionMode::sliding : MotionMode::rolling;
  return segment;
}

Long3 rate_at(const Segment& segment, long double s) {
  Long3 rate{};
  for (int i = 0; i < 3; ++i) {
    rate[static_cast<std::size_t>(i)] =
        static_cast<long double>(segment.flight.angular_velocity_radps[i]) +
        s * static_cast<long double>(segment.angular_acceleration_radps2[i]);
  }
  return rate;
}

Long4 product(const Long4& p, const Long4& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
          p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
          p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

Long4 turn_by(const Long3& axis_angle) {
  const long double angle =
      std::sqrt(axis_angle[0] * axis_angle[0] + axis_angle[1] * axis_angle[1] +
                axis_angle[2] * axis_angle[2]);
  if (angle == 0) return {1, 0, 0, 0};
  const long double factor = std::sin(angle / 2) / angle;
  return {std::cos(angle / 2), factor * axis_angle[0], factor * axis_angle[1],
          factor * axis_angle[2]};
}

Long4 unit(Long4 q) {
  const long double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (long double& x : q)
    x /= size;
  return q;
}

Long4 long_of(const Quat& q) {
  return unit({q.w(), q.x(), q.y(), q.z()});
}

/// Turns the orientation in small steps. Each step turns about the rotation axis at the middle of
/// the step.
Long4 in_steps(const Segment& segment, long double s, int steps) {
  const long double h = s / steps;
  Long4 q = long_of(segment.flight.orientation);
  for (int i = 0; i < steps; ++i) {
    Long3 turn = rate_at(segment, (i + 0.5L) * h);
    for (long double& x : turn)
      x *= h;
    q = product(turn_by(turn), q);
  }
  return unit(q);
}

/// The error of in_steps() contains only even powers of the step, so results for two step counts
/// combine to fourth order.
Long4 reference(const Segment& segment, long double s, int steps) {
  const Long4 coarse = in_steps(segment, s, steps);
  Long4 fine = in_steps(segment, s, 2 * steps);
  for (std::size_t i = 0; i < 4; ++i)
    fine[i] += (fine[i] - coarse[i]) / 3;
  return unit(fine);
}

long double apart_rad(const Long4& p, const Long4& q) {
  const Long4 turn = product({p[0], -p[1], -p[2], -p[3]}, q);
  return 2 * std::sqrt(turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3]);
}

TEST(Segment, TurnsAboutAMovingAxis) {
  // Goal: orientations have the documented accuracy, 1e-6 of the angle. Method: compare balls with
  // the reference. Spins are up to 100 rad/s, accelerations up to 1000 rad/s^2, and times up to a
  // second. In some cases, repeat the reference with four times as many steps to estimate its
  // error.
  long double worst = 0;
  long double worst_reference = 0;
  int bent = 0;
  for (const std::uint64_t i : property::cases(150)) {
    if (HasFailure()) break;
    random::Stream stream = numbers(601, i);
    const Segment segment = random_segment(stream, 100, 1000);
    const TickCount span = ticks_after(spread(stream, 1e-3, 1));
    const double s = seconds(span);
    const double angle_rad = s * norm(segment.flight.angular_velocity_radps) +
                             s * s / 2 * norm(segment.angular_acceleration_radps2);
    const Long4 expected = reference(segment, s, 2000);
    const Quat q = orientation_of(segment, {}, segment.flight.begin + span);
    EXPECT_NEAR(q.norm(), 1, 1e-15);
    const long double error = apart_rad(long_of(q), expected);
    worst = std::max(worst, error / angle_rad);
    EXPECT_LE(error, 1e-6L * angle_rad + 1e-14L);
    // The axis really moves: a rotation about the mean axis would end elsewhere.
    if (apart_rad(in_steps(segment, s, 1), expected) > 1e-3) ++bent;
    if (i % 15 == 0)
      worst_reference =
          std::max(worst_reference, apart_rad(expected, reference(segment, s, 8000)) / angle_rad);
  }
  if (!property::all_cases()) return;
  std::printf("seed 601: worst %.1Le of the angle, reference's own %.1Le\n", worst,
              worst_reference);
  EXPECT_LT(worst_reference, 1e-8L);
  EXPECT_GT(bent, 30);
}

TEST(Segment, IsExactAboutAStandingAxis) {
  // Goal: rounding is the only error if the axis is fixed. Method: compare the orientation with the
  // angle w s + a s^2 / 2 in long double. One third of the bodies start from rest, and one third
  // have constant spin. The others accelerate along the spin or against it, some until the spin
  // reverses.
  long double worst = 0;
  for (const std::uint64_t i : property::cases(20'000)) {
    if (HasFailure()) break;
    random::Stream stream = numbers(602, i);
    Segment segment = random_segment(stream, 100, 1000);
    Vec3& w = segment.flight.angular_velocity_radps;
    Vec3& a = segment.angular_acceleration_radps2;
    if (i % 3 == 0) w = Vec3::Zero();
    if (i % 3 == 1) a = Vec3::Zero();
    if (i % 3 == 2) a = (20 * stream.uniform() - 10) * w;
    const TickCount span = ticks_after(spread(stream, 1e-6, 10));
    const long double s = seconds(span);
    Long3 turn = rate_at(segment, s / 2);
    for (long double& x : turn)
      x *= s;
    const Long4 expected = product(turn_by(turn), long_of(segment.flight.orientation));
    const Quat q = orientation_of(segment, {}, segment.flight.begin + span);
    const long double angle = s * (norm(w) + s / 2 * norm(a));
    const long double error = apart_rad(long_of(q), expected) / (1 + angle);
    worst = std::max(worst, error);
    EXPECT_LE(error, 2e-15L);
  }
  std::printf("seed 602: worst %.1Le of 1 + the angle\n", worst);
}

TEST(Segment, BeginsWithTheSameBits) {
  // Goal: at its first tick, a segment returns its stored values bit for bit, in every mode.
  // Method: test random segments whose orientation has norm 1 only up to rounding.
  const Inertia inertia{
      .mass_kg = 1, .principal_kgm2 = Vec3::Constant(0.4), .symmetry = InertiaSymmetry::spherical};
  for (const std::uint64_t i : property::cases(4000)) {
    if (HasFailure()) break;
    random::Stream stream = numbers(603, i);
    Segment segment = random_segment(stream, 100, 1000);
    segment.mode = static_cast<MotionMode>(i % 4);
    const FreeFlight& flight = segment.flight;
    EXPECT_EQ(orientation_of(segment, inertia, flight.begin).coeffs(), flight.orientation.coeffs());
    const Twist twist = twist_of(segment, inertia, flight.begin);
    EXPECT_EQ(twist.velocity_mps, flight.velocity_mps);
    EXPECT_EQ(twist.angular_velocity_radps, flight.angular_velocity_radps);
  }
}

TEST(Segment, TwistChangesEvenly) {
  // Goal: a body in contact has the velocity v + a s and the angular velocity w + alpha s after s
  // seconds. Free and resting bodies match the functions for these modes. Method: evaluate the
  // formulas at random ticks.
  const Inertia inertia{
      .mass_kg = 1, .principal_kgm2 = Vec3(0.3, 0.4, 0.5), .symmetry = InertiaSymmetry::general};
  for (const std::uint64_t i : property::cases(4000)) {
    if (HasFailure()) break;
    random::Stream stream = numbers(604, i);
    Segment segment = random_segment(stream, 10, 100);
    const FreeFlight& flight = segment.flight;
    const TickCount span = ticks_after(spread(stream, 1e-6, 2));
    const Tick tick = flight.begin + span;
    const Twist twist = twist_of(segment, inertia, tick);
    const Long3 w = rate_at(segment, seconds(span));
    for (int k = 0; k < 3; ++k) {
      const auto expected = static_cast<double>(w[static_cast<std::size_t>(k)]);
      EXPECT_NEAR(twist.angular_velocity_radps[k], expected,
                  1e-15 * (norm(flight.angular_velocity_radps) +
                           seconds(span) * norm(segment.angular_acceleration_radps2)));
      EXPECT_NEAR(twist.velocity_mps[k],
                  flight.velocity_mps[k] + seconds(span) * flight.acceleration_mps2[k], 1e-15);
    }
    segment.mode = MotionMode::free;
    segment.angular_acceleration_radps2 = Vec3::Zero();
    EXPECT_EQ(orientation_of(segment, inertia, tick).coeffs(),
              orientation_at(flight, inertia, tick).coeffs());
    EXPECT_EQ(twist_of(segment, inertia, tick).angular_velocity_radps,
              angular_velocity_at(flight, inertia, tick));
    segment.mode = MotionMode::resting;
    EXPECT_EQ(orientation_of(segment, inertia, tick).coeffs(), flight.orientation.coeffs());
  }
}

}  // namespace
}  // namespace sleight::physics
