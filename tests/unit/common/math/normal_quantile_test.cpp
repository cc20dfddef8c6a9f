// Goal: the normal quantile has a relative error below 1e-15 for every probability between 0 and 1.
// Method: compare with Boost.Math. Use common probabilities, tiny probabilities, and probabilities
// where the formula changes.
#include "common/math/normal_quantile.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/normal.hpp>
#include <cmath>

#include "tests/support/numbers.h"

namespace sleight::math {
namespace {

void expect_exact(double probability) {
  const double exact = boost::math::quantile(boost::math::normal(), probability);
  // Boost's own error is below 4e-16.
  EXPECT_NEAR(normal_quantile(probability), exact, 1e-15 * std::fabs(exact)) << probability;
}

TEST(NormalQuantile, is_boosts) {
  for (int i = 1; i < 5000; ++i)
    expect_exact(i / 5000.0);
  for (int exponent = -1; exponent >= -1060; --exponent)
    expect_exact(std::ldexp(0.9, exponent));
  for (const double border : {0.075, 0.925, std::exp(-25)})
    for (const double offset : {-1e-12, 0.0, 1e-12})
      expect_exact(border + offset * border);
}

TEST(NormalQuantile, is_odd_about_the_median) {
  EXPECT_EQ(normal_quantile(0.5), 0);
  for (int i = 1; i < 512; ++i)
    EXPECT_EQ(normal_quantile(i / 1024.0), -normal_quantile(1 - i / 1024.0));
}

TEST(NormalQuantile, has_no_place_outside) {
  EXPECT_EQ(normal_quantile(0), -k_infinity);
  EXPECT_EQ(normal_quantile(1), k_infinity);
  for (const double bad : {-1e-300, 1 + 1e-15, k_infinity, -k_infinity, std::nan("")})
    EXPECT_TRUE(std::isnan(normal_quantile(bad))) << bad;
}

}  // namespace
}  // namespace sleight::math
