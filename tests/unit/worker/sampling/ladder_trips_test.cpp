#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>

#include "tests/unit/worker/sampling/scans_of.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/ladder_run.h"

namespace sleight::sampling {
namespace {

/// A ladder. Each result is a given function of (inverse temperature, scan).
class Played {
 public:
  using Score = std::function<plan::ScanRecord(double beta, std::uint64_t scan)>;

  Played(const LadderOptions& options, std::uint64_t scans, const Score& score) : run_(options) {
    while (const std::optional<plan::Unit> unit = run_.next_unit(scans)) {
      const std::uint64_t scan = unit->first_scan.value;
      const std::uint32_t replica = unit->replica.replica.value;
      const double beta = unit->inverse_temperatures.front();
      plan::ScanRecord record = score(beta, scan);
      record.inverse_temperature = beta;
      record.lineage = unit->starts || beta == 0 ? plan::lineage_from(unit->replica.replica, scan)
                                                 : unit->lineage;
      EXPECT_EQ(unit->starts, !betas_.contains(replica));
      betas_[replica].push_back(beta);
      lineages_[replica].push_back(record.lineage);
      run_.consume(unit->replica.replica, scan, {&record, 1});
    }
  }
  const LadderRun& run() const { return run_; }
  const std::vector<double>& betas(std::uint32_t replica) { return betas_[replica]; }
  const std::vector<std::uint64_t>& lineages(std::uint32_t replica) { return lineages_[replica]; }

 private:
  LadderRun run_;
  std::map<std::uint32_t, std::vector<double>> betas_;
  std::map<std::uint32_t, std::vector<std::uint64_t>> lineages_;
};

LadderOptions fixed(std::vector<double> ladder, std::uint64_t round_scans = 1000) {
  return {.seed = 1,
          .chain = {},
          .first_ladder = std::move(ladder),
          .levels_chosen = false,
          .levels_max = 64,
          .ladder_adapts = false,
          .has_scale = {},
          .round_scans = round_scans};
}

plan::ScanRecord satisfied_with(double log_constraint) {
  plan::ScanRecord record;
  record.log_constraint = log_constraint;
  record.satisfied = true;
  return record;
}

/// All densities are equal, so every pair always swaps. Every state satisfies the constraint.
plan::ScanRecord always_swaps(double /*beta*/, std::uint64_t /*scan*/) {
  return satisfied_with(-1);
}

/// Cooler replicas have higher densities, so no pair ever swaps.
plan::ScanRecord never_swaps(double beta, std::uint64_t /*scan*/) {
  return satisfied_with(1e6 * beta);
}

TEST(LadderTrips, OfTwoLevelsThatAlwaysSwap) {
  // Goal: a ladder counts restarts, round trips and solutions correctly, and records lineages and
  // levels. Method: use two levels that always swap, but only after even scans. So replica 0 is at
  // levels 0 1 1 0 0 1 1 0 0, and replica 1 is at levels 1 0 0 1 1 0 0 1 1.
  //   - Replica 0 restarts at scans 1 and 5, and replica 1 restarts at scans 3 and 7.
  //   - Replica 0 ends round trips at scans 3 and 7, and replica 1 ends a round trip at scan 5.
  //     Replica 1's start at the cool end doesn't count.
  //   - Solutions are at scans 0 (replica 1's start), 1, 3, 5 and 7.
  //     Each lineage counts once, though it stays at the cool end for two scans.
  Played played(fixed({0, 1}), 9, always_swaps);
  EXPECT_EQ(played.betas(0), (std::vector<double>{0, 1, 1, 0, 0, 1, 1, 0, 0}));
  EXPECT_EQ(played.betas(1), (std::vector<double>{1, 0, 0, 1, 1, 0, 0, 1, 1}));
  const auto from = [](std::uint32_t replica, std::uint64_t scan) {
    return plan::lineage_from(base::ReplicaId{replica}, scan);
  };
  EXPECT_EQ(played.lineages(0),
            (std::vector{from(0, 0), from(0, 0), from(0, 0), from(0, 3), from(0, 4), from(0, 4),
                         from(0, 4), from(0, 7), from(0, 8)}));
  EXPECT_EQ(played.lineages(1),
            (std::vector{from(1, 0), from(1, 1), from(1, 2), from(1, 2), from(1, 2), from(1, 5),
                         from(1, 6), from(1, 6), from(1, 6)}));
  const RoundReport& round = played.run().rounds().front();
  EXPECT_EQ(round.restarts, 4U);
  EXPECT_EQ(round.round_trips, 3U);
  EXPECT_EQ(scans_of(played.run().solutions()), (std::vector<std::uint64_t>{0, 1, 3, 5, 7}));
  EXPECT_EQ(round.statistics.rejections(), std::vector{0.0});
  std::vector<std::vector<std::uint16_t>> levels;
  for (const IndexProcess::Moment& moment : played.run().index_process().moments()) {
    EXPECT_EQ(moment.scan, levels.size());
    levels.push_back(moment.level);
  }
  EXPECT_EQ(levels, (std::vector<std::vector<std::uint16_t>>{
                        {0, 1}, {1, 0}, {1, 0}, {0, 1}, {0, 1}, {1, 0}, {1, 0}, {0, 1}, {0, 1}}));
}

TEST(LadderTrips, GoOnOverTheEndsOfRounds) {
  // Goal: a round trip counts in the round in which it ends. The parity of swaps and the replicas'
  // places continue across rounds. Method: run two levels that always swap, in rounds of 2, 4 and 8
  // scans.
  Played played(fixed({0, 1}, 2), 14, always_swaps);
  const std::vector<RoundReport>& rounds = played.run().rounds();
  ASSERT_EQ(rounds.size(), 4U);
  EXPECT_EQ(played.betas(0), (std::vector<double>{0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}));
  EXPECT_EQ(rounds[1].first_scan, 2U);
  EXPECT_EQ(rounds[2].first_scan, 6U);
  EXPECT_EQ(rounds[3].first_scan, 14U);
  EXPECT_EQ(rounds[0].restarts, 1U);
  EXPECT_EQ(rounds[0].round_trips, 0U);
  EXPECT_EQ(rounds[1].restarts, 2U);
  EXPECT_EQ(rounds[1].round_trips, 2U);
  EXPECT_EQ(rounds[2].restarts, 4U);
  EXPECT_EQ(rounds[2].round_trips, 4U);
}

TEST(LadderTrips, GrowingLaddersBeginAtTheHotEnd) {
  // Goal: if levels are added, existing replicas stay the coolest, in the same order. New replicas
  // start from the prior in the round's first scan. If levels are removed, the hottest replicas
  // leave and never return. Method: start with two levels that never swap. The barrier of two
  // levels is 1, so the next round has three levels. The barrier of three levels is 2, so the next
  // round has five levels. Then let all levels swap, so that a barrier of 0 gives two levels.
  LadderOptions options = fixed({0, 1}, 4);
  options.levels_chosen = true;
  Played played(options, 40, [](double beta, std::uint64_t scan) {
    return scan < 12 ? never_swaps(beta, scan) : always_swaps(beta, scan);
  });
  const std::vector<RoundReport>& rounds = played.run().rounds();
  ASSERT_EQ(rounds.size(), 4U);
  ASSERT_EQ(rounds[0].counts.size(), 2U);
  ASSERT_EQ(rounds[1].counts.size(), 3U);
  ASSERT_EQ(rounds[2].counts.size(), 5U);
  ASSERT_EQ(rounds[3].counts.size(), 2U);
  EXPECT_EQ(played.run().replicas(), 5U);
  // With three levels, replica 1 is the coolest and replica 2 the hottest. Replicas 3 and 4 join at
  // hotter levels.
  EXPECT_EQ(played.betas(1)[11], 1);
  EXPECT_EQ(played.betas(0)[4], rounds[1].statistics.ladder()[1]);
  EXPECT_EQ(played.betas(2)[0], 0);
  EXPECT_EQ(played.betas(2)[8], rounds[2].statistics.ladder()[2]);
  EXPECT_EQ(played.betas(3)[0], 0);
  EXPECT_EQ(played.betas(4)[0], rounds[2].statistics.ladder()[1]);
  // Removed replicas have no level, and replicas that have not started yet are not listed.
  const std::vector<IndexProcess::Moment>& moments = played.run().index_process().moments();
  ASSERT_EQ(moments.size(), 40U);
  EXPECT_EQ(moments[3].level, (std::vector<std::uint16_t>{0, 1}));
  EXPECT_EQ(moments[4].level, (std::vector<std::uint16_t>{1, 2, 0}));
  EXPECT_EQ(std::ranges::count(moments[39].level, IndexProcess::k_no_level), 3);
  EXPECT_EQ(played.betas(2).size() + played.betas(3).size() + played.betas(4).size() +
                played.betas(0).size() + played.betas(1).size(),
            4U * 2 + 8 * 3 + 16 * 5 + 12 * 2);
}

}  // namespace
}  // namespace sleight::sampling
