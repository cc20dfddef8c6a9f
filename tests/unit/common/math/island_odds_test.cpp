#include "common/math/island_odds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/random/linear_distributions.h"
#include "common/random/stream.h"
#include "tests/support/numbers.h"

namespace sleight::math {
namespace {

std::vector<double> logs_of(const std::vector<double>& estimates, double shift = 0) {
  std::vector<double> logs;
  for (const double estimate : estimates)
    logs.push_back(std::log(estimate) + shift);
  return logs;
}

TEST(IslandOdds, AreMeanErrorAndShare) {
  // Goal: the mean, its error and the largest share have their textbook values, even if the
  // estimates underflow a double. The order of islands doesn't matter. Method: use the estimates 1,
  // 2, 3 and 6, whose mean is 3 and whose variance is 14/3. Multiply the estimates by very small
  // and very large factors.
  for (const double shift : {0.0, -207.0, -5000.0, 5000.0}) {
    for (const std::vector<double>& estimates :
         {std::vector{1.0, 2.0, 3.0, 6.0}, std::vector{6.0, 3.0, 1.0, 2.0}}) {
      const IslandOdds odds = island_odds(logs_of(estimates, shift));
      EXPECT_EQ(odds.islands, 4U);
      EXPECT_NEAR(odds.log_mean, std::log(3) + shift, 1e-12 * (1 + std::abs(shift)));
      EXPECT_NEAR(odds.relative_sd, std::sqrt(14.0 / 3) / 3, 1e-11);
      EXPECT_NEAR(odds.log_error(), std::sqrt(14.0 / 3) / 3 / 2, 1e-11);
      EXPECT_NEAR(odds.log_error_of(16), std::sqrt(14.0 / 3) / 3 / 4, 1e-11);
      EXPECT_NEAR(odds.largest_share, 0.5, 1e-11);
    }
  }
}

TEST(IslandOdds, IslandsWithoutASolutionCount) {
  // Goal: if an island's estimate is 0, the island still counts in the mean and in the error.
  // Method: use the estimates 0, 1, 0 and 1, whose mean is 1/2 and whose variance is 1/3. Then use
  // four zeros.
  const IslandOdds half = island_odds(logs_of({0, 1, 0, 1}, -300));
  EXPECT_NEAR(half.log_mean, std::log(0.5) - 300, 1e-11);
  EXPECT_NEAR(half.relative_sd, 2 / std::sqrt(3.0), 1e-12);
  const IslandOdds none = island_odds(logs_of({0, 0, 0, 0}));
  EXPECT_EQ(none.islands, 4U);
  EXPECT_EQ(none.log_mean, -k_infinity);
  EXPECT_TRUE(std::isnan(none.relative_sd));
  EXPECT_TRUE(std::isnan(none.largest_share));
}

TEST(IslandOdds, WhatCannotBeSaidIsNaN) {
  // Goal: the odds are unknown if there are too few islands or if an estimate is invalid.
  EXPECT_TRUE(std::isnan(island_odds({}).log_mean));
  const IslandOdds one = island_odds(logs_of({2}));
  EXPECT_NEAR(one.log_mean, std::log(2), 1e-15);
  EXPECT_EQ(one.largest_share, 1);
  EXPECT_TRUE(std::isnan(one.log_error()));
  for (const double bad : {std::nan(""), k_infinity}) {
    std::vector<double> logs(100, -3);
    EXPECT_TRUE(island_odds(logs).known());
    logs[50] = bad;
    EXPECT_TRUE(std::isnan(island_odds(logs).log_mean));
    EXPECT_FALSE(island_odds(logs).known());
  }
  EXPECT_FALSE(island_odds(std::vector<double>(100, -k_infinity)).known());
}

TEST(IslandOdds, EqualIslandsHaveNoError) {
  // Goal: if all estimates are equal, the error is 0. Rounding can't make the variance negative.
  for (const double log_estimate : {0.0, -0.1, -207.3, 1e300, -1e300}) {
    const IslandOdds odds = island_odds(std::vector<double>(177, log_estimate));
    EXPECT_TRUE(odds.known());
    EXPECT_NEAR(odds.relative_sd, 0, 1e-7);
    EXPECT_NEAR(odds.log_mean, log_estimate, 1e-14 * std::abs(log_estimate) + 1e-14);
  }
}

TEST(IslandOdds, KnownTakesEnoughIslandsAndNoLargeOne) {
  // Goal: the odds are known only if there are enough islands and no island has too large a share.
  // Method: test both sides of each limit. All estimates but one are 1.
  const auto odds = [](std::size_t count, double largest) {
    std::vector<double> estimates(count, 1);
    estimates[count / 2] = largest;
    return island_odds(logs_of(estimates));
  };
  EXPECT_TRUE(odds(k_islands_min, 1).known());
  EXPECT_FALSE(odds(k_islands_min - 1, 1).known());
  EXPECT_TRUE(odds(101, 11.1).known());   // the sum is 111.1
  EXPECT_FALSE(odds(101, 11.2).known());  // the sum is 111.2
}

TEST(IslandSums, AreThoseOfAllAtOnce) {
  // Goal: the running sums give the odds that sums in long double give, wherever the largest
  // estimate occurs. Method: add normally distributed logarithms in random, ascending and
  // descending order.
  random::Stream stream({.seed = 40417, .purpose = random::Purpose::prior}, 0);
  std::vector<double> logs;
  for (int i = 0; i < 500; ++i)
    logs.push_back(random::Normal{.mean = -80, .sd = 2}.draw(stream));
  long double sum = 0;
  long double squares = 0;
  for (const double log_estimate : logs) {
    const long double estimate = std::exp(static_cast<long double>(log_estimate) + 80);
    sum += estimate;
    squares += estimate * estimate;
  }
  const long double mean = sum / 500;
  const long double variance = (squares - 500 * mean * mean) / 499;
  std::vector<double> ascending = logs;
  std::sort(ascending.begin(), ascending.end());
  for (const std::vector<double>& order :
       {logs, ascending, std::vector<double>(ascending.rbegin(), ascending.rend())}) {
    IslandSums sums;
    for (const double log_estimate : order)
      sums.add(log_estimate);
    const IslandOdds odds = sums.odds();
    EXPECT_NEAR(odds.log_mean, static_cast<double>(std::log(mean)) - 80, 1e-12);
    EXPECT_NEAR(odds.relative_sd, static_cast<double>(std::sqrt(variance) / mean), 1e-10);
  }
}

}  // namespace
}  // namespace sleight::math
