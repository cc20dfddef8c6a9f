// Goal: mean_autocovariances(), which uses the fast Fourier transform, equals the definition.
// Method: compare the results with explicit sums for every number of draws up to 40 and for two
// larger numbers. Use odd and even numbers of chains.
#include "worker/sampling/diagnostics/autocovariance.h"

#include <gtest/gtest.h>

#include "tests/unit/worker/sampling/diagnostics/made_chains.h"
#include "worker/sampling/diagnostics/transforms.h"

namespace sleight::sampling {
namespace {

std::vector<double> by_definition(const Chains& draws) {
  std::vector<double> means(draws.draws, 0.0);
  for (std::size_t c = 0; c < draws.chains; ++c) {
    const auto chain = draws.chain(c);
    const double mean = mean_of(chain);
    for (std::size_t t = 0; t < draws.draws; ++t)
      for (std::size_t i = 0; i + t < draws.draws; ++i)
        means[t] += (chain[i] - mean) * (chain[i + t] - mean);
  }
  for (double& value : means)
    value /= static_cast<double>(draws.values.size());
  return means;
}

void expect_alike(const OwnedChains& draws) {
  const std::vector<double> found = mean_autocovariances(draws.view());
  const std::vector<double> expected = by_definition(draws.view());
  ASSERT_EQ(found.size(), draws.draws);
  // The transform's rounding error is about 1e-16 for each of its log2(4 draws) levels. The
  // explicit sums also have rounding errors.
  for (std::size_t t = 0; t < found.size(); ++t)
    ASSERT_NEAR(found[t], expected[t], 1e-14 * expected[0]) << draws.draws << " lag " << t;
}

TEST(MeanAutocovariances, are_those_of_the_definition) {
  for (std::size_t draws = 1; draws <= 40; ++draws)
    for (std::size_t chains = 1; chains <= 4; ++chains)
      expect_alike(testing::made({.seed = draws, .chains = chains, .draws = draws}));
  expect_alike(testing::made({.chains = 5, .draws = 1000, .coefficient = 0.9}));
  expect_alike(testing::made({.chains = 2, .draws = 1025, .coefficient = -0.9}));
}

TEST(MeanAutocovariances, of_constant_chains_are_exactly_zero) {
  for (const std::size_t draws : {3U, 7U, 1000U}) {
    const OwnedChains constant = testing::changed(
        testing::made({.chains = 3, .draws = draws}),
        [](double, std::size_t chain) { return 0.1 + static_cast<double>(chain); });
    for (const double value : mean_autocovariances(constant.view()))
      EXPECT_EQ(value, 0);
  }
}

}  // namespace
}  // namespace sleight::sampling
