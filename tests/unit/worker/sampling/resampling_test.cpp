#include "worker/sampling/resampling.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "worker/sampling/island_weights.h"

namespace sleight::sampling::resampling_test {

using Ancestors = std::vector<std::uint32_t>;

random::Stream stream_of(std::uint64_t draw) {
  return random::Stream({.seed = 5, .purpose = random::Purpose::resampling}, draw);
}

const std::vector<std::vector<double>> k_shares{
    {0.5, 0.3, 0.2}, {0.1, 0.9}, {0.25, 0, 0.4, 0.35}, {1, 0, 0}, {1}, {0.02, 0.38, 0.2, 0.2, 0.2}};

TEST(Resampling, EachPlaceIsAsLikelyAsTheWeight) {
  // Goal: each new particle descends from particle m with probability W_m, the weight of m.
  // Particle m has W_m * count descendants, rounded down or up. Method: count descendants in 20,000
  // draws. The descendants' shares must equal the weights, within 5 standard errors.
  constexpr int k_draws = 20'000;
  for (const std::vector<double>& shares : k_shares) {
    const std::size_t count = shares.size();
    std::vector<std::vector<int>> counts(count, std::vector<int>(count, 0));
    for (int draw = 0; draw < k_draws; ++draw) {
      random::Stream stream = stream_of(static_cast<std::uint64_t>(draw));
      const Ancestors ancestors = resampled(shares, stream);
      ASSERT_EQ(ancestors.size(), count);
      std::vector<int> descendants(count, 0);
      for (std::size_t n = 0; n < count; ++n) {
        ++counts[n][ancestors[n]];
        ++descendants[ancestors[n]];
      }
      for (std::size_t m = 0; m < count; ++m)
        ASSERT_LT(std::abs(descendants[m] - static_cast<double>(count) * shares[m]), 1 + 1e-9);
    }
    for (std::size_t n = 0; n < count; ++n) {
      for (std::size_t m = 0; m < count; ++m) {
        const double error = std::sqrt(shares[m] * (1 - shares[m]) / k_draws);
        EXPECT_NEAR(counts[n][m] / double{k_draws}, shares[m], 5 * error) << n << " from " << m;
      }
    }
  }
}

TEST(Resampling, ConditionalDrawsAreThoseWithTheFirstFromTheFirst) {
  // Goal: resampled_with_first() has the distribution of those results of resampled() in which
  // place 0 descends from particle 0. Method: make 20,000 draws with each function, and reject
  // draws of resampled() that don't meet the condition. Compare the counts of each outcome, within
  // 5 standard errors.
  constexpr int k_draws = 20'000;
  for (const std::vector<double>& shares : k_shares) {
    std::map<Ancestors, std::array<int, 2>> counts;
    for (int draw = 0; draw < k_draws; ++draw) {
      random::Stream stream = stream_of(static_cast<std::uint64_t>(draw));
      const Ancestors conditional = resampled_with_first(shares, stream);
      ASSERT_EQ(conditional[0], 0U);
      ++counts[conditional][0];
    }
    int found = 0;
    for (std::uint64_t draw = k_draws; found < k_draws; ++draw) {
      random::Stream stream = stream_of(draw);
      const Ancestors free = resampled(shares, stream);
      if (free[0] != 0) continue;
      ++counts[free][1];
      ++found;
    }
    for (const auto& [ancestors, seen] : counts) {
      const double error = std::sqrt(seen[0] + seen[1] + 1.0);
      EXPECT_LT(std::abs(seen[0] - seen[1]), 5 * error) << testing::PrintToString(ancestors);
    }
  }
}

TEST(Resampling, SizesOfWeights) {
  // Goal: the effective size of equal weights is their number, and the effective size of a single
  // weight is one.
  EXPECT_DOUBLE_EQ(effective_size(std::vector<double>{0.25, 0.25, 0.25, 0.25}), 4);
  EXPECT_DOUBLE_EQ(effective_size(std::vector<double>{0, 1, 0}), 1);
  EXPECT_DOUBLE_EQ(effective_size(std::vector<double>{0.5, 0.5, 0}), 2);
}

TEST(IslandWeights, MeansGoIntoZ) {
  // Goal: the estimate of Z is the product of the mean weights. Dead particles count as zero
  // weights.
  IslandWeights weights(4);
  EXPECT_DOUBLE_EQ(weights.log_z(), 0);
  weights.add(0, std::log(3.0));
  weights.kill(1);
  EXPECT_TRUE(weights.is_dead(1));
  EXPECT_NEAR(weights.log_z(), std::log(1.25), 1e-12);  // (3 + 0 + 1 + 1) / 4
  EXPECT_NEAR(weights.shares()[0], 0.6, 1e-12);
  EXPECT_EQ(weights.shares()[1], 0);
  weights.start_again();
  EXPECT_FALSE(weights.is_dead(1));
  weights.add(2, -1e4);
  EXPECT_NEAR(weights.log_z(), std::log(1.25) + std::log(0.75), 1e-12);
  for (std::size_t n = 0; n < 4; ++n)
    weights.kill(n);
  EXPECT_TRUE(weights.all_dead());
  EXPECT_EQ(weights.log_z(), k_log_zero);
}

}  // namespace sleight::sampling::resampling_test
