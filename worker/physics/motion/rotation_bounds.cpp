#include "worker/physics/motion/rotation_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "worker/physics/motion/closed_rotation.h"
#include "worker/physics/motion/invariants.h"

namespace sleight::physics {

namespace {

constexpr double k_margin = 1 + 0x1p-30;  ///< for rounding

struct PolhodeAxis {
  double moment;  ///< in any unit
  double square;  ///< of the angular velocity about the axis
};

double squared(double x) {
  return x * x;
}

}  // namespace

RotationBounds general_rotation_bounds(const Vec3& principal_kgm2, const Vec3& body_radps) {
  std::array<PolhodeAxis, 3> axes{{{principal_kgm2.x(), squared(body_radps.x())},
                                   {principal_kgm2.y(), squared(body_radps.y())},
                                   {principal_kgm2.z(), squared(body_radps.z())}}};
  const auto order = [&axes](std::size_t a, std::size_t b) {
    if (axes[b].moment < axes[a].moment) std::swap(axes[a], axes[b]);
  };
  order(0, 1);
  order(1, 2);
  order(0, 1);
  const auto [i1, x1] = axes[0];
  const auto [i2, x2] = axes[1];
  const auto [i3, x3] = axes[2];
  const double d21 = i2 - i1;
  const double d32 = i3 - i2;
  const double d31 = i3 - i1;

  // The greatest |w|, at w2 = 0.
  const double y_max = ((x1 + x2) + x3) + x2 * (d21 / i1) * (d32 / i3);
  RotationBounds bounds;
  bounds.angular_speed_radps = std::sqrt(y_max) * k_margin;
  if (d31 == 0) return bounds;

  // w1^2 and w3^2 are greatest at w2 = 0; w2^2 is greatest where w1 or w3 first becomes 0.
  const double x1_max = x1 + x2 * (i2 * d32) / (i1 * d31);
  const double x3_max = x3 + x2 * (i2 * d21) / (i3 * d31);
  constexpr double k_none = std::numeric_limits<double>::infinity();
  const double until_x1 = d32 > 0 ? x1 * (i1 * d31) / (i2 * d32) : k_none;
  const double until_x3 = d21 > 0 ? x3 * (i3 * d31) / (i2 * d21) : k_none;
  const double x2_max = x2 + std::min(until_x1, until_x3);

  // Euler's equations: dw1/dt = (I2 - I3)/I1 w2 w3 and cyclic. The bound by_speed uses the greatest
  // coefficient and ab + bc + ca <= (a + b + c)^2/3.
  const double c1 = squared(d32 / i1);
  const double c2 = squared(d31 / i2);
  const double c3 = squared(d21 / i3);
  const double by_axes = (c1 * (x2_max * x3_max) + c2 * (x3_max * x1_max)) + c3 * (x1_max * x2_max);
  const double by_speed = std::max({c1, c2, c3}) * squared(y_max) / 3;
  bounds.angular_acceleration_radps2 = std::sqrt(std::min(by_axes, by_speed)) * k_margin;
  return bounds;
}

RotationBounds rotation_bounds(const FreeFlight& flight, const Inertia& inertia) {
  const Vec3& w = flight.angular_velocity_radps;
  if (inertia.symmetry == InertiaSymmetry::general) {
    return general_rotation_bounds(inertia.principal_kgm2,
                                   body_angular_velocity_radps(flight.orientation, w));
  }
  // For spherical and axial bodies, |w| is constant, and w turns about the angular momentum.
  const ClosedRotation closed = closed_rotation(flight, inertia);
  return {.angular_speed_radps = math::norm(w) * k_margin,
          .angular_acceleration_radps2 =
              inertia.symmetry == InertiaSymmetry::axial
                  ? math::norm(math::cross(closed.precession_radps, w)) * k_margin
                  : 0,
          .phase_rate_radps = math::norm(closed.precession_radps) + std::fabs(closed.spin_radps)};
}

}  // namespace sleight::physics
