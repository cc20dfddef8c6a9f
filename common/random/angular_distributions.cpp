#include "common/random/angular_distributions.h"

#include <cmath>

#include "common/base/check.h"
#include "common/math/angle.h"
#include "common/math/elementary.h"
#include "common/random/constants.h"

namespace sleight::random {

namespace {

constexpr double k_log_two_pi = 0x1.d67f1c864beb5p+0;          // log(2 pi) = 1.8378770664093454
constexpr double k_log_four_pi = 0x1.43f89a3f0edd6p+1;         // log(4 pi) = 2.5310242469692907
constexpr double k_log_two_pi_squared = 0x1.7dc6108a63039p+1;  // log(2 pi^2) = 2.9826069522587457

}  // namespace

math::Vec2 UniformDirection2::draw(Stream& stream) const {
  const math::SinCos angle = math::sincos(math::k_two_pi * stream.uniform());
  return {angle.cos, angle.sin};
}

double UniformDirection2::log_density(const math::Vec2& x) const {
  const double square = math::dot(x, x);
  CHECK(!std::isnan(square));
  return std::fabs(square - 1) <= k_unit_square_tolerance ? -k_log_two_pi : k_outside;
}

math::Vec3 UniformDirection3::draw(Stream& stream) const {
  // Keep this order: the order in which words are drawn is part of the format.
  const double z = 2 * stream.uniform() - 1;
  const math::SinCos azimuth = math::sincos(math::k_two_pi * stream.uniform());
  const double radius = std::sqrt((1 - z) * (1 + z));
  return {radius * azimuth.cos, radius * azimuth.sin, z};
}

double UniformDirection3::log_density(const math::Vec3& x) const {
  const double square = math::dot(x, x);
  CHECK(!std::isnan(square));
  return std::fabs(square - 1) <= k_unit_square_tolerance ? -k_log_four_pi : k_outside;
}

math::Quat UniformRotation::draw(Stream& stream) const {
  // Draw a point on each of two circles. The squared radii u and 1 - u sum to the squared norm, 1.
  const double u = stream.uniform();
  const math::SinCos first = math::sincos(math::k_two_pi * stream.uniform());
  const math::SinCos second = math::sincos(math::k_two_pi * stream.uniform());
  const double first_radius = std::sqrt(1 - u);
  const double second_radius = std::sqrt(u);
  return {second_radius * second.cos, first_radius * first.sin, first_radius * first.cos,
          second_radius * second.sin};
}

double UniformRotation::log_density(const math::Quat& x) const {
  const double square = ((x.w() * x.w() + x.x() * x.x()) + x.y() * x.y()) + x.z() * x.z();
  CHECK(!std::isnan(square));
  return std::fabs(square - 1) <= k_unit_square_tolerance ? -k_log_two_pi_squared : k_outside;
}

}  // namespace sleight::random
