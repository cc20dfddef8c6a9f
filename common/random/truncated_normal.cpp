#include "common/random/truncated_normal.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "common/random/constants.h"
#include "common/random/linear_distributions.h"

namespace sleight::random {

namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
constexpr double k_sqrt_half = 0x1.6a09e667f3bcdp-1;  // 0.70710678118654752
// 1000 rejections in a row have probability 1e-222, because 4 in 10 proposals are accepted.
constexpr int k_proposals_max = 1000;

struct Interval {
  double low = 0;
  double high = 0;
};

// Returns (low - mean)/sd and (high - mean)/sd; infinite bounds stay infinite.
Interval standardized(const TruncatedNormal& d) {
  CHECK(std::isfinite(d.mean));
  CHECK(d.sd > 0 && std::isfinite(d.sd));
  CHECK_LT(d.low, d.high);
  const Interval z{.low = (d.low - d.mean) / d.sd, .high = (d.high - d.mean) / d.sd};
  constexpr double k_bound_max = 1e300;
  CHECK(d.low == -k_infinity || std::fabs(z.low) <= k_bound_max);
  CHECK(d.high == k_infinity || std::fabs(z.high) <= k_bound_max);
  CHECK_GE((d.high - d.low) / d.sd, 1 / k_bound_max);
  return z;
}

// Draws from the standard normal restricted to an interval that contains 0.
double draw_around_zero(const Interval& z, Stream& stream) {
  const double width = z.high - z.low;
  for (int proposals = 0;; ++proposals) {
    CHECK_LT(proposals, k_proposals_max);
    if (width > k_sqrt_two_pi) {
      const double candidate = standard_normal(stream);
      if (candidate >= z.low && candidate <= z.high) return candidate;
    } else {
      const double candidate = z.low + width * stream.uniform();
      if (stream.uniform() <= math::exp(-0.5 * candidate * candidate)) return candidate;
    }
  }
}

// Draws from a standard normal restricted to [near, near + width], and returns the draw's distance
// t from `near`. REQUIRES: near >= 0. The proposal density is proportional to exp(-rate t) on [0,
// width]. The target density is proportional to exp(-near t - t^2/2). The ratio of target to
// proposal is greatest at t = rate - near.
double draw_distance_in_tail(double near, double width, Stream& stream) {
  // rate = (near + sqrt(near^2 + 4))/2, written so that rate - near does not cancel.
  const double root = near < 1e9 ? std::sqrt(near * near + 4) : near;
  const double rate = 0.5 * (near + root);
  const double peak = 2 / (near + root);
  // Transform a uniform number in (0, mass) into an exponential restricted to (0, width).
  const double minus_mass = math::expm1(-rate * width);
  for (int proposals = 0;; ++proposals) {
    CHECK_LT(proposals, k_proposals_max);
    const double u = stream.uniform();
    const double t = std::min(-math::log1p(u * minus_mass) / rate, width);
    const double from_peak = t - peak;
    if (stream.uniform() <= math::exp(-0.5 * from_peak * from_peak)) return t;
  }
}

// Mills' ratio: the integral of exp(-a t - t^2/2) over t > 0, for a >= 0.
double mills_ratio(double a) {
  constexpr double k_fraction_min = 4;
  if (a < k_fraction_min) {
    return 0.5 * k_sqrt_two_pi * (math::exp(0.5 * a * a) * math::erfc(a * k_sqrt_half));
  }
  // Laplace's continued fraction 1/(a + 1/(a + 2/(a + 3/(a + ...)))), Abramowitz and Stegun
  // 26.2.14. At a = 4 the error after 40 levels is below 1e-25.
  double denominator = a;
  for (int level = 40; level >= 1; --level)
    denominator = a + level / denominator;
  return 1 / denominator;
}

// The integral of exp(-a t - t^2/2) over 0 < t < width by Gauss and Legendre's 16-point rule.
double short_integral(double a, double width) {
  struct Node {
    double position;
    double weight;
  };
  static constexpr std::array<Node, 8> k_nodes = {
      {{0.98940093499164993259, 0.02715245941175409485},
       {0.94457502307323257607, 0.06225352393864789286},
       {0.86563120238783174388, 0.09515851168249278480},
       {0.75540440835500303389, 0.12462897125553387205},
       {0.61787624440264374844, 0.14959598881657673208},
       {0.45801677765722738634, 0.16915651939500253818},
       {0.28160355077925891323, 0.18260341504492358886},
       {0.09501250983763744018, 0.18945061045506849628}}};
  const double half = 0.5 * width;
  const auto integrand = [a](double t) { return math::exp(-t * (a + 0.5 * t)); };
  double sum = 0;
  for (const Node& node : k_nodes) {
    sum += node.weight *
           (integrand(half * (1 - node.position)) + integrand(half * (1 + node.position)));
  }
  return sum * half;
}

// For a >= 0: the log of the integral of exp(-a t - t^2/2) over 0 < t < width.
double log_tail_integral(double a, double width) {
  // The integrand at the interval's end is exp(-fall) times the integrand at its beginning. The
  // quadrature rule is exact for a small fall. For a large fall, the difference of two Mills ratios
  // has no cancellation.
  const double fall = width * (a + 0.5 * width);
  constexpr double k_fall_short_max = 4;
  if (fall <= k_fall_short_max) return math::log(short_integral(a, width));
  return math::log(mills_ratio(a) - math::exp(-fall) * mills_ratio(a + width));
}

// Log of the probability that a standard normal variable is in an interval that contains 0.
double log_mass_around_zero(const Interval& z) {
  const double below = z.low * k_sqrt_half;
  const double above = z.high * k_sqrt_half;
  const double mass = 0.5 * (math::erf(above) - math::erf(below));
  if (mass < 0.5) return math::log(mass);
  return math::log1p(-0.5 * (math::erfc(-below) + math::erfc(above)));
}

}  // namespace

double TruncatedNormal::draw(Stream& stream) const {
  const Interval z = standardized(*this);
  double x = 0;
  if (z.low >= 0) {
    x = low + sd * draw_distance_in_tail(z.low, (high - low) / sd, stream);
  } else if (z.high <= 0) {
    x = high - sd * draw_distance_in_tail(-z.high, (high - low) / sd, stream);
  } else {
    x = mean + sd * draw_around_zero(z, stream);
  }
  return std::clamp(x, low, high);
}

double TruncatedNormal::log_density(double x) const {
  const Interval z = standardized(*this);
  CHECK(!std::isnan(x));
  if (x < low || x > high) return -k_infinity;
  const double log_sd = math::log(sd);
  if (z.low >= 0) {
    const double t = (x - low) / sd;
    return (-t * (z.low + 0.5 * t) - log_sd) - log_tail_integral(z.low, (high - low) / sd);
  }
  if (z.high <= 0) {
    const double t = (high - x) / sd;
    return (-t * (-z.high + 0.5 * t) - log_sd) - log_tail_integral(-z.high, (high - low) / sd);
  }
  const double distance = (x - mean) / sd;
  return ((-0.5 * distance * distance - log_sd) - k_half_log_two_pi) - log_mass_around_zero(z);
}

}  // namespace sleight::random
