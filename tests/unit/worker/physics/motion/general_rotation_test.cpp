// Goal: the Taylor steps solve Euler's equations and the quaternion's equation to the last bits,
// and keep the energy and momentum of a free body. Method: compare rotations with two references: a
// Runge-Kutta integration in tiny long double steps, and Jacobi's elliptic functions (Boost.Math).
// Measure the drift of energy and momentum. Broken equations must fail.
#include "worker/physics/motion/general_rotation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/motion/support.h"
#include "worker/physics/motion/invariants.h"
#include "worker/physics/motion/rotation_bounds.h"

namespace sleight::physics {
namespace {

static_assert(sizeof(GeneralRotation) <= 1352, "the header promises 169 words");

Vec3 body_radps_at(const FreeFlight& flight, const Inertia& inertia, Tick t) {
  return body_angular_velocity_radps(orientation_at(flight, inertia, t),
                                     angular_velocity_at(flight, inertia, t));
}

struct Case {
  Inertia inertia;
  FreeFlight flight;
};

// Needles, plates and near spheres. Every third body spins near the unstable axis.
Case random_case(std::uint64_t test, std::uint64_t i) {
  random::Stream stream = stream_of(test, i);
  Case result{.inertia = random_inertia(stream, InertiaSymmetry::general),
              .flight = random_flight(stream, 8)};
  if (i % 3 == 0) {
    const Vec3& moments = result.inertia.principal_kgm2;
    int middle = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double m = moments[axis];
      if (m > moments.minCoeff() && m < moments.maxCoeff()) middle = axis;
    }
    Vec3 w(1e-3, 1e-3, 1e-3);
    w[middle] = 8;
    result.flight.angular_velocity_radps = math::rotated(result.flight.orientation, w);
  }
  return result;
}

TEST(GeneralRotation, agrees_with_a_slow_integration) {
  double worst_orientation = 0;
  double worst_velocity = 0;
  for (std::uint64_t i = 0; i < property::of_tier(12, 60); ++i) {
    const auto [inertia, flight] = random_case(21, i);
    const Tick t = flight.begin + ticks_before(0.75);
    const ReferenceState end =
        integrated(ReferenceEquations(inertia), reference_start(flight), 0.75, 48'000);
    worst_orientation = std::max(worst_orientation,
                                 distance(orientation_at(flight, inertia, t), end.orientation()));
    worst_velocity =
        std::max(worst_velocity,
                 (body_radps_at(flight, inertia, t) - end.body_radps()).cwiseAbs().maxCoeff());
  }
  // The bodies turn by six radians. Near the unstable axis, a rounding error grows up to fivefold.
  EXPECT_LT(worst_orientation, 1e-14);
  EXPECT_LT(worst_velocity, 8 * 2e-14);
}

TEST(GeneralRotation, a_single_step_is_exact_to_rounding) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    const auto [inertia, flight] = random_case(22, i);
    // The truncated series is worst at the end of the first step.
    const TickCount step =
        GeneralRotation(flight, inertia).span_max() / GeneralRotation::k_steps_max;
    const Tick end = flight.begin + (step - 1);
    const ReferenceState reference = integrated(
        ReferenceEquations(inertia), reference_start(flight), seconds(end - flight.begin), 2'000);
    EXPECT_LT(distance(orientation_at(flight, inertia, end), reference.orientation()), 5e-16);
    EXPECT_LT((body_radps_at(flight, inertia, end) - reference.body_radps()).cwiseAbs().maxCoeff(),
              8 * 2e-15);
  }
}

TEST(GeneralRotation, is_told_from_equations_with_a_missing_or_wrong_term) {
  // Equations with a missing or wrong term differ from the steps by far more than the tolerances
  // above. Even without a reference, energy or momentum reveals a missing or wrong term.
  const auto [inertia, flight] = random_case(23, 1);
  const Tick t = flight.begin + ticks_before(0.75);
  const Quat q = orientation_at(flight, inertia, t);
  const double energy =
      rotational_energy_j(inertia, flight.orientation, flight.angular_velocity_radps);
  const Vec3 momentum =
      angular_momentum_kgm2ps(inertia, flight.orientation, flight.angular_velocity_radps);
  for (int broken = 0; broken < 5; ++broken) {
    ReferenceEquations equations(inertia);
    const auto axis = static_cast<std::size_t>(broken);
    if (broken < 3) equations.euler[axis] = 0;
    if (broken == 3) equations.euler[1] = -equations.euler[1];
    if (broken == 4) equations.half = 1;
    const ReferenceState end = integrated(equations, reference_start(flight), 0.75, 2'000);
    const Quat broken_q = end.orientation();
    EXPECT_GT(distance(q, broken_q), 1e-3) << broken;
    const Vec3 w = math::rotated(broken_q, end.body_radps());
    const double gain = rotational_energy_j(inertia, broken_q, w) / energy - 1;
    const double turn =
        math::norm(angular_momentum_kgm2ps(inertia, broken_q, w) - momentum) / math::norm(momentum);
    EXPECT_GT(std::max(std::fabs(gain), turn), 1e-3) << broken;
  }
}

// Jacobi's solution for I1 < I2 < I3 and L^2 > 2 E I2, from w2 = 0 and w1, w3 > 0 (Landau and
// Lifshitz, "Mechanics", section 37).
struct JacobiSolution {
  long double rate;
  long double k;
  std::array<long double, 3> amplitude;

  JacobiSolution(const Inertia& inertia, const Vec3& start) {
    const long double i1 = inertia.principal_kgm2.x();
    const long double i2 = inertia.principal_kgm2.y();
    const long double i3 = inertia.principal_kgm2.z();
    const long double w1 = start.x();
    const long double w3 = start.z();
    // The terms 2 E I3 - L^2 and L^2 - 2 E I1 are single products because w2 = 0.
    const long double a = i1 * (i3 - i1) * w1 * w1;
    const long double b = i3 * (i3 - i1) * w3 * w3;
    rate = std::sqrt((i3 - i2) * b / (i1 * i2 * i3));
    k = std::sqrt((i2 - i1) * a / ((i3 - i2) * b));
    amplitude = {w1, std::sqrt(a / (i2 * (i3 - i2))), w3};
  }
  double period_s() const { return static_cast<double>(4 * boost::math::ellint_1(k) / rate); }
  Vec3 at(double s) const {
    long double cn = 0;
    long double dn = 0;
    const long double sn =
        boost::math::jacobi_elliptic(k, rate * static_cast<long double>(s), &cn, &dn);
    return {static_cast<double>(amplitude[0] * cn), static_cast<double>(amplitude[1] * sn),
            static_cast<double>(amplitude[2] * dn)};
  }
};

TEST(GeneralRotation, follows_jacobis_elliptic_functions) {
  for (const std::uint64_t i : property::cases(100)) {
    random::Stream stream = stream_of(24, i);
    Inertia inertia = random_inertia(stream, InertiaSymmetry::general);
    Vec3& m = inertia.principal_kgm2;
    std::sort(m.data(), m.data() + 3);
    // Cases range from steady spin about the third axis to rotations within 1/1000 of the
    // separatrix.
    const double separatrix = std::sqrt(m.x() * (m.y() - m.x()) / (m.z() * (m.z() - m.y())));
    FreeFlight flight = random_flight(stream, 1);
    const Vec3 start(1, 0, separatrix * (1 + std::fabs(of_any_size(stream, -3, 1))));
    flight.angular_velocity_radps = math::rotated(flight.orientation, start);
    const JacobiSolution solution(inertia, start);
    for (int n = 0; n < 10; ++n) {
      const Tick t = flight.begin + ticks_before(between(stream, 0, 2 * solution.period_s()));
      const Vec3 expected = solution.at(seconds_since_begin(flight, t));
      EXPECT_LT(math::norm(body_radps_at(flight, inertia, t) - expected), 1e-10 * math::norm(start))
          << i << " k " << static_cast<double>(solution.k);
    }
  }
}

TEST(GeneralRotation, keeps_energy_momentum_and_norm_over_a_thousand_revolutions) {
  double energy_drift = 0;
  double momentum_drift = 0;
  double norm_drift = 0;
  for (std::uint64_t i = 0; i < property::of_tier(6, 30); ++i) {
    const auto [inertia, flight] = random_case(25, i);
    const double energy =
        rotational_energy_j(inertia, flight.orientation, flight.angular_velocity_radps);
    const Vec3 momentum =
        angular_momentum_kgm2ps(inertia, flight.orientation, flight.angular_velocity_radps);
    const double turns_s = 1000 * 6.2832 / math::norm(flight.angular_velocity_radps);
    RotationTrack track(flight, inertia);
    for (int n = 1; n <= 50; ++n) {
      const Tick t = flight.begin + ticks_before(turns_s * n / 50);
      const Quat q = track.orientation_at(t);
      const Vec3 w = track.angular_velocity_at(t);
      energy_drift =
          std::max(energy_drift, std::fabs(rotational_energy_j(inertia, q, w) / energy - 1));
      momentum_drift =
          std::max(momentum_drift, math::norm(angular_momentum_kgm2ps(inertia, q, w) - momentum) /
                                       math::norm(momentum));
      norm_drift = std::max(norm_drift, std::fabs(norm_of(q) - 1));
    }
  }
  RecordProperty("energy", std::to_string(energy_drift * 1e15) + "e-15");
  RecordProperty("momentum", std::to_string(momentum_drift * 1e15) + "e-15");
  EXPECT_LT(energy_drift, 3e-14);
  EXPECT_LT(momentum_drift, 3e-14);
  EXPECT_LT(norm_drift, 2e-15);
}

TEST(GeneralRotation, a_body_at_rest_stays_for_ever) {
  FreeFlight flight;
  flight.orientation = math::quaternion_of_rotation_vector(Vec3(1, 2, 3));
  const Inertia inertia{.mass_kg = 1, .principal_kgm2 = Vec3(1, 1.3, 2)};
  EXPECT_EQ(bits_of(orientation_at(flight, inertia, k_tick_max)), bits_of(flight.orientation));
  EXPECT_EQ(math::norm(angular_velocity_at(flight, inertia, k_tick_max)), 0);
}

}  // namespace
}  // namespace sleight::physics
