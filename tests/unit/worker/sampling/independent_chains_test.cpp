#include "worker/sampling/independent_chains.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace sleight::sampling {
namespace {

constexpr std::uint64_t k_largest = std::numeric_limits<std::uint64_t>::max();

/// Returns a stop rule with the given limits on scans, rounds and independent solutions.
StopRule stop_at(std::optional<std::uint64_t> scans, std::optional<std::uint32_t> rounds = {},
                 std::optional<std::uint64_t> solutions = {}) {
  return {.scans = scans, .rounds = rounds, .independent_solutions = solutions};
}

using Units = std::vector<plan::Unit>;

void complete(IndependentChains& chains, const plan::Unit& unit) {
  chains.consume(unit.replica, unit.first_scan, std::vector<plan::ScanRecord>(unit.scans));
}

plan::Unit unit(std::uint32_t chain, std::uint64_t first, std::uint32_t scans) {
  return {.replica = {base::ChainId{chain}, base::ReplicaId{0}},
          .first_scan = base::ScanIndex{first},
          .scans = scans,
          .starts = first == 0};
}

TEST(ScansThroughRound, IsTheSumOfDoublingRounds) {
  // Goal: scans_through_round() adds the scans of rounds. Round r has round_scans 2^(r-1) scans. If
  // the sum exceeds 64 bits, the function returns the largest 64-bit number.
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

TEST(IndependentChains, ManyChainsStayFast) {
  // Goal: a plan of 65,536 chains needs little time per chain. Method: run one unit of each chain,
  // and then a second unit. A cost that is quadratic in the number of chains would exceed the
  // test's time limit.
  constexpr std::uint32_t k_chains = 65'536;
  IndependentChains chains({.chains = k_chains, .round_scans = 1, .stop = stop_at({}, 2, 1)});
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
}

TEST(IndependentChainsDeathTest, MisuseIsABug) {
  // Goal: a plan without a stop rule, without chains or with empty rounds stops the process. The
  // process also stops if a requested unit has no scans, or if results don't continue a chain.
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
