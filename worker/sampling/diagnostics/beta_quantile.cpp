#include "worker/sampling/diagnostics/beta_quantile.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/check.h"
#include "common/math/elementary.h"

namespace sleight::sampling {
namespace {

/// log Gamma(a) less Stirling's (a - 1/2) log a - a + log sqrt(2 pi). REQUIRES: a >= 1.
double stirling_error(double a) {
  // Step up by the recurrence of Gamma to where the series holds to the last bit.
  double error = 0;
  constexpr double k_series_min = 16;
  for (; a < k_series_min; ++a)
    error += (a + 0.5) * math::log1p(1 / a) - 1;
  const double square = 1 / (a * a);
  const double series =
      1.0 / 12 -
      square * (1.0 / 360 - square * (1.0 / 1260 - square * (1.0 / 1680 - square / 1188)));
  return error + series / a;
}

/// x (1 - x) times the density at x.
double scaled_density(const Beta& beta, double x) {
  const double total = beta.a + beta.b;
  const double mean = beta.a / total;
  const double from_mean = x - mean;
  const double exponent =
      beta.a * math::log1p(from_mean / mean) + beta.b * math::log1p(-from_mean / (beta.b / total));
  const double correction = stirling_error(total) - stirling_error(beta.a) - stirling_error(beta.b);
  return std::sqrt(mean * beta.b / (2 * std::numbers::pi)) * math::exp(exponent + correction);
}

/// The continued fraction by W. Lentz's method: scaled_density / a times it is the probability
/// below x. REQUIRES: x at most about the mean, where it converges within some sqrt(a + b) levels.
double continued_fraction(const Beta& beta, double x) {
  constexpr double k_level_max = 1e8;
  constexpr double k_tiny = 1e-300;
  double above = 1;
  double below = 0;
  double value = 1;
  for (double m = 0; m < k_level_max; ++m) {
    // Two levels: the odd and then the even coefficient.
    const double place = beta.a + 2 * m;
    const double odd = -(beta.a + m) * (beta.a + beta.b + m) / (place * (place + 1)) * x;
    const double even = (m + 1) * (beta.b - m - 1) / ((place + 1) * (place + 2)) * x;
    double change = 1;
    for (const double coefficient : {odd, even}) {
      below = 1 + coefficient * below;
      if (std::fabs(below) < k_tiny) below = k_tiny;
      below = 1 / below;
      above = 1 + coefficient / above;
      if (std::fabs(above) < k_tiny) above = k_tiny;
      change *= above * below;
      value *= above * below;
    }
    if (std::fabs(change - 1) < std::numeric_limits<double>::epsilon()) return 1 / value;
  }
  CHECK(false);
  return 0;
}

/// The probability of a value below x.
double probability_below(const Beta& beta, double x) {
  const double density = scaled_density(beta, x);
  if (x <= (beta.a + 1) / (beta.a + beta.b + 2))
    return density / beta.a * continued_fraction(beta, x);
  return 1 - density / beta.b * continued_fraction({.a = beta.b, .b = beta.a}, 1 - x);
}

}  // namespace

double beta_quantile(const Beta& distribution, double probability) {
  constexpr double k_parameter_max = 1e12;
  constexpr double k_probability_min = 0.01;
  CHECK(distribution.a >= 1 && distribution.a <= k_parameter_max);
  CHECK(distribution.b >= 1 && distribution.b <= k_parameter_max);
  CHECK(probability >= k_probability_min && probability <= 1 - k_probability_min);

  // Newton's steps from the mean; one that leaves the bracket is replaced by a bisection.
  constexpr int k_steps_max = 200;
  constexpr double k_step_min = 4 * std::numeric_limits<double>::epsilon();
  double low = 0;
  double high = 1;
  double x = distribution.a / (distribution.a + distribution.b);
  for (int step = 0; step < k_steps_max; ++step) {
    const double excess = probability_below(distribution, x) - probability;
    (excess > 0 ? high : low) = x;
    double next = x - excess * x * (1 - x) / scaled_density(distribution, x);
    if (!(next > low && next < high)) next = low + (high - low) / 2;
    const double moved = std::fabs(next - x);
    x = next;
    if (moved <= k_step_min * x || high - low <= k_step_min * x) break;
  }
  return x;
}

}  // namespace sleight::sampling
