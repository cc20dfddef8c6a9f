// Goal: the chi-square test refuses wrong samplers and accepts right samplers. Method: use samplers
// with a wrong scale, a shifted mean or missing tails. Test a right sampler with 200 seeds; the
// p-values must be uniform.
#include "tests/unit/common/random/chi_square.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/normal.hpp>
#include <cmath>

#include "common/random/distributions.h"

namespace sleight::random {
namespace {

double standard_mass(double a, double b) {
  const boost::math::normal_distribution<double> normal;
  const auto cdf = [&](double x) {
    return std::isinf(x) ? (x > 0 ? 1.0 : 0.0) : boost::math::cdf(normal, x);
  };
  return cdf(b) - cdf(a);
}

TEST(ChiSquare, refuses_wrong_samplers) {
  const auto p_of = [](auto draw) { return p_value_of_draws(draw, standard_mass); };
  EXPECT_GT(p_of([](Stream& s) { return Normal{}.draw(s); }), k_p_min);
  EXPECT_LT(p_of([](Stream& s) { return Normal{.mean = 0, .sd = 1.02}.draw(s); }), 1e-12);
  EXPECT_LT(p_of([](Stream& s) { return Normal{.mean = 0.02, .sd = 1}.draw(s); }), 1e-12);
  EXPECT_LT(p_of([](Stream& s) { return std::clamp(Normal{}.draw(s), -1.9, 1.9); }), 1e-12);
  // The sum of twelve uniform numbers was once a popular substitute for a normal number.
  EXPECT_LT(p_of([](Stream& s) {
              double sum = -6;
              for (int i = 0; i < 12; ++i)
                sum += s.uniform();
              return sum;
            }),
            1e-12);
}

TEST(ChiSquare, refuses_biased_and_too_regular_counts) {
  EXPECT_LT(chi_square_p_value({51000, 49000, 50000, 50000}), k_p_min);
  EXPECT_GT(chi_square_p_value(std::vector<int>(64, 3125)), 1 - k_p_min);
}

TEST(ChiSquare, gives_the_textbook_value) {
  // In 60 throws of a die, the faces occur 5, 8, 9, 8, 10 and 20 times. The statistic is 13.4 with
  // 5 degrees of freedom.
  EXPECT_NEAR(chi_square_p_value({5, 8, 9, 8, 10, 20}), 0.0199, 0.0001);
}

TEST(ChiSquare, p_values_of_a_right_sampler_are_uniform) {
  std::vector<int> cells(10);
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Stream stream = test_stream(seed);
    std::vector<int> counts(16);
    for (int i = 0; i < 5000; ++i)
      ++counts[static_cast<std::size_t>(16 * stream.uniform())];
    ++cells[static_cast<std::size_t>(10 * chi_square_p_value(counts))];
  }
  expect_plausible(chi_square_p_value(cells), "p-values");
}

}  // namespace
}  // namespace sleight::random
