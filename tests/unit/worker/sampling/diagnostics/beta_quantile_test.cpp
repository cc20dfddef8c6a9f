// Goal: the beta quantile is exact for the parameters of standard errors of quantiles. Method:
// Boost.Math's inverse as oracle, over parameters from 1 to 1e7, and closed forms at the borders.
#include "worker/sampling/diagnostics/beta_quantile.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/beta.hpp>
#include <cmath>

namespace sleight::sampling {
namespace {

constexpr double k_probabilities[] = {0.01, 0.1586553, 0.5, 0.8413447, 0.99};

TEST(BetaQuantile, is_boosts) {
  for (const double count : {0.5, 3.0, 17.0, 400.0, 12345.6, 1e7}) {
    for (const double share : {0.0, 0.001, 0.05, 0.25, 0.5, 0.9, 1.0}) {
      const Beta beta{.a = count * share + 1, .b = count * (1 - share) + 1};
      for (const double probability : k_probabilities) {
        const double exact = boost::math::ibeta_inv(beta.a, beta.b, probability);
        EXPECT_NEAR(beta_quantile(beta, probability), exact, 1e-12 * exact + 1e-16)
            << beta.a << ' ' << beta.b << ' ' << probability;
      }
    }
  }
}

TEST(BetaQuantile, has_closed_forms_where_a_parameter_is_1) {
  // Goal: the oracle itself is not believed alone. Method: x^a = p, 1 - (1 - x)^b = p.
  for (const double parameter : {1.0, 2.0, 10.0, 1000.0}) {
    for (const double p : k_probabilities) {
      EXPECT_NEAR(beta_quantile({.a = parameter, .b = 1}, p), std::pow(p, 1 / parameter), 1e-13);
      const double low = -std::expm1(std::log1p(-p) / parameter);
      EXPECT_NEAR(beta_quantile({.a = 1, .b = parameter}, p), low, 1e-12 * low);
    }
  }
}

TEST(BetaQuantileDeathTest, refuses_what_it_does_not_cover) {
  // Goal: the REQUIRES are checked. Method: one parameter beyond each limit.
  EXPECT_DEATH(beta_quantile({.a = 0.5, .b = 2}, 0.5), "check failed");
  EXPECT_DEATH(beta_quantile({.a = 2, .b = 1e13}, 0.5), "check failed");
  EXPECT_DEATH(beta_quantile({.a = 2, .b = 2}, 0.009), "check failed");
}

}  // namespace
}  // namespace sleight::sampling
