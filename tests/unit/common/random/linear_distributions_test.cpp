// Goal: uniform and normal numbers are drawn from their densities. Method: test draws with
// chi-square tests, compare densities with Boost.Math, and integrate the densities. Test invalid
// parameters.
#include "common/random/linear_distributions.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/uniform.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>

#include "tests/support/numbers.h"
#include "tests/unit/common/random/chi_square.h"

namespace sleight::random {
namespace {

constexpr double k_largest = std::numeric_limits<double>::max();

// Returns the probability of an interval. Boost.Math computes it from the smaller tail.
template <class Oracle>
double mass(const Oracle& oracle, double a, double b) {
  const auto [low, high] = boost::math::support(oracle);
  const double from = std::max(a, static_cast<double>(low));
  const double to = std::min(b, static_cast<double>(high));
  if (from > boost::math::median(oracle)) {
    return boost::math::cdf(boost::math::complement(oracle, from)) -
           boost::math::cdf(boost::math::complement(oracle, to));
  }
  return boost::math::cdf(oracle, to) - boost::math::cdf(oracle, from);
}

template <class Distribution, class Oracle>
void expect_agreement(const std::string& name, const Distribution& ours, const Oracle& oracle) {
  expect_plausible(p_value_of_draws([&](Stream& stream) { return ours.draw(stream); },
                                    [&](double a, double b) { return mass(oracle, a, b); }),
                   name);

  for (double p = 0.001; p < 1; p += 0.011) {
    const double x = boost::math::quantile(oracle, p);
    const double expected = std::log(boost::math::pdf(oracle, x));
    EXPECT_NEAR(ours.log_density(x), expected, 1e-13 * (1 + std::fabs(expected))) << name << x;
  }

  // Integrate in units of the standard deviation. Omit a mass of 1e-15 at each end.
  const double mean = boost::math::mean(oracle);
  const double sd = boost::math::standard_deviation(oracle);
  const double low = (boost::math::quantile(oracle, 1e-15) - mean) / sd;
  const double high = (boost::math::quantile(boost::math::complement(oracle, 1e-15)) - mean) / sd;
  const double integral = boost::math::quadrature::gauss_kronrod<double, 61>::integrate(
      [&](double z) { return sd * std::exp(ours.log_density(mean + sd * z)); }, low, high, 10,
      1e-12);
  EXPECT_NEAR(integral, 1, 1e-11) << name;
}

TEST(Uniform, agrees_with_boost) {
  for (const auto& [low, high] :
       {std::pair{0.0, 1.0}, {-3.0, 5.0}, {1e6, 1e6 + 1}, {-1e-100, 0.0}}) {
    expect_agreement("uniform", Uniform{.low = low, .high = high},
                     boost::math::uniform_distribution<double>(low, high));
  }
}

TEST(Uniform, stays_inside_even_where_there_is_no_room) {
  const std::vector<Uniform> narrow = {{1, std::nextafter(1, 2)},
                                       {0, 0x1p-1074},
                                       {-0.1, std::nextafter(-0.1, 0)},
                                       {0.1, 0.3},
                                       {-k_largest / 2, k_largest / 2}};
  Stream stream = test_stream();
  for (const Uniform& uniform : narrow) {
    for (int i = 0; i < 10000; ++i) {
      const double x = uniform.draw(stream);
      ASSERT_GE(x, uniform.low);
      ASSERT_LE(x, uniform.high);
    }
    EXPECT_TRUE(std::isfinite(uniform.log_density(uniform.low)));
    EXPECT_TRUE(std::isfinite(uniform.log_density(uniform.high)));
    EXPECT_EQ(uniform.log_density(std::nextafter(uniform.low, -k_infinity)), -k_infinity);
    EXPECT_EQ(uniform.log_density(std::nextafter(uniform.high, k_infinity)), -k_infinity);
  }
}

TEST(Normal, agrees_with_boost) {
  for (const auto& [mean, sd] :
       {std::pair{0.0, 1.0}, {-3.0, 0.02}, {1e6, 250.0}, {0.0, 1e-100}, {0.0, 1e100}}) {
    expect_agreement("normal", Normal{.mean = mean, .sd = sd},
                     boost::math::normal_distribution<double>(mean, sd));
  }
}

TEST(Normal, density_scales_where_the_square_of_sd_is_no_double) {
  for (const double sd : {1e-300, 1e-200, 1e200, 1e300}) {
    for (const double z : {0.0, 0.5, -3.0, 30.0}) {
      const double expected = Normal{}.log_density(z) - std::log(sd);
      EXPECT_NEAR((Normal{.mean = 0, .sd = sd}.log_density(z * sd)), expected, 1e-12) << sd;
    }
  }
}

TEST(Normal, density_holds_far_out) {
  EXPECT_NEAR(Normal{}.log_density(1e3), -500000.91893853320467, 1e-9);
  EXPECT_EQ(Normal{}.log_density(k_infinity), -k_infinity);
  EXPECT_EQ(Normal{}.log_density(-1e200), -k_infinity);
}

TEST(Normal, neighbouring_draws_are_independent) {
  // Goal: successive normal numbers are independent. Method: count pairs of successive draws in 8 x
  // 8 equally likely cells. Use a chi-square test.
  const boost::math::normal_distribution<double> normal;
  Stream stream = test_stream();
  std::vector<int> counts(64);
  for (int i = 0; i < k_draws; ++i) {
    const double first = boost::math::cdf(normal, Normal{}.draw(stream));
    const double second = boost::math::cdf(normal, Normal{}.draw(stream));
    ++counts[static_cast<std::size_t>(8 * first) * 8 + static_cast<std::size_t>(8 * second)];
  }
  expect_plausible(chi_square_p_value(counts), "pairs");
}

TEST(LinearDistributionsDeathTest, refuse_what_is_no_distribution) {
  Stream stream = test_stream();
  EXPECT_DEATH((Uniform{.low = 1, .high = 1}.draw(stream)), "check failed");
  EXPECT_DEATH((Uniform{.low = 2, .high = 1}.log_density(0)), "check failed");
  EXPECT_DEATH((Uniform{.low = 0, .high = k_nan}.draw(stream)), "check failed");
  EXPECT_DEATH((Uniform{.low = -k_largest, .high = k_largest}.draw(stream)), "check failed");
  EXPECT_DEATH((Normal{.mean = 0, .sd = 0}.draw(stream)), "check failed");
  EXPECT_DEATH((Normal{.mean = 0, .sd = -1}.log_density(0)), "check failed");
  EXPECT_DEATH((Normal{.mean = k_infinity, .sd = 1}.draw(stream)), "check failed");
  EXPECT_DEATH((Normal{.mean = 0, .sd = k_nan}.draw(stream)), "check failed");
  EXPECT_DEATH((Normal{}.log_density(k_nan)), "check failed");
}

}  // namespace
}  // namespace sleight::random
