#include "worker/sampling/ladder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/random/discrete_distributions.h"
#include "tests/support/numbers.h"
#include "tests/support/property.h"

namespace sleight::sampling::ladder_test {

constexpr std::uint64_t k_seed = 161803;

/// Rejection rates between neighbouring levels. The barrier is a known smooth curve.
std::vector<double> differences(const std::vector<double>& ladder, double (*barrier)(double)) {
  std::vector<double> rates;
  for (std::size_t i = 0; i + 1 < ladder.size(); ++i)
    rates.push_back(barrier(ladder[i + 1]) - barrier(ladder[i]));
  return rates;
}

double square_root(double beta) {
  return 3 * std::sqrt(beta);
}
double logarithm(double beta) {
  return std::log1p(50 * beta);
}
double bend(double beta) {
  return 2 * beta + std::sin(3 * beta) / 2;
}

/// A ladder from 0 to 1 whose levels are denser at hot temperatures.
std::vector<double> uneven(std::uint32_t levels) {
  std::vector<double> ladder;
  for (std::uint32_t i = 0; i < levels; ++i)
    ladder.push_back(i / (levels - 1.0) * (i / (levels - 1.0)));
  return ladder;
}

TEST(FirstLadder, LiesCloserWhereItIsHot) {
  // Goal: first_ladder() ascends from 0 to 1 in growing steps, for every number of levels.
  EXPECT_EQ(first_ladder(2), (std::vector<double>{0, 1}));
  for (std::uint32_t levels = k_levels_min; levels <= k_levels_max; ++levels) {
    const std::vector<double> ladder = first_ladder(levels);
    ASSERT_EQ(ladder.size(), levels);
    EXPECT_EQ(ladder.front(), 0);
    EXPECT_EQ(ladder.back(), 1);
    for (std::size_t i = 2; i < levels; ++i)
      EXPECT_GT(ladder[i] - ladder[i - 1], ladder[i - 1] - ladder[i - 2]);
  }
}

TEST(FirstLadder, IsAPowerOfEvenSteps) {
  // Goal: level i of the first ladder is (i / (levels - 1))^power. The second level is above 0 even
  // for a large power. Method: compare the levels with std::pow.
  EXPECT_EQ(first_ladder(5, 1), (std::vector<double>{0, 0.25, 0.5, 0.75, 1}));
  EXPECT_EQ(first_ladder(7), first_ladder(7, 6));
  for (const std::uint32_t power : {1U, 2U, 3U, 6U, 12U}) {
    const std::vector<double> ladder = first_ladder(k_levels_max, power);
    EXPECT_GT(ladder[1], 0);
    for (std::uint32_t i = 0; i < k_levels_max; ++i) {
      const double exact = std::pow(i / (k_levels_max - 1.0), power);
      EXPECT_NEAR(ladder[i], exact, 1e-15 * exact);
    }
  }
}

TEST(LevelsFor, AreTwiceTheBarrierAndOne) {
  // Goal: levels_for() returns twice the barrier plus one, rounded up, but at least 2. If no ladder
  // can serve a barrier, levels_for() returns the maximum.
  EXPECT_EQ(levels_for(0), 2U);
  EXPECT_EQ(levels_for(0.5), 2U);
  EXPECT_EQ(levels_for(0.51), 3U);
  EXPECT_EQ(levels_for(3), 7U);
  EXPECT_EQ(levels_for(3.2), 8U);
  EXPECT_EQ(levels_for(1e9), k_levels_max);
  EXPECT_EQ(levels_for(k_infinity), k_levels_max);
}

TEST(Barrier, IsTheSumOfRejections) {
  // Goal: the cumulative barrier is 0 at the hottest level. From each level to the next cooler
  // level, it grows by the pair's rejection rate.
  EXPECT_EQ(cumulative_barrier(std::vector{0.5, 0.25, 0.125}),
            (std::vector{0.0, 0.5, 0.75, 0.875}));
}

TEST(LocalBarrier, IsTheSlope) {
  // Goal: local_barrier() returns the slope of the cumulative barrier. The slope is exact for a
  // straight line, close for a smooth curve, and never negative. Method: on an uneven ladder of 41
  // levels, compare with the slopes of known curves. The error of a three-point slope is of second
  // order in the spacing, which is at most 1/20.
  const std::vector<double> ladder = uneven(41);
  const std::vector<double> line =
      local_barrier(ladder, differences(ladder, [](double beta) { return 2.5 * beta; }));
  for (const double slope : line)
    EXPECT_NEAR(slope, 2.5, 1e-12);
  const std::vector<double> curve = local_barrier(ladder, differences(ladder, bend));
  for (std::size_t i = 1; i + 1 < ladder.size(); ++i)
    EXPECT_NEAR(curve[i], 2 + 1.5 * std::cos(3 * ladder[i]), 5e-3) << ladder[i];
  for (const double slope : local_barrier(ladder, std::vector<double>(40, 0.0)))
    EXPECT_EQ(slope, 0);
}

TEST(Respaced, CutsAKnownBarrierIntoEqualParts) {
  // Goal: the barrier grows equally between the levels that respaced() returns. Method: use ladders
  // of 200 levels with known barriers. Respace them to fewer levels and to more levels. One barrier
  // has an infinite slope at 0. The tolerance covers the error of a monotone cubic through 200
  // points.
  const std::vector<double> ladder = uneven(200);
  for (const auto& barrier : {square_root, logarithm, bend}) {
    for (const std::uint32_t levels : {2U, 3U, 8U, 33U, 250U}) {
      const std::vector<double> even = respaced(ladder, differences(ladder, barrier), levels);
      ASSERT_EQ(even.size(), levels);
      const double part = barrier(1) / (levels - 1.0);
      for (std::size_t i = 0; i + 1 < levels; ++i)
        EXPECT_NEAR(barrier(even[i + 1]) - barrier(even[i]), part, 2e-3 * barrier(1)) << levels;
    }
  }
}

TEST(Respaced, IsAtRestWhenAllRejectionsAreEqual) {
  // Goal: if all rejection rates are equal, respaced() returns the same ladder, up to rounding.
  // Method: test several rates on a ladder of uneven levels.
  for (const double rate : {0.0, 1e-6, 0.3, 0.5, 1.0}) {
    const std::vector<double> ladder{0, 1e-9, 0.01, 0.5, 0.501, 1};
    const std::vector<double> same = respaced(ladder, std::vector<double>(5, rate), 6);
    for (std::size_t i = 0; i < ladder.size(); ++i)
      EXPECT_NEAR(same[i], ladder[i], 1e-14 + 1e-9 * ladder[i]) << rate;
  }
}

TEST(Respaced, IsALadderWhateverTheRates) {
  // Goal: the levels that respaced() returns ascend from 0 to 1 without ties, for any rejection
  // rates. Method: respace random ladders for 20 rounds, with random rates and random numbers of
  // levels. In the worst case, a hard constraint puts the whole barrier at the hot end, so levels
  // crowd near 0.
  for (const std::uint64_t index : property::cases(200)) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, index);
    const bool hard = index % 4 == 0;
    std::vector<double> ladder = first_ladder(static_cast<std::uint32_t>(2 + stream.bits() % 30));
    for (int round = 0; round < 20; ++round) {
      std::vector<double> rates;
      for (std::size_t i = 0; i + 1 < ladder.size(); ++i) {
        const double u = stream.uniform();
        const double random_rate = u < 0.2 ? 0 : u > 0.9 ? 1 : stream.uniform();
        rates.push_back(hard ? (i == 0 ? 0.999 : 0.0) : random_rate);
      }
      const auto levels = static_cast<std::uint32_t>(2 + stream.bits() % 30);
      ladder = respaced(ladder, rates, levels);
      ASSERT_EQ(ladder.size(), levels);
      ASSERT_EQ(ladder.front(), 0);
      ASSERT_EQ(ladder.back(), 1);
      ASSERT_EQ(std::ranges::adjacent_find(ladder, std::greater_equal<>{}), ladder.end());
    }
  }
}

TEST(PredictedRoundTripRate, IsTheFormula) {
  // Goal: the predicted round-trip rate is 1 / (2 + 2 sum r / (1 - r)) (Syed et al. 2022, corollary
  // 2). Without rejections, a trip takes two scans. A rejection rate of 1 prevents trips.
  EXPECT_EQ(predicted_round_trip_rate(std::vector{0.0, 0.0, 0.0}), 0.5);
  EXPECT_EQ(predicted_round_trip_rate(std::vector{0.5, 0.75}), 1 / (2 + 2 * (1.0 + 3.0)));
  EXPECT_EQ(predicted_round_trip_rate(std::vector{0.5, 1.0}), 0);
}

TEST(Interpolated, IsStraightBetweenLevels) {
  // Goal: interpolated() is exact at all levels, including both ends, and linear between them.
  const std::vector<double> ladder{0, 0.25, 1};
  const std::vector<double> values{4, 2, 5};
  EXPECT_EQ(interpolated(ladder, values, 0), 4);
  EXPECT_EQ(interpolated(ladder, values, 0.125), 3);
  EXPECT_EQ(interpolated(ladder, values, 0.25), 2);
  EXPECT_EQ(interpolated(ladder, values, 0.75), 4);
  EXPECT_EQ(interpolated(ladder, values, 1), 5);
}

}  // namespace sleight::sampling::ladder_test
