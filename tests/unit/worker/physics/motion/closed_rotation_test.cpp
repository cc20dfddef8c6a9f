// Goal: the rotation of spherical and axially symmetric bodies equals the known solutions and the
// general integration. Method: compare steady spin and precession with long double formulas. Also
// compare bodies that have the same moments, but for which different symmetries are declared.
#include "worker/physics/motion/closed_rotation.h"

#include <gtest/gtest.h>

#include "common/math/angle.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/motion/support.h"
#include "worker/physics/motion/invariants.h"

namespace sleight::physics {
namespace {

using Vec3l = Eigen::Matrix<long double, 3, 1>;

// Turns the vector `v` about the axis `rate` by the angle |rate| s (Rodrigues' formula).
Vec3 turned_about(const Vec3& rate, double s, const Vec3& v) {
  const Vec3l w = rate.cast<long double>();
  const Vec3l x = v.cast<long double>();
  const long double t = w.norm() * s;
  const Vec3l n = w / w.norm();
  return (x * std::cos(t) + n.cross(x) * std::sin(t) + n * (n.dot(x) * (1 - std::cos(t))))
      .cast<double>();
}

TEST(SphericalRotation, turns_steadily_about_a_fixed_axis) {
  for (const std::uint64_t i : property::cases(500)) {
    random::Stream stream = stream_of(11, i);
    const Inertia inertia = random_inertia(stream, InertiaSymmetry::spherical);
    const FreeFlight flight = random_flight(stream, std::fabs(of_any_size(stream, -6, 2)));
    const Tick t = flight.begin + ticks_before(between(stream, 0, 10));
    const double s = seconds_since_begin(flight, t);
    const Vec3& w = flight.angular_velocity_radps;
    const Vec3 mark = vector_between(stream, -1, 1);
    const Quat q = orientation_at(flight, inertia, t);
    const Vec3 expected = turned_about(w, s, math::rotated(flight.orientation, mark));
    EXPECT_LT(math::norm(math::rotated(q, mark) - expected), 0x1p-50 * (8 + math::norm(w) * s));
    EXPECT_EQ(bits_of(angular_velocity_at(flight, inertia, t)), bits_of(w));
  }
}

TEST(AxialRotation, precesses_about_the_angular_momentum_at_the_rate_l_over_i1) {
  for (const std::uint64_t i : property::cases(500)) {
    random::Stream stream = stream_of(12, i);
    const Inertia inertia = random_inertia(stream, InertiaSymmetry::axial);
    const FreeFlight flight = random_flight(stream, 20);
    const Tick t = flight.begin + ticks_before(between(stream, 0, 5));
    const double s = seconds_since_begin(flight, t);
    const Vec3 momentum =
        angular_momentum_kgm2ps(inertia, flight.orientation, flight.angular_velocity_radps);
    const Vec3 rate = momentum / inertia.principal_kgm2.x();
    const double tolerance = 0x1p-49 * (8 + math::norm(rate) * s);
    const Quat q = orientation_at(flight, inertia, t);
    const Vec3 axis = math::rotated(q, Vec3(0, 0, 1));
    EXPECT_LT(
        math::norm(axis - turned_about(rate, s, math::rotated(flight.orientation, Vec3(0, 0, 1)))),
        tolerance);
    const Vec3 w = angular_velocity_at(flight, inertia, t);
    EXPECT_LT(math::norm(w - turned_about(rate, s, flight.angular_velocity_radps)), 20 * tolerance);
    EXPECT_LT(math::norm(angular_momentum_kgm2ps(inertia, q, w) - momentum),
              math::norm(momentum) * 40 * tolerance);
  }
}

TEST(ClosedRotation, agrees_with_the_general_steps_where_moments_coincide) {
  for (const std::uint64_t i : property::cases(200)) {
    random::Stream stream = stream_of(14, i);
    const Inertia inertia =
        random_inertia(stream, i % 2 == 0 ? InertiaSymmetry::axial : InertiaSymmetry::spherical);
    Inertia general = inertia;
    general.symmetry = InertiaSymmetry::general;
    const FreeFlight flight = random_flight(stream, 30);
    const Tick t = flight.begin + ticks_before(between(stream, 0, 10));
    // The sum of the angles is 600 rad. Each angle has a relative error of about 2^-52.
    EXPECT_LT(distance(orientation_at(flight, inertia, t), orientation_at(flight, general, t)),
              2e-12);
    EXPECT_LT(math::norm(angular_velocity_at(flight, inertia, t) -
                         angular_velocity_at(flight, general, t)),
              30 * 2e-12);
  }
}

TEST(ClosedRotation, an_axial_body_with_equal_moments_has_the_bits_of_a_spherical_one) {
  for (const std::uint64_t i : property::cases(200)) {
    random::Stream stream = stream_of(15, i);
    const Inertia spherical = random_inertia(stream, InertiaSymmetry::spherical);
    Inertia axial = spherical;
    axial.symmetry = InertiaSymmetry::axial;
    const FreeFlight flight = random_flight(stream, 30);
    const Tick t = flight.begin + ticks_before(between(stream, 0, 10));
    EXPECT_EQ(bits_of(orientation_at(flight, spherical, t)),
              bits_of(orientation_at(flight, axial, t)));
    EXPECT_EQ(bits_of(angular_velocity_at(flight, spherical, t)),
              bits_of(angular_velocity_at(flight, axial, t)));
  }
}

TEST(ClosedRotationDeathTest, refuses_moments_that_break_the_declared_symmetry) {
  FreeFlight flight;
  Inertia inertia{.mass_kg = 1, .principal_kgm2 = Vec3(1, 1, 2)};
  inertia.symmetry = InertiaSymmetry::spherical;
  EXPECT_DEATH(closed_rotation(flight, inertia), "check failed");
  inertia.symmetry = InertiaSymmetry::axial;
  inertia.principal_kgm2 = Vec3(1, 1.0000001, 2);
  EXPECT_DEATH(closed_rotation(flight, inertia), "check failed");
}

}  // namespace
}  // namespace sleight::physics
