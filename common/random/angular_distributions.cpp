#include "common/random/angular_distributions.h"

#include <cmath>

#include "common/base/check.h"
#include "common/math/angle.h"
#include "common/math/elementary.h"
#include "common/random/constants.h"
#include "common/random/linear_distributions.h"

namespace sleight::random {

namespace {

constexpr double k_log_two_pi = 0x1.d67f1c864beb5p+0;          // 1.8378770664093454
constexpr double k_log_four_pi = 0x1.43f89a3f0edd6p+1;         // 2.5310242469692907
constexpr double k_log_two_pi_squared = 0x1.7dc6108a63039p+1;  // log(2 pi^2) = 2.9826069522587457
constexpr double k_uniform_sd_min = 9;

void check(const WrappedNormal& d) {
  CHECK(std::isfinite(d.mean));
  CHECK(d.sd > 0 && std::isfinite(d.sd));
}

// log of the sum over images of the normal density; delta in [-pi, pi) is x - mean. The nearest
// image is taken out, so that nothing underflows for small sd.
double log_density_by_images(double delta, double sd) {
  const double z = delta / sd;
  const double variance = sd * sd;
  // Image k stands to the nearest as exp(-2 pi k (delta + pi k)/sd^2). At sd^2 = 2 pi and
  // |delta| = pi the fifth, the first left out, is 5e-28.
  double others = 0;
  for (int k = 1; k <= 4; ++k) {
    const double turn = math::k_pi * k;
    others += math::exp(-2 * turn * (turn + delta) / variance);
    others += math::exp(-2 * turn * (turn - delta) / variance);
  }
  return ((-0.5 * z * z - math::log(sd)) - 0.5 * k_log_two_pi) + math::log1p(others);
}

// log of the Fourier series. At sd^2 = 2 pi its fifth term, the first left out, is 1e-34.
double log_density_by_harmonics(double delta, double sd) {
  double sum = 0;
  for (int n = 1; n <= 4; ++n) {
    sum += math::exp(-0.5 * (n * n) * (sd * sd)) * math::cos(n * delta);
  }
  return math::log1p(2 * sum) - k_log_two_pi;
}

}  // namespace

double WrappedNormal::draw(Stream& stream) const {
  check(*this);
  if (sd >= k_uniform_sd_min) return UniformAngle{}.draw(stream);
  return math::wrapped_angle(math::wrapped_angle(mean) + sd * standard_normal(stream));
}

double WrappedNormal::log_density(double x) const {
  check(*this);
  CHECK(!std::isnan(x));
  if (x < -math::k_pi || x >= math::k_pi) return k_outside;
  if (sd >= k_uniform_sd_min) return -k_log_two_pi;
  const double delta = math::wrapped_angle(x - math::wrapped_angle(mean));
  return sd < k_sqrt_two_pi ? log_density_by_images(delta, sd)
                            : log_density_by_harmonics(delta, sd);
}

double UniformAngle::draw(Stream& stream) const {
  // 2 u - 1 is exact and at most 1 - 2^-52, so the product stays below k_pi.
  return math::k_pi * (2 * stream.uniform() - 1);
}

double UniformAngle::log_density(double x) const {
  CHECK(!std::isnan(x));
  return x >= -math::k_pi && x < math::k_pi ? -k_log_two_pi : k_outside;
}

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
  // Sequenced: the order in which words are taken is part of the format.
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
  // Two points on circles whose squared radii, u and 1 - u, share the norm.
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
