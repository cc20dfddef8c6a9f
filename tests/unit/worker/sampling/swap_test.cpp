#include "worker/sampling/swap.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "tests/support/numbers.h"

namespace sleight::sampling {
namespace {

double ratio(double beta, double cooler_beta, double l, double cooler_l) {
  return log_swap_ratio({.hotter = beta,
                         .cooler = cooler_beta,
                         .log_constraint_hotter = l,
                         .log_constraint_cooler = cooler_l});
}

TEST(LogSwapRatio, IsTheRatioOfTheSwappedDensities) {
  // Goal: for a hotter level b and a cooler level c, the ratio is p_b(x_c) p_c(x_b) / (p_b(x_b)
  // p_c(x_c)). Method: compare the ratio's log with a sum of the four log densities. Some swaps
  // improve the cooler level's state, and some worsen it.
  for (const auto& [l, cooler_l] : {std::pair{-1.5, -4.0}, {-4.0, -1.5}, {0.0, 7.0}, {2.0, 2.0}}) {
    const double by_hand = 0.2 * cooler_l + 0.7 * l - (0.2 * l + 0.7 * cooler_l);
    EXPECT_NEAR(ratio(0.2, 0.7, l, cooler_l), by_hand, 1e-15);
  }
}

TEST(LogSwapRatio, KnowsStatesWithoutDensity) {
  // Goal: a state that breaks a hard constraint never moves to a cooler level, unless neither state
  // has density. No ratio is NaN, even at inverse temperature 0.
  for (const double beta : {0.0, 0.3}) {
    EXPECT_EQ(ratio(beta, 1, -k_infinity, -2), -k_infinity);
    EXPECT_EQ(ratio(beta, 1, -2, -k_infinity), k_infinity);
    EXPECT_EQ(ratio(beta, 1, -k_infinity, -k_infinity), 0);
  }
}

TEST(EvenOddPartner, PairsTheLevelsOfTheScansParity) {
  // Goal: after scan s, levels i and i + 1 are partners exactly if i + s is even. Method: compare
  // the partners of all levels with a list of pairs. Use ladders of several lengths and scans of
  // both parities.
  for (const std::uint32_t levels : {2U, 3U, 4U, 7U}) {
    for (const std::uint64_t scan : {0U, 1U, 2U, 1001U}) {
      std::set<std::pair<std::uint32_t, std::uint32_t>> expected;
      for (std::uint32_t i = scan % 2; i + 1 < levels; i += 2) {
        expected.emplace(i, i + 1);
        expected.emplace(i + 1, i);
      }
      std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
      for (std::uint32_t level = 0; level < levels; ++level) {
        if (const auto partner = even_odd_partner(level, scan, levels))
          pairs.emplace(level, *partner);
      }
      EXPECT_EQ(pairs, expected) << levels << " levels, scan " << scan;
    }
  }
}

TEST(SwapNumber, IsAnotherAtEachPlace) {
  // Goal: if two swaps differ in seed, chain, level or scan, their random numbers differ. Method:
  // change one field of a SwapPlace at a time.
  const SwapPlace place{.seed = 3, .chain = base::ChainId{1}, .level = 2, .scan = 7};
  SwapPlace seed = place;
  SwapPlace chain = place;
  SwapPlace level = place;
  SwapPlace scan = place;
  ++seed.seed;
  ++chain.chain.value;
  ++level.level;
  ++scan.scan;
  std::set<double> numbers;
  for (const SwapPlace& one : {place, seed, chain, level, scan})
    numbers.insert(swap_number(one));
  EXPECT_EQ(numbers.size(), 5U);
  EXPECT_EQ(swap_number(place), swap_number(place));
}

TEST(Swaps, AreAsFrequentAsTheRatio) {
  // Goal: a pair of replicas swaps with probability min(1, ratio). Method: for three pairs, count
  // the swaps in 10,000 scans. One ratio is 0.3, and one is above 1. The third is zero, because the
  // hotter state has no density. The counts must agree within five standard errors.
  const auto count = [](const SwapPair& pair) {
    int swapped = 0;
    for (std::uint64_t scan = 0; scan < 10'000; ++scan)
      swapped += swaps({.seed = 5, .chain = {}, .level = 1, .scan = scan}, pair) ? 1 : 0;
    return swapped;
  };
  SwapPair pair{.hotter = 0.5,
                .cooler = 1,
                .log_constraint_hotter = 2 * math::log(0.3),
                .log_constraint_cooler = 0};
  EXPECT_NEAR(count(pair), 3000, 5 * 46);
  pair.log_constraint_hotter = 1;
  EXPECT_EQ(count(pair), 10'000);
  pair.log_constraint_hotter = -k_infinity;
  EXPECT_EQ(count(pair), 0);
}

}  // namespace
}  // namespace sleight::sampling
