#include "worker/sampling/independent_chains.h"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <vector>

namespace sleight::sampling {
namespace {

constexpr std::uint64_t k_largest = std::numeric_limits<std::uint64_t>::max();

/// By scans, rounds and independent solutions, as far as given.
StopRule stop_at(std::optional<std::uint64_t> scans, std::optional<std::uint32_t> rounds = {},
                 std::optional<std::uint64_t> solutions = {}) {
  return {.scans = scans, .rounds = rounds, .independent_solutions = solutions};
}

using Units = std::vector<plan::Unit>;

/// Records of which none satisfies, or all do, in one lineage.
std::vector<plan::ScanRecord> records(std::uint64_t count, bool satisfied = false) {
  plan::ScanRecord record;
  record.satisfied = satisfied;
  return std::vector<plan::ScanRecord>(count, record);
}

void complete(IndependentChains& chains, const plan::Unit& unit, bool satisfied = false) {
  chains.consume(unit.replica, unit.first_scan, records(unit.scans, satisfied));
}

plan::ReplicaKey key(std::uint32_t chain) {
  return {base::ChainId{chain}, base::ReplicaId{0}};
}

plan::Unit unit(std::uint32_t chain, std::uint64_t first, std::uint32_t scans) {
  return {.replica = key(chain),
          .first_scan = base::ScanIndex{first},
          .scans = scans,
          .starts = first == 0};
}

TEST(ScansThroughRound, IsTheSumOfDoublingRounds) {
  // Goal: round r has round_scans 2^(r-1) scans; sums beyond 64 bits are the largest count. Method:
  // add them up one by one.
  for (const std::uint64_t round_scans : {std::uint64_t{1}, std::uint64_t{3}, std::uint64_t{64},
                                          std::uint64_t{1'000'000}, k_largest / 3, k_largest}) {
    std::uint64_t sum = 0;
    std::uint64_t length = round_scans;
    for (std::uint32_t rounds = 0; rounds <= 130; ++rounds) {
      EXPECT_EQ(scans_through_round(round_scans, rounds), sum) << round_scans << ", " << rounds;
      sum = sum > k_largest - length ? k_largest : sum + length;
      length = length > k_largest / 2 ? k_largest : 2 * length;
    }
  }
}

TEST(IndependentChains, HandsOutTheFurthestBehindFirst) {
  // Goal: the chain with the fewest scans comes first, the lowest id among equals. Method: complete
  // units out of order and look at who is next.
  IndependentChains chains({.chains = 3, .stop = stop_at(100)});
  EXPECT_EQ(chains.next_unit(10), unit(0, 0, 10));
  EXPECT_EQ(chains.next_unit(20), unit(1, 0, 20));
  EXPECT_EQ(chains.next_unit(5), unit(2, 0, 5));
  complete(chains, unit(1, 0, 20));
  complete(chains, unit(0, 0, 10));
  EXPECT_EQ(chains.next_unit(1), unit(0, 10, 1));
  complete(chains, unit(2, 0, 5));
  EXPECT_EQ(chains.next_unit(30), unit(2, 5, 30));
  EXPECT_EQ(chains.next_unit(1000), unit(1, 20, 80));
  EXPECT_EQ(chains.next_unit(1), std::nullopt);
}

TEST(IndependentChains, OneUnitOfAChainAtATime) {
  // Goal: a chain that is running is not handed out again. Method: ask more often than there are
  // chains.
  IndependentChains chains({.chains = 4, .stop = stop_at(1000)});
  for (int i = 0; i < 4; ++i)
    EXPECT_TRUE(chains.next_unit(1).has_value());
  EXPECT_EQ(chains.next_unit(1), std::nullopt);
  complete(chains, unit(2, 0, 1));
  EXPECT_EQ(chains.next_unit(7), unit(2, 1, 7));
  EXPECT_EQ(chains.next_unit(7), std::nullopt);
}

TEST(IndependentChains, StopsAfterItsScans) {
  // Goal: `scans` counts each chain's scans, the start included. Method: run to the end by units
  // that don't divide it.
  IndependentChains chains({.chains = 2, .stop = stop_at(25)});
  EXPECT_EQ(chains.scans_total(), 50U);
  while (const auto next = chains.next_unit(7)) {
    EXPECT_FALSE(chains.finished());
    complete(chains, *next, true);
  }
  EXPECT_TRUE(chains.finished());
  EXPECT_EQ(chains.scans_common(), 25U);
  EXPECT_EQ(chains.scans_consumed(), 50U);
}

TEST(IndependentChains, StopsAfterItsRounds) {
  // Goal: three rounds of 10, 20 and 40 scans. Method: run to the end.
  IndependentChains chains({.chains = 2, .round_scans = 10, .stop = stop_at({}, 3)});
  EXPECT_EQ(chains.scans_total(), 140U);
  while (const auto next = chains.next_unit(1000))
    complete(chains, *next);
  EXPECT_TRUE(chains.finished());
  EXPECT_EQ(chains.scans_common(), 70U);
}

TEST(IndependentChains, JudgesSolutionsAtRoundEndsOnly) {
  // Goal: solutions are counted when every chain has reached a round's end, and the run stops
  // there, not where the last one was found. Method: chain 0 satisfies in its first scan; nothing
  // is handed out beyond round ends (10, 30) before all are there.
  IndependentChains chains({.chains = 2, .round_scans = 10, .stop = stop_at({}, {}, 2)});
  EXPECT_EQ(chains.scans_total(), std::nullopt);
  EXPECT_EQ(chains.next_unit(100), unit(0, 0, 10));
  complete(chains, unit(0, 0, 10), true);
  EXPECT_EQ(chains.next_unit(100), unit(1, 0, 10));
  EXPECT_EQ(chains.next_unit(100), std::nullopt);
  complete(chains, unit(1, 0, 10), false);
  EXPECT_FALSE(chains.finished());
  EXPECT_EQ(chains.next_unit(100), unit(0, 10, 20));
  complete(chains, unit(0, 10, 20), true);
  EXPECT_EQ(chains.next_unit(5), unit(1, 10, 5));
  complete(chains, unit(1, 10, 5), true);
  EXPECT_FALSE(chains.finished());
  EXPECT_EQ(chains.next_unit(100), unit(1, 15, 15));
  complete(chains, unit(1, 15, 15), false);
  EXPECT_TRUE(chains.finished());
  EXPECT_EQ(chains.scans_common(), 30U);
  EXPECT_EQ(chains.scans_total(), 60U);
  EXPECT_EQ(chains.next_unit(100), std::nullopt);
}

TEST(IndependentChains, CountsALineageOnce) {
  // Goal: a solution is a lineage. Method: one chain, satisfied scans of lineages 0, 0, 3, 3, 4.
  IndependentChains chains({.chains = 1, .round_scans = 4, .stop = stop_at({}, {}, 3)});
  std::vector<plan::ScanRecord> scans = records(12, true);
  for (std::size_t i = 0; i < scans.size(); ++i)
    scans[i].lineage = i < 3 ? 0 : i < 9 ? 3 : 4;
  EXPECT_EQ(chains.next_unit(100)->scans, 4U);
  chains.consume(key(0), base::ScanIndex{0}, std::span(scans).first(4));
  EXPECT_FALSE(chains.finished());
  EXPECT_EQ(chains.next_unit(100)->scans, 8U);
  chains.consume(key(0), base::ScanIndex{4}, std::span(scans).subspan(4));
  EXPECT_TRUE(chains.finished());
  EXPECT_EQ(chains.scans_common(), 12U);
}

TEST(IndependentChains, FirstRuleThatHoldsWins) {
  // Goal: the least of the rules' ends. Method: pairs of rules, each pair in both orders.
  const auto end_of = [](const StopRule& stop) {
    IndependentChains chains({.chains = 2, .round_scans = 10, .stop = stop});
    while (const auto next = chains.next_unit(6))
      complete(chains, *next, next->first_scan.value + next->scans > 25);
    EXPECT_TRUE(chains.finished());
    return chains.scans_common();
  };
  EXPECT_EQ(end_of(stop_at(29, 2)), 29U);
  EXPECT_EQ(end_of(stop_at(31, 2)), 30U);
  EXPECT_EQ(end_of(stop_at({}, {}, 2)), 30U);
  EXPECT_EQ(end_of(stop_at(29, {}, 2)), 29U);
  EXPECT_EQ(end_of(stop_at(30, {}, 2)), 30U);
  EXPECT_EQ(end_of(stop_at(500, {}, 2)), 30U);
  EXPECT_EQ(end_of(stop_at({}, 1, 2)), 10U);
  EXPECT_EQ(end_of(stop_at(100, 9, 3)), 100U);
}

TEST(IndependentChains, ManyChainsStayFast) {
  // Goal: 65,536 chains cost little each, also when all are handed out at once. Method: two units
  // of each, with as many units outstanding as there are chains; a cost that grows with their
  // square would take minutes.
  constexpr std::uint32_t k_chains = 65'536;
  IndependentChains chains({.chains = k_chains, .round_scans = 1, .stop = stop_at({}, 2, 1)});
  const auto begin = std::chrono::steady_clock::now();
  for (int round = 0; round < 2; ++round) {
    Units units;
    while (const auto next = chains.next_unit(100))
      units.push_back(*next);
    EXPECT_EQ(units.size(), k_chains);
    for (const plan::Unit& done : units)
      complete(chains, done);
  }
  EXPECT_TRUE(chains.finished());
  EXPECT_EQ(chains.scans_consumed(), 3U * k_chains);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST(IndependentChainsDeathTest, MisuseIsABug) {
  // Goal: a plan without an end, and results that don't continue a chain, stop the process. Method:
  // each of them.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(IndependentChains({.chains = 2, .stop = stop_at({})}), "check failed");
  EXPECT_DEATH(IndependentChains({.chains = 0, .stop = stop_at(1)}), "check failed");
  EXPECT_DEATH(IndependentChains({.round_scans = 0, .stop = stop_at(1)}), "check failed");
  IndependentChains chains({.chains = 2, .stop = stop_at(9)});
  EXPECT_DEATH(chains.next_unit(0), "check failed");
  EXPECT_DEATH(complete(chains, unit(0, 1, 1)), "first_scan.*1 against 0");
  EXPECT_DEATH(complete(chains, unit(2, 0, 1)), "2 against 2");
}

}  // namespace
}  // namespace sleight::sampling
