// Random bodies and flights, bitwise comparison, and a slow reference for rotation.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "common/random/stream.h"
#include "worker/physics/motion/rotation_track.h"

namespace sleight::physics {

inline constexpr InertiaSymmetry k_symmetries[] = {
    InertiaSymmetry::spherical, InertiaSymmetry::axial, InertiaSymmetry::general};

inline random::Stream stream_of(std::uint64_t test, std::uint64_t iteration) {
  return random::Stream({.seed = test, .purpose = random::Purpose::prior}, iteration);
}

inline double between(random::Stream& stream, double low, double high) {
  return low + (high - low) * stream.uniform();
}

/// Returns a number with a random sign. The size is from 10^low to 10^high, and its logarithm is
/// uniform.
inline double of_any_size(random::Stream& stream, double low, double high) {
  const double size = math::exp(between(stream, low, high) * 2.302585092994046);
  return stream.uniform() < 0.5 ? -size : size;
}

inline Vec3 vector_between(random::Stream& stream, double low, double high) {
  const double x = between(stream, low, high);
  const double y = between(stream, low, high);
  const double z = between(stream, low, high);
  return {x, y, z};
}

/// Moments of a possible mass distribution: each is at most the sum of the other two.
inline Inertia random_inertia(random::Stream& stream, InertiaSymmetry symmetry) {
  double a = std::fabs(of_any_size(stream, -2, 0));
  double b = std::fabs(of_any_size(stream, -2, 0));
  double c = std::fabs(of_any_size(stream, -2, 0));
  if (symmetry != InertiaSymmetry::general) b = a;
  if (symmetry == InertiaSymmetry::spherical) c = a;
  return {.mass_kg = 1 + stream.uniform(),
          .principal_kgm2 = Vec3(b + c, c + a, a + b),
          .symmetry = symmetry};
}

inline FreeFlight random_flight(random::Stream& stream, double speed_radps) {
  FreeFlight flight;
  flight.begin = Tick{static_cast<TickCount>(stream.bits() >> 24)};
  flight.position_m = vector_between(stream, -1, 1);
  flight.velocity_mps = vector_between(stream, -3, 3);
  flight.acceleration_mps2 = Vec3(0, 0, -9.81);
  flight.orientation = math::quaternion_of_rotation_vector(vector_between(stream, -3, 3));
  flight.angular_velocity_radps = speed_radps * math::normalized(vector_between(stream, -1, 1));
  return flight;
}

inline std::array<std::uint64_t, 4> bits_of(const Quat& q) {
  const std::array<double, 4> values = {q.w(), q.x(), q.y(), q.z()};
  std::array<std::uint64_t, 4> bits{};
  std::memcpy(bits.data(), values.data(), sizeof(bits));
  return bits;
}

inline std::array<std::uint64_t, 3> bits_of(const Vec3& v) {
  const std::array<double, 3> values = {v.x(), v.y(), v.z()};
  std::array<std::uint64_t, 3> bits{};
  std::memcpy(bits.data(), values.data(), sizeof(bits));
  return bits;
}

inline double norm_of(const Quat& q) {
  return std::sqrt(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
}

/// Greatest difference of a component. Treats q and -q as different.
inline double distance(const Quat& a, const Quat& b) {
  return (a.coeffs() - b.coeffs()).cwiseAbs().maxCoeff();
}

/// State of a slow reference, which solves Euler's and the quaternion's equations by Runge-Kutta 4
/// in long double.
struct ReferenceState {
  std::array<long double, 3> w{};  ///< about the body's axes
  std::array<long double, 4> q{};

  Quat orientation() const {
    return {static_cast<double>(q[0]), static_cast<double>(q[1]), static_cast<double>(q[2]),
            static_cast<double>(q[3])};
  }
  Vec3 body_radps() const {
    return {static_cast<double>(w[0]), static_cast<double>(w[1]), static_cast<double>(w[2])};
  }
};

/// Coefficients of the equations, so that a test can leave one out.
struct ReferenceEquations {
  std::array<long double, 3> euler{};  ///< (I2 - I3)/I1 and cyclic
  long double half = 0.5L;             ///< of dq/dt = half q w

  explicit ReferenceEquations(const Inertia& inertia) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto moment = [&inertia](std::size_t k) {
        return static_cast<long double>(inertia.principal_kgm2[static_cast<int>(k % 3)]);
      };
      euler[i] = (moment(i + 1) - moment(i + 2)) / moment(i);
    }
  }
};

inline ReferenceState slope(const ReferenceEquations& equations, const ReferenceState& s) {
  const auto& [w, q] = s;
  const auto& c = equations.euler;
  const long double h = equations.half;
  return {.w = {c[0] * w[1] * w[2], c[1] * w[2] * w[0], c[2] * w[0] * w[1]},
          .q = {-h * (q[1] * w[0] + q[2] * w[1] + q[3] * w[2]),
                h * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]),
                h * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]),
                h * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0])}};
}

inline ReferenceState moved(const ReferenceState& s, const ReferenceState& slope, long double h) {
  ReferenceState result = s;
  for (std::size_t i = 0; i < 3; ++i)
    result.w[i] += h * slope.w[i];
  for (std::size_t i = 0; i < 4; ++i)
    result.q[i] += h * slope.q[i];
  return result;
}

/// REQUIRES: each step turns by at most 1/4000 rad. Then the error is below 1e-16 per radian.
inline ReferenceState integrated(const ReferenceEquations& equations, ReferenceState s,
                                 double seconds, int steps) {
  const long double h = static_cast<long double>(seconds) / steps;
  for (int step = 0; step < steps; ++step) {
    const ReferenceState a = slope(equations, s);
    const ReferenceState b = slope(equations, moved(s, a, h / 2));
    const ReferenceState c = slope(equations, moved(s, b, h / 2));
    const ReferenceState d = slope(equations, moved(s, c, h));
    s = moved(moved(moved(moved(s, a, h / 6), b, h / 3), c, h / 3), d, h / 6);
  }
  return s;
}

inline ReferenceState reference_start(const FreeFlight& flight) {
  const Quat& q = flight.orientation;
  const Vec3 w = math::rotated(math::inverse(q), flight.angular_velocity_radps);
  return {.w = {w.x(), w.y(), w.z()}, .q = {q.w(), q.x(), q.y(), q.z()}};
}

}  // namespace sleight::physics
