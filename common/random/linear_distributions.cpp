#include "common/random/linear_distributions.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "common/math/angle.h"
#include "common/math/elementary.h"
#include "common/random/constants.h"

namespace sleight::random {

namespace {

void check(const Uniform& d) {
  CHECK_LT(d.low, d.high);
  CHECK(std::isfinite(d.high - d.low));
}

void check(const Normal& d) {
  CHECK(std::isfinite(d.mean));
  CHECK(d.sd > 0 && std::isfinite(d.sd));
}

}  // namespace

double Uniform::draw(Stream& stream) const {
  check(*this);
  // Because of rounding, the sum may be just beyond `high`.
  return std::min(low + (high - low) * stream.uniform(), high);
}

double Uniform::log_density(double x) const {
  check(*this);
  CHECK(!std::isnan(x));
  return x >= low && x <= high ? -math::log(high - low) : k_outside;
}

double standard_normal(Stream& stream) {
  // Keep this order: the order in which words are drawn is part of the format.
  const double u = stream.uniform();
  const double v = stream.uniform();
  return std::sqrt(-2 * math::log(u)) * math::cos(math::k_two_pi * v);
}

double Normal::draw(Stream& stream) const {
  check(*this);
  return mean + sd * standard_normal(stream);
}

double Normal::log_density(double x) const {
  return NormalLogDensity(*this)(x);
}

NormalLogDensity::NormalLogDensity(const Normal& normal) : normal_(normal) {
  check(normal);
  log_sd_ = math::log(normal.sd);
}

double NormalLogDensity::operator()(double x) const {
  CHECK(!std::isnan(x));
  const double z = (x - normal_.mean) / normal_.sd;
  return (-0.5 * z * z - log_sd_) - k_half_log_two_pi;
}

}  // namespace sleight::random
