// Tests cases in which the measures are undefined. golden_test.cpp compares values with R.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/numbers.h"
#include "tests/unit/worker/sampling/diagnostics/made_chains.h"
#include "worker/sampling/diagnostics/effective_sample_size.h"
#include "worker/sampling/diagnostics/r_hat.h"

namespace sleight::sampling {
namespace {

using testing::changed;
using testing::made;

TEST(Nan, is_the_answer_where_there_is_none) {
  // Goal: a measure is NaN if one of the documented reasons applies. Method: test one array for
  // each reason: a NaN, an infinity, equal values, values whose variance overflows, and a single
  // draw per chain.
  const OwnedChains draws = made({.chains = 2, .draws = 21});
  const auto with = [&](std::size_t at, double value) {
    OwnedChains other = draws;
    other.values[at] = value;
    return other;
  };
  for (const double bad : {k_nan, k_infinity}) {
    const OwnedChains spoilt = with(3, bad);
    EXPECT_TRUE(std::isnan(ess_mean(spoilt.view())));
    EXPECT_TRUE(std::isnan(ess_tail(spoilt.view())));
    EXPECT_EQ(std::isnan(r_hat(spoilt.view())), std::isnan(bad)) << "infinities have ranks";
    EXPECT_EQ(std::isnan(ess_bulk(spoilt.view())), std::isnan(bad));
    // The middle draw of 21 belongs to neither half.
    EXPECT_FALSE(std::isnan(ess_mean(with(10, bad).view())));
    EXPECT_TRUE(std::isnan(mcse_mean(with(10, bad).view())));
  }
  const OwnedChains constant = changed(draws, [](double, std::size_t) { return 0.1; });
  EXPECT_TRUE(std::isnan(r_hat(constant.view())));
  EXPECT_TRUE(std::isnan(ess_bulk(constant.view())));
  const OwnedChains huge = changed(draws, [](double x, std::size_t) { return 1e200 * x; });
  EXPECT_TRUE(std::isnan(ess_mean(huge.view()))) << "the variance overflows";
  EXPECT_FALSE(std::isnan(ess_bulk(huge.view())));
  const OwnedChains one = made({.chains = 4, .draws = 1});
  EXPECT_TRUE(std::isnan(r_hat(one.view())));
  EXPECT_TRUE(std::isnan(ess_bulk(one.view())));
}

TEST(Shapes, must_fit) {
  // Goal: a measure stops the process if its view has a wrong number of values or no draws, or if
  // the quantile is above 1.
  const std::vector<double> five(5, 1.0);
  EXPECT_DEATH(r_hat({.values = five, .chains = 2, .draws = 3}), "check failed");
  EXPECT_DEATH(ess_mean({.values = {}, .chains = 1, .draws = 0}), "check failed");
  EXPECT_DEATH(ess_quantile({.values = five, .chains = 1, .draws = 5}, 1.1), "check failed");
}

}  // namespace
}  // namespace sleight::sampling
