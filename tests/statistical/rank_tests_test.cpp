#include "tests/statistical/support/rank_tests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/random/distributions.h"
#include "tests/statistical/support/ball_fixture.h"

namespace sleight::statistical::rank_tests_test {

constexpr std::uint64_t k_seed = 20261120;

std::vector<double> normals(std::uint32_t chain, std::size_t count, double mean) {
  random::Stream stream = streams_of(k_seed, chain).at(random::Purpose::prior, 0);
  const random::Normal normal{.mean = mean, .sd = 1};
  std::vector<double> draws(count);
  for (double& draw : draws)
    draw = normal.draw(stream);
  return draws;
}

TEST(KolmogorovSmirnov, ItsPValuesAreUniformWhenTheSamplesAreAlike) {
  // Goal: the Kolmogorov-Smirnov test is calibrated. Method: test 500 pairs of samples from one
  // distribution. Compare the p-values with the uniform distribution.
  std::vector<double> p_values;
  for (std::uint32_t i = 0; i < 500; ++i) {
    p_values.push_back(kolmogorov_smirnov_p(normals(2 * i, 400, 0), normals(2 * i + 1, 300, 0)));
  }
  EXPECT_GT(uniformity_p(p_values), 1e-3);
}

TEST(KolmogorovSmirnov, RejectsASmallShift) {
  // Goal: the Kolmogorov-Smirnov test rejects a small shift. Method: shift 10,000 draws by a tenth
  // of a standard deviation, or about seven standard errors.
  EXPECT_LT(kolmogorov_smirnov_p(normals(0, 10000, 0), normals(1, 10000, 0.1)), 1e-6);
}

TEST(KolmogorovSmirnov, HasTheKnownTail) {
  // Goal: p-values have the tail of Kolmogorov's distribution. Method: shift equally spaced values
  // to the tabulated 5% point, 1.3581, and expect p = 0.05. The small-sample correction is below
  // 1e-3.
  const std::size_t n = 1000000;
  const double d = 1.3581 / std::sqrt(static_cast<double>(n));
  std::vector<double> values(n);
  for (std::size_t i = 0; i < n; ++i) {
    values[i] = (static_cast<double>(i) + 1) / static_cast<double>(n) * (1 - d);
  }
  EXPECT_NEAR(uniformity_p(values), 0.05, 1e-3);
}

TEST(EffectiveSampleSize, IsThatOfAnAutoregression) {
  // Goal: the effective sample size accounts for autocorrelation. Method: estimate the
  // autocorrelation time of the process x' = 0.9 x + noise. The exact time is (1 + 0.9) / (1 - 0.9)
  // = 19. From 200,000 steps, the estimate is right to a few percent.
  const std::vector<double> noise = normals(7, 200000, 0);
  std::vector<double> series(noise.size());
  double x = 0;
  for (std::size_t i = 0; i < noise.size(); ++i)
    series[i] = x = 0.9 * x + noise[i];
  EXPECT_NEAR(static_cast<double>(series.size()) / effective_sample_size(series), 19, 2);
}

}  // namespace sleight::statistical::rank_tests_test
