#include "common/math/normal_quantile.h"

#include <array>
#include <cmath>
#include <limits>

#include "common/math/elementary.h"

namespace sleight::math {
namespace {

// Coefficients from the paper. The constant term comes first.
using Polynomial = std::array<double, 8>;

constexpr Polynomial k_central_above = {3.3871328727963666080e0, 1.3314166789178437745e2,
                                        1.9715909503065514427e3, 1.3731693765509461125e4,
                                        4.5921953931549871457e4, 6.7265770927008700853e4,
                                        3.3430575583588128105e4, 2.5090809287301226727e3};
constexpr Polynomial k_central_below = {1.0,
                                        4.2313330701600911252e1,
                                        6.8718700749205790830e2,
                                        5.3941960214247511077e3,
                                        2.1213794301586595867e4,
                                        3.9307895800092710610e4,
                                        2.8729085735721942674e4,
                                        5.2264952788528545610e3};
constexpr Polynomial k_tail_above = {1.42343711074968357734e0,  4.63033784615654529590e0,
                                     5.76949722146069140550e0,  3.64784832476320460504e0,
                                     1.27045825245236838258e0,  2.41780725177450611770e-1,
                                     2.27238449892691845833e-2, 7.74545014278341407640e-4};
constexpr Polynomial k_tail_below = {1.0,
                                     2.05319162663775882187e0,
                                     1.67638483018380384940e0,
                                     6.89767334985100004550e-1,
                                     1.48103976427480074590e-1,
                                     1.51986665636164571966e-2,
                                     5.47593808499534494600e-4,
                                     1.05075007164441684324e-9};
constexpr Polynomial k_far_above = {6.65790464350110377720e0,  5.46378491116411436990e0,
                                    1.78482653991729133580e0,  2.96560571828504891230e-1,
                                    2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                    2.71155556874348757815e-5, 2.01033439929228813265e-7};
constexpr Polynomial k_far_below = {1.0,
                                    5.99832206555887937690e-1,
                                    1.36929880922735805310e-1,
                                    1.48753612908506148525e-2,
                                    7.86869131145613259100e-4,
                                    1.84631831751005468180e-5,
                                    1.42151175831644588870e-7,
                                    2.04426310338993978564e-15};

double value(const Polynomial& coefficients, double x) {
  double sum = 0;
  for (auto next = coefficients.rbegin(); next != coefficients.rend(); ++next)
    sum = sum * x + *next;
  return sum;
}

double ratio(const Polynomial& above, const Polynomial& below, double x) {
  return value(above, x) / value(below, x);
}

}  // namespace

double normal_quantile(double probability) {
  if (!(probability >= 0 && probability <= 1)) return std::numeric_limits<double>::quiet_NaN();
  const double from_median = probability - 0.5;
  constexpr double k_central = 0.425;
  if (std::fabs(from_median) <= k_central) {
    constexpr double k_central_square = 0.180625;  // Not 0.425 * 0.425, which rounds.
    const double x = k_central_square - from_median * from_median;
    return from_median * value(k_central_above, x) / value(k_central_below, x);
  }
  const double tail = from_median < 0 ? probability : 1 - probability;
  if (tail == 0) return std::copysign(std::numeric_limits<double>::infinity(), from_median);
  const double depth = std::sqrt(-math::log(tail));
  const double distance = depth <= 5 ? ratio(k_tail_above, k_tail_below, depth - 1.6)
                                     : ratio(k_far_above, k_far_below, depth - 5);
  return std::copysign(distance, from_median);
}

}  // namespace sleight::math
