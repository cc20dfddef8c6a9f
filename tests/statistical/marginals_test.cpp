// Tests that long chains of the 2D ball agree with rejection sampling from the prior. The chains
// start from exact draws. If chains started from the prior, 2 to 3% of them would stay in a
// negligible local mode for longer than any test (docs/THESIS). Staying there would be a failure of
// mixing, not of correctness.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/statistical/support/ball_fixture.h"
#include "tests/statistical/support/broken_kernels.h"
#include "tests/statistical/support/rank_tests.h"

namespace sleight::statistical::marginals_test {

constexpr std::uint64_t k_seed = 535897;
constexpr std::uint32_t k_chains = 400;
constexpr std::uint64_t k_iterations = 1000;
constexpr std::size_t k_exact_draws = 100000;

/// Number of statistics per function: the function, its square, and five indicators. An indicator
/// tells whether the function is below a threshold, so its mean is the marginal's distribution
/// function.
constexpr std::size_t k_per_function = 7;
constexpr std::size_t k_statistics = k_ball_functions * k_per_function;

struct Thresholds {
  std::array<std::array<double, 5>, k_ball_functions> at{};
};

std::array<double, k_statistics> statistics(const BallSample& sample, const Thresholds& below) {
  std::array<double, k_statistics> values{};
  const auto functions = ball_functions(sample);
  for (std::size_t f = 0; f < k_ball_functions; ++f) {
    values[f * k_per_function] = functions[f];
    values[f * k_per_function + 1] = functions[f] * functions[f];
    for (std::size_t q = 0; q < 5; ++q) {
      values[f * k_per_function + 2 + q] = functions[f] <= below.at[f][q] ? 1 : 0;
    }
  }
  return values;
}

std::vector<BallSample> exact_draws(const Ball& ball) {
  std::vector<BallSample> draws;
  for (std::size_t i = 0; i < k_exact_draws; ++i) {
    random::Stream stream =
        streams_of(k_seed, 1000 + static_cast<std::uint32_t>(i)).at(random::Purpose::prior, 0);
    draws.push_back(exact_draw(ball, 1.0, stream));
  }
  return draws;
}

/// Returns thresholds near the 5, 25, 50, 75 and 95% points. A part of the exact draws gives the
/// thresholds.
Thresholds thresholds_of(const std::vector<BallSample>& draws) {
  Thresholds thresholds;
  for (std::size_t f = 0; f < k_ball_functions; ++f) {
    std::vector<double> values;
    for (std::size_t i = 0; i < 2000; ++i)
      values.push_back(ball_functions(draws[i])[f]);
    std::sort(values.begin(), values.end());
    thresholds.at[f] = {values[100], values[500], values[1000], values[1500], values[1900]};
  }
  return thresholds;
}

/// Runs chains with this bug, and compares all statistics with the exact draws. Returns the largest
/// |z|.
double largest_z(const Ball& ball, Bug bug, const std::vector<BallSample>& exact) {
  const Thresholds thresholds = thresholds_of(exact);

  std::array<std::vector<double>, k_statistics> exact_series;
  for (const BallSample& sample : exact) {
    const auto values = statistics(sample, thresholds);
    for (std::size_t s = 0; s < k_statistics; ++s)
      exact_series[s].push_back(values[s]);
  }
  std::array<std::vector<std::vector<double>>, k_statistics> chain_series;
  for (auto& series : chain_series)
    series.resize(k_chains);
  for (std::uint32_t chain = 0; chain < k_chains; ++chain) {
    random::Stream start = streams_of(k_seed, chain).at(random::Purpose::prior, 0);
    BallSample sample = exact_draw(ball, 1.0, start);
    for (std::uint64_t iteration = 1; iteration <= k_iterations; ++iteration) {
      step(ball, bug, 1.0, streams_of(k_seed, chain), iteration, sample);
      const auto values = statistics(sample, thresholds);
      for (std::size_t s = 0; s < k_statistics; ++s)
        chain_series[s][chain].push_back(values[s]);
    }
  }
  double largest = 0;
  for (std::size_t s = 0; s < k_statistics; ++s) {
    const MeanWithError chains = mean_over_independent_chains(chain_series[s]);
    const MeanWithError truth = mean_of_independent(exact_series[s]);
    const double error = std::hypot(chains.standard_error, truth.standard_error);
    largest = std::max(largest, std::abs(chains.mean - truth.mean) / error);
  }
  return largest;
}

TEST(Marginals, AgreeWithRejectionSamplingAndABrokenChainDoesNot) {
  // Goal: long chains have the right marginals. The comparison rejects two wrong kernels, although
  // their chains are stationary too. Method: run 400 chains of 1,000 iterations. Compare 56
  // statistics with those of 100,000 exact draws. Standard errors come from the spread of the
  // chains' means, and are valid for any mixing. By chance, any of the 56 differences exceeds 4.5
  // standard errors once in 2,600 runs.
  const Ball ball{worlds::ball_2d::Parameters{}};
  const std::vector<BallSample> exact = exact_draws(ball);
  EXPECT_LT(largest_z(ball, Bug::none, exact), 4.5) << "seed " << k_seed;
  EXPECT_GT(largest_z(ball, Bug::prior_forgotten, exact), 10);
  EXPECT_GT(largest_z(ball, Bug::wrong_temperature, exact), 10);
}

}  // namespace sleight::statistical::marginals_test
