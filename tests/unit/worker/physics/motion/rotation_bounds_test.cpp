// Goal: bounds on rotation hold for evaluated values with their rounding errors, and are tight
// where the header says so. Method: compare the bounds with the rotation of random bodies at dense
// and at random ticks. Compute angular accelerations from Euler's equations, not from finite
// differences.
#include "worker/physics/motion/rotation_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/motion/support.h"
#include "worker/physics/motion/invariants.h"
#include "worker/physics/motion/motion_bounds.h"

namespace sleight::physics {
namespace {

// |dw/dt| by Euler's equations.
double acceleration_of(const Inertia& inertia, const Vec3& w) {
  const Vec3& m = inertia.principal_kgm2;
  return math::norm(Vec3((m.y() - m.z()) / m.x() * w.y() * w.z(),
                         (m.z() - m.x()) / m.y() * w.z() * w.x(),
                         (m.x() - m.y()) / m.z() * w.x() * w.y()));
}

TEST(RotationBounds, hold_at_every_tick_and_are_reached) {
  double loosest_acceleration = 0;
  for (const InertiaSymmetry symmetry : k_symmetries) {
    for (const std::uint64_t i : property::cases(150)) {
      random::Stream stream = stream_of(41, i);
      const Inertia inertia = random_inertia(stream, symmetry);
      const FreeFlight flight = random_flight(stream, 10);
      const RotationBounds bounds = rotation_bounds(flight, inertia);
      RotationTrack track(flight, inertia);
      double speed = 0;
      double acceleration = 0;
      const double span_s = 20 + 400 * stream.uniform();
      for (int n = 0; n < 4'000; ++n) {
        const Tick t = flight.begin + ticks_before(span_s / 10 * n / 4'000);
        const Vec3 w =
            body_angular_velocity_radps(track.orientation_at(t), track.angular_velocity_at(t));
        speed = std::max(speed, math::norm(w));
        acceleration = std::max(acceleration, acceleration_of(inertia, w));
      }
      ASSERT_LE(speed, bounds.angular_speed_radps);
      ASSERT_LE(acceleration, bounds.angular_acceleration_radps2 + 1e-12) << i;
      if (symmetry != InertiaSymmetry::general) {
        EXPECT_GT(speed, bounds.angular_speed_radps * (1 - 1e-8));
      }
      if (symmetry == InertiaSymmetry::axial) {
        EXPECT_NEAR(acceleration / bounds.angular_acceleration_radps2, 1, 1e-8);
      }
      if (symmetry == InertiaSymmetry::general && acceleration > 1)
        loosest_acceleration =
            std::max(loosest_acceleration, bounds.angular_acceleration_radps2 / acceleration);
    }
  }
  EXPECT_LT(loosest_acceleration, 2);
}

Vec3 place_at(const FreeFlight& flight, RotationTrack& track, const Vec3& point, Tick t) {
  const Pose pose = pose_at(flight, track, t);
  return pose.position_m + math::rotated(pose.orientation, point);
}

TEST(RotationBounds, evaluated_points_move_no_faster_than_bounded_from_one_tick_to_another) {
  // Test spans from a single tick to many ticks. Also test that the rounding term is necessary.
  int moved_by_rounding = 0;
  for (const InertiaSymmetry symmetry : k_symmetries) {
    for (const std::uint64_t i : property::cases(300)) {
      random::Stream stream = stream_of(44, i);
      const Inertia inertia = random_inertia(stream, symmetry);
      FreeFlight flight = random_flight(stream, std::fabs(of_any_size(stream, -3, 2)));
      flight.position_m *= std::fabs(of_any_size(stream, 0, 6));
      flight.velocity_mps *= std::fabs(of_any_size(stream, -6, 1));
      if (i % 2 == 0) flight.acceleration_mps2.setZero();
      const double radius_m = std::fabs(of_any_size(stream, -3, 1));
      const Vec3 point = radius_m * (1 - 1e-12) * math::normalized(vector_between(stream, -1, 1));
      const RotationBounds bounds = rotation_bounds(flight, inertia);
      RotationTrack track(flight, inertia);
      // If a general body's track is queried at an earlier tick, the track restarts. So use early
      // ticks.
      const double longest_s = symmetry == InertiaSymmetry::general
                                   ? std::min(50.0, 30 / bounds.angular_speed_radps)
                                   : 50;
      const TickCount late = ticks_before(longest_s * stream.uniform());
      for (int n = 0; n < 60; ++n) {
        const Tick t1 = flight.begin + (late + static_cast<TickCount>(stream.bits() >> 38));
        const Tick t2 = t1 + static_cast<TickCount>(1 + (stream.bits() >> (n % 2 == 0 ? 62 : 36)));
        const double moved =
            math::norm(place_at(flight, track, point, t2) - place_at(flight, track, point, t1));
        const double allowed = seconds(t2 - t1) * (centre_speed_mps_max(flight, t1, t2) +
                                                   turning_speed_mps_max(bounds, radius_m));
        ASSERT_LE(moved, allowed + rounding_m_max(flight, bounds, radius_m, t2)) << i;
        if (moved > allowed) ++moved_by_rounding;
      }
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(moved_by_rounding, 1'000);
}

TEST(RotationBounds, evaluated_points_curve_no_more_than_bounded) {
  // Test second differences over spans that are much shorter than a turn: |x(t+h) - 2 x(t) +
  // x(t-h)| <= A h^2.
  for (const InertiaSymmetry symmetry : k_symmetries) {
    double closest = 0;
    for (const std::uint64_t i : property::cases(300)) {
      random::Stream stream = stream_of(45, i);
      const Inertia inertia = random_inertia(stream, symmetry);
      FreeFlight flight = random_flight(stream, 10);
      flight.acceleration_mps2.setZero();
      const Vec3 point = math::normalized(vector_between(stream, -1, 1));
      const RotationBounds bounds = rotation_bounds(flight, inertia);
      RotationTrack track(flight, inertia);
      const TickCount h = ticks_before(1e-3);
      for (int n = 0; n < 20; ++n) {
        const Tick t = flight.begin + (h + ticks_before(5 * stream.uniform()));
        const double bend = math::norm(place_at(flight, track, point, t - h) -
                                       2 * place_at(flight, track, point, t) +
                                       place_at(flight, track, point, t + h));
        const double allowed = turning_acceleration_mps2_max(bounds, 1) * seconds(h) * seconds(h);
        ASSERT_LE(bend, allowed + 4 * rounding_m_max(flight, bounds, 1, t + h));
        closest = std::max(closest, bend / allowed);
      }
    }
    if (!property::all_cases()) continue;
    EXPECT_GT(closest, 0.7);
  }
}

}  // namespace
}  // namespace sleight::physics
