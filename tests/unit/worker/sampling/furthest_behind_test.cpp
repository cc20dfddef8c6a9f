#include "worker/sampling/furthest_behind.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "common/random/stream.h"
#include "tests/support/property.h"

namespace sleight::sampling::furthest_behind_test {

constexpr std::uint64_t k_seed = 20261121;

/// Chains. Each chain can give a limited number of units until it moves.
struct Chains {
  std::vector<std::uint64_t> scans;
  std::vector<std::uint64_t> gifts;  ///< remaining gifts

  std::optional<std::size_t> give(std::size_t chain, std::uint64_t horizon) {
    if (gifts[chain] == 0 || scans[chain] >= horizon) return std::nullopt;
    --gifts[chain];
    return chain;
  }
  std::optional<std::size_t> expected(std::uint64_t horizon) const {
    std::optional<std::size_t> best;
    for (std::size_t chain = 0; chain < scans.size(); ++chain) {
      if (gifts[chain] == 0 || scans[chain] >= horizon) continue;
      if (!best || scans[chain] < scans[*best]) best = chain;
    }
    return best;
  }
  std::size_t going(std::uint64_t horizon) const {
    return static_cast<std::size_t>(
        std::ranges::count_if(scans, [&](std::uint64_t done) { return done < horizon; }));
  }
};

TEST(FurthestBehind, IsWhoASearchFinds) {
  // Goal: among the chains that can give a unit, first() finds the chain with the fewest scans. If
  // several chains have the fewest scans, first() finds the chain with the lowest number. If no
  // chain can give a unit, first() finds none. least(), sum() and going() return the right numbers.
  // Method: in 200 random histories of one to nine chains, compare with a linear search. While the
  // horizon grows, chains advance, give units and run out of units.
  int given = 0;
  int dry = 0;
  for (const std::uint64_t history : property::cases(200)) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, history);
    const auto whole = [&](std::uint64_t first, std::uint64_t last) {
      return first + stream.bits() % (last - first + 1);
    };
    const std::size_t count = whole(1, 9);
    Chains chains{.scans = std::vector<std::uint64_t>(count, 0),
                  .gifts = std::vector<std::uint64_t>(count)};
    for (std::uint64_t& gifts : chains.gifts)
      gifts = whole(0, 3);
    FurthestBehind order(count);
    std::uint64_t horizon = 5;
    for (int step = 0; step < 300; ++step) {
      if (whole(0, 1) == 0) {
        const auto mover = whole(0, count - 1);
        chains.scans[mover] += whole(0, 2);
        chains.gifts[mover] = whole(0, 3);
        order.moved(mover, chains.scans[mover]);
      }
      if (whole(0, 9) == 0) horizon += whole(1, 5);
      const std::optional<std::size_t> expected = chains.expected(horizon);
      const auto found = order.first({.horizon = horizon, .splits = false}, [&](std::size_t chain) {
        return chains.give(chain, horizon);
      });
      ASSERT_EQ(found, expected) << "history " << history << " step " << step;
      ASSERT_EQ(order.least(), std::ranges::min(chains.scans));
      std::uint64_t sum = 0;
      for (const std::uint64_t scans : chains.scans)
        sum += std::min<std::uint64_t>(scans, 5);
      ASSERT_EQ(order.sum(5), sum);
      ASSERT_EQ(order.going(horizon), chains.going(horizon));
      ++(found ? given : dry);
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(given, 1000);
  EXPECT_GT(dry, 1000);
}

TEST(FurthestBehind, AsksNobodyTwiceInVain) {
  // Goal: if a chain has no unit to give, first() asks the chain again only after the chain moves
  // or the query changes. Method: count the calls for chains that never give a unit.
  constexpr std::size_t k_chains = 1000;
  FurthestBehind order(k_chains);
  std::size_t asked = 0;
  const auto nothing = [&](std::size_t) -> std::optional<int> {
    ++asked;
    return std::nullopt;
  };
  EXPECT_FALSE(order.first({.horizon = 9, .splits = false}, nothing));
  EXPECT_EQ(asked, k_chains);
  for (int i = 0; i < 3; ++i)
    EXPECT_FALSE(order.first({.horizon = 9, .splits = false}, nothing));
  EXPECT_EQ(asked, k_chains);
  order.moved(7, 0);
  order.moved(8, 3);
  EXPECT_FALSE(order.first({.horizon = 9, .splits = false}, nothing));
  EXPECT_EQ(asked, k_chains + 2);
  EXPECT_FALSE(order.first({.horizon = 10, .splits = false}, nothing));
  EXPECT_FALSE(order.first({.horizon = 10, .splits = true}, nothing));
  EXPECT_EQ(asked, 3 * k_chains + 2);
}

TEST(FurthestBehind, RefusesWhatCannotBe) {
  // Goal: FurthestBehind stops the process if it has no chains, or if a chain's number of scans
  // decreases.
  EXPECT_DEATH(FurthestBehind(0), "check failed");
  FurthestBehind order(2);
  order.moved(1, 5);
  EXPECT_DEATH(order.moved(1, 4), "check failed");
}

}  // namespace sleight::sampling::furthest_behind_test
