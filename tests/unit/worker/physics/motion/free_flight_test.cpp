// Goal: the centre of mass follows its parabola up to the documented rounding, and its place
// depends only on the ticks since the flight's first tick. Method: compare flights of all sizes
// with long double formulas. Compare bits at the first tick, and for the same flight shifted in
// time.
#include "worker/physics/motion/free_flight.h"

#include <gtest/gtest.h>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/motion/support.h"
#include "worker/physics/motion/invariants.h"

namespace sleight::physics::free_flight_test {

static_assert(sizeof(FreeFlight) == 144);

FreeFlight flight_of_any_size(random::Stream& stream) {
  FreeFlight flight = random_flight(stream, 1);
  for (int axis = 0; axis < 3; ++axis) {
    flight.position_m[axis] = of_any_size(stream, -6, 6);
    flight.velocity_mps[axis] = of_any_size(stream, -12, 4);
    flight.acceleration_mps2[axis] = of_any_size(stream, -12, 3);
  }
  return flight;
}

TEST(FreeFlight, follows_the_parabola_to_the_stated_rounding) {
  for (const std::uint64_t i : property::cases(20'000)) {
    random::Stream stream = stream_of(1, i);
    const FreeFlight flight = flight_of_any_size(stream);
    const Tick t = flight.begin + ticks_before(std::fabs(of_any_size(stream, -8, 3)));
    const long double s = static_cast<long double>(t - flight.begin) / 1073741824.0L;
    for (int axis = 0; axis < 3; ++axis) {
      const long double p = flight.position_m[axis];
      const long double v = flight.velocity_mps[axis];
      const long double a = flight.acceleration_mps2[axis];
      const long double terms = std::fabs(p) + std::fabs(v) * s + std::fabs(a) * s * s / 2;
      EXPECT_LE(std::fabs(position_at(flight, t)[axis] - (p + v * s + a * s * s / 2)),
                0x1p-51L * terms);
      EXPECT_LE(std::fabs(velocity_at(flight, t)[axis] - (v + a * s)),
                0x1p-52L * (std::fabs(v) + std::fabs(a) * s));
    }
  }
}

TEST(FreeFlight, begins_with_its_own_bits_and_shifts_with_its_begin) {
  for (const std::uint64_t i : property::cases(2'000)) {
    random::Stream stream = stream_of(2, i);
    const FreeFlight flight = flight_of_any_size(stream);
    EXPECT_EQ(bits_of(position_at(flight, flight.begin)), bits_of(flight.position_m));
    EXPECT_EQ(bits_of(velocity_at(flight, flight.begin)), bits_of(flight.velocity_mps));

    FreeFlight later = flight;
    const auto shift = static_cast<TickCount>(stream.bits() >> 20);
    later.begin = flight.begin + shift;
    const Tick t = flight.begin + static_cast<TickCount>(stream.bits() >> 26);
    EXPECT_EQ(bits_of(position_at(flight, t)), bits_of(position_at(later, t + shift)));
    EXPECT_EQ(bits_of(velocity_at(flight, t)), bits_of(velocity_at(later, t + shift)));
  }
}

TEST(Invariants, energy_and_momentum_of_a_body_turned_by_hand) {
  // After a quarter turn about x, the body's y axis points along the world's z.
  const Inertia inertia{.mass_kg = 2, .principal_kgm2 = Vec3(1, 3, 5)};
  const double half = std::sqrt(0.5);
  const Quat quarter(half, half, 0, 0);
  const Twist twist{.velocity_mps = Vec3(1, 2, -2), .angular_velocity_radps = Vec3(0, 0, 4)};
  EXPECT_NEAR(kinetic_energy_j(inertia, quarter, twist), 0.5 * 2 * 9 + 0.5 * 3 * 16, 1e-13);
  EXPECT_NEAR(rotational_energy_j(inertia, quarter, twist.angular_velocity_radps), 24, 1e-13);
  const Vec3 momentum = angular_momentum_kgm2ps(inertia, quarter, twist.angular_velocity_radps);
  EXPECT_LT((momentum - Vec3(0, 0, 12)).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_NEAR(kinetic_energy_j(inertia, Quat::Identity(), twist), 9 + 40, 1e-13);
}

}  // namespace sleight::physics::free_flight_test
