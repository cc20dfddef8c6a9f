#include "worker/sampling/free_islands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "common/random/linear_distributions.h"
#include "tests/support/property.h"
#include "tests/unit/worker/sampling/any_plan.h"

namespace sleight::sampling::free_islands_test {

constexpr std::uint64_t k_cases = 200;

/// Results of a run's islands. A dead island's result is zero. The other results are lognormal with
/// the spread `log_sd`.
struct World {
  std::uint64_t seed = 0;
  double log_sd = 1;
  double dead = 0;  ///< share of dead islands
  double log_satisfied(std::uint64_t number) const {
    random::Stream stream({.seed = seed, .purpose = random::Purpose::ground}, number);
    if (stream.uniform() < dead) return k_log_zero;
    return random::Normal{.mean = -200, .sd = log_sd}.draw(stream);
  }
};

/// Reference: where the pilot and the batch end. The rule is applied to all islands at once.
struct Reference {
  std::uint64_t pilot = 0;
  std::uint64_t end = 0;
  bool has_batch = false;
};

std::vector<double> logs_of(const World& world, std::uint64_t first, std::uint64_t end) {
  std::vector<double> logs;
  for (std::uint64_t number = first; number < end; ++number)
    logs.push_back(world.log_satisfied(number));
  return logs;
}

Reference reference_of(const World& world, double log_error) {
  Reference found{.pilot = 32};
  math::IslandOdds odds = math::island_odds(logs_of(world, 0, found.pilot));
  while (!(odds.largest_share <= 1.0 / 3) && found.pilot < 1024) {
    found.pilot += 32;
    odds = math::island_odds(logs_of(world, 0, found.pilot));
  }
  found.end = found.pilot;
  if (std::isinf(odds.log_mean)) return found;
  found.has_batch = true;
  const auto first = static_cast<std::uint64_t>(
      std::max(100.0, std::ceil(1.5 * std::pow(odds.relative_sd / log_error, 2))));
  for (std::uint64_t batch = first;; batch += first / 2) {
    found.end = found.pilot + batch;
    const math::IslandOdds told = math::island_odds(logs_of(world, found.pilot, found.end));
    if (told.known() || batch >= 32 * first) return found;
  }
}

std::vector<plan::ScanRecord> run(const World& world, const plan::Unit& unit) {
  EXPECT_TRUE(unit.starts && unit.makes_islands());
  std::vector<plan::ScanRecord> records(unit.scans);
  for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
    const std::uint64_t number =
        plan::island_number(unit.replica.chain, unit.first_scan.value + nth);
    const double log = world.log_satisfied(number);
    IslandEstimate{.log_z = log + 1, .log_satisfied = log}.append_to(records[nth].method_values);
  }
  return records;
}

/// Runs the plan to its end, with units of any size that complete in any order.
void run_randomly(FreeIslands& plan, const World& world, Dice& dice) {
  const std::uint64_t most = 1 + dice.below(200);
  std::vector<plan::Unit> running;
  while (!plan.finished()) {
    if (dice.once_in(2) && running.size() < most) {
      if (auto unit = plan.next_unit(static_cast<std::uint32_t>(1 + dice.below(3)))) {
        running.push_back(*std::move(unit));
        continue;
      }
    }
    if (running.empty()) continue;
    std::swap(running[dice.below(running.size())], running.back());
    const plan::Unit unit = running.back();
    running.pop_back();
    plan.consume(unit.replica, unit.first_scan, run(world, unit));
  }
}

World random_world(std::uint64_t index, Dice& dice) {
  return {.seed = index,
          .log_sd = 0.2 * static_cast<double>(1 + dice.below(10)),
          .dead = dice.once_in(3) ? 0.1 * static_cast<double>(dice.below(10)) : 0};
}

const plan::Table* table_of(const plan::Report& report, const std::string& name) {
  const auto found = std::ranges::find(report.tables, name, &plan::Table::name);
  return found == report.tables.end() ? nullptr : &*found;
}

void expect_end(const FreeIslands& plan, const World& world, const Reference& expected) {
  EXPECT_EQ(plan.scans_common(), expected.end);
  const plan::Report report = plan.report();
  const plan::Table* from = table_of(report, "odds_from_island");
  ASSERT_EQ(from != nullptr, expected.has_batch);
  if (from != nullptr) {
    EXPECT_EQ(from->values, std::vector{static_cast<double>(expected.pilot)});
  }
  EXPECT_EQ(table_of(report, "island_log_satisfied")->values, logs_of(world, 0, expected.end));
  std::vector<double> weights = logs_of(world, 0, expected.end);
  for (double& weight : weights)
    weight += 1;
  EXPECT_EQ(table_of(report, "log_weight")->values, weights);

  const math::IslandOdds told =
      math::island_odds(logs_of(world, expected.has_batch ? expected.pilot : 0, expected.end));
  const plan::Odds odds = plan.odds();
  EXPECT_TRUE(odds.are_asked);
  EXPECT_EQ(odds.wanted, expected.end);
  EXPECT_EQ(odds.is_final, expected.has_batch && told.known());
  EXPECT_EQ(odds.islands, odds.is_final ? told.islands : expected.end);
  EXPECT_EQ(odds.log_p.value_or(k_log_zero), told.log_mean);
}

TEST(FreeIslands, EndsWhereTheIslandsSay) {
  // Goal: only the islands' results determine which islands run. Only the results determine which
  // islands yield the odds. The order of units, their cuts and stored results beyond the end have
  // no effect. Method: run random islands in random sessions, with two allowed errors. Compare the
  // end with a second implementation of the rule.
  std::uint64_t extended = 0;
  std::uint64_t long_pilots = 0;
  for (const std::uint64_t index : property::cases(k_cases)) {
    Dice dice(11, index);
    const World world = random_world(index, dice);
    const double log_error = dice.once_in(2) ? 0.3 : 0.15;
    const Reference expected = reference_of(world, log_error);
    extended += expected.end - expected.pilot > 150 ? 1 : 0;
    long_pilots += expected.pilot > 32 ? 1 : 0;
    FreeIslands plan({.seed = index, .log_error = log_error});
    if (dice.once_in(3)) {
      // For some lanes, consume results that a session with a different limit stored. Some of these
      // results are beyond this run's end.
      for (std::uint32_t lane = 0; lane < plan::k_island_lanes; ++lane) {
        const auto scans = static_cast<std::uint32_t>(dice.below(3));
        if (scans == 0) continue;
        const plan::Unit unit{
            .replica = {base::ChainId{plan::k_first_island_lane + lane}, base::ReplicaId{0}},
            .first_scan = base::ScanIndex{0},
            .scans = scans,
            .starts = true};
        plan.consume(unit.replica, unit.first_scan, run(world, unit));
      }
    }
    run_randomly(plan, world, dice);
    expect_end(plan, world, expected);
    if (HasFailure()) return;
  }
  if (property::all_cases()) {
    EXPECT_GT(extended, k_cases / 10);
    EXPECT_GT(long_pilots, k_cases / 10);
  }
}

TEST(FreeIslands, ACutEndsThereAndTellsTheOddsOnlyWhole) {
  // Goal: a limited run ends at its limit. The run yields the odds only if its limit is the number
  // of islands at which the unlimited run ends. So the request in an archive repeats the archive's
  // run. Method: limit runs to that final number of islands. Also limit runs to a random number
  // that is at most the final number.
  for (const std::uint64_t index : property::cases(k_cases)) {
    Dice dice(13, index);
    const World world = random_world(index, dice);
    const Reference whole = reference_of(world, 0.3);
    const std::uint64_t some = 1 + dice.below(whole.end);
    for (const std::uint64_t islands : {whole.end, some}) {
      FreeIslands plan({.seed = index, .log_error = 0.3, .islands_max = islands});
      run_randomly(plan, world, dice);
      EXPECT_EQ(plan.scans_common(), islands);
      EXPECT_EQ(table_of(plan.report(), "odds_from_island") != nullptr,
                whole.has_batch && islands == whole.end);
    }
    if (HasFailure()) return;
  }
}

TEST(FreeIslands, WhatNeverSatisfiesEnds) {
  // Goal: if all islands die, the run ends after a pilot of 1024 islands, without a batch.
  FreeIslands plan({.seed = 1, .log_error = 0.1});
  const World world{.dead = 1};
  Dice dice(17, 0);
  run_randomly(plan, world, dice);
  expect_end(plan, world, {.pilot = 1024, .end = 1024, .has_batch = false});
}

}  // namespace sleight::sampling::free_islands_test
