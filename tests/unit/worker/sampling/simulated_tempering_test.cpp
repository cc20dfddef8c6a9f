#include "worker/sampling/simulated_tempering.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/math/elementary.h"
#include "tests/support/numbers.h"
#include "tests/unit/worker/sampling/any_plan.h"
#include "tests/unit/worker/sampling/scans_of.h"

namespace sleight::sampling::simulated_tempering_test {

constexpr std::uint64_t k_seed = 662607;

BurnIn burn_in_of(std::vector<double> log_z_steps) {
  return {.seed = k_seed,
          .chain = base::ChainId{3},
          .scans = 70,
          .coolest = base::ReplicaId{2},
          .first_free = base::ReplicaId{9},
          .lineage = 17,
          .ladder = {0, 0.01, 0.2, 1},
          .scales = {{1}, {2}, {3}, {4}},
          .log_z_steps = std::move(log_z_steps),
          .next_ladder = {0, 0.02, 0.3, 0.5, 1},
          .next_scales = {{5}, {6}, {7}, {8}, {9}}};
}

plan::ScanRecord record_of(const plan::Unit& unit, double log_constraint, bool satisfied) {
  plan::ScanRecord record;
  record.log_constraint = log_constraint;
  record.satisfied = satisfied;
  record.inverse_temperature = unit.inverse_temperature(0);
  record.lineage = unit.inverse_temperature(0) == 0
                       ? plan::lineage_from(unit.replica.replica, unit.first_scan.value)
                       : unit.lineage;
  return record;
}

const std::vector<double>& row(const std::vector<ChainPart::Row>& rows, std::string_view name) {
  return std::ranges::find(rows, name, &ChainPart::Row::name)->values;
}

TEST(SimulatedTempering, MovesByTheFormula) {
  // Goal: levels, counts, draws and round trips follow the header's formula. Method: report random
  // densities for 20,000 scans. Some densities are zero. Compare with the same walk in plain
  // arithmetic.
  const std::vector<double> steps{-0.3, -1.5, -0.8};
  const BurnIn burn_in = burn_in_of(steps);
  SimulatedTempering part(burn_in);
  const double weight[4] = {1, std::exp(0.3), std::exp(1.8), std::exp(2.6)};
  std::vector<double> visits(4, 0);
  std::vector<double> moves[2] = {std::vector<double>(3, 0), std::vector<double>(3, 0)};
  std::vector<double> draw_scans;
  std::vector<std::uint64_t> solutions;
  std::string ends;
  Dice dice(k_seed, 0);
  std::uint32_t level = 3;
  std::uint64_t lineage = 17;
  bool solved = false;
  for (std::uint64_t scan = 70; scan < 20'070; ++scan) {
    const std::optional<plan::Unit> unit = part.next_unit(20'070, 5);
    ASSERT_TRUE(unit.has_value());
    ASSERT_EQ(part.next_unit(20'070, 5), std::nullopt);
    const plan::Unit expected{.replica = {base::ChainId{3}, base::ReplicaId{2}},
                              .seed = k_seed,
                              .first_scan = base::ScanIndex{scan},
                              .scans = 1,
                              .starts = false,
                              .lineage = lineage,
                              .inverse_temperatures = {burn_in.ladder[level]},
                              .proposal_scales = burn_in.scales[level],
                              .excursion = {}};
    ASSERT_EQ(*unit, expected);
    // States without density occur only at the prior's level.
    const double l = level == 0 && dice.once_in(4)
                         ? -k_infinity
                         : -6 * static_cast<double>(dice.below(1000)) / 1000 * (3.5 - level);
    const plan::ScanRecord record = record_of(*unit, l, dice.once_in(5));
    part.consume(base::ReplicaId{2}, scan, std::span(&record, 1));
    ++visits[level];
    if (record.lineage != lineage) solved = false;
    lineage = record.lineage;
    if (level == 0) ends += 'h';
    if (level == 3) {
      ends += 'c';
      draw_scans.push_back(static_cast<double>(scan));
      if (record.satisfied && !solved) solutions.push_back(scan);
      solved = solved || record.satisfied;
    }
    random::Stream stream(
        {.seed = k_seed, .chain = base::ChainId{3}, .purpose = random::Purpose::level}, scan);
    const bool up = stream.uniform() < 0.5;
    const double u = stream.uniform();
    if (up ? level == 3 : level == 0) continue;
    const std::uint32_t to = up ? level + 1 : level - 1;
    ++moves[0][std::min(level, to)];
    const double ratio =
        std::exp((burn_in.ladder[to] - burn_in.ladder[level]) * l) * weight[to] / weight[level];
    if (u >= ratio) continue;
    ++moves[1][std::min(level, to)];
    level = to;
  }
  EXPECT_EQ(part.next_unit(20'070, 5), std::nullopt);
  EXPECT_EQ(part.scans(), 20'070U);
  EXPECT_EQ(part.draws(), draw_scans.size());
  EXPECT_EQ(scans_of(part.solutions()), solutions);
  EXPECT_GT(solutions.size(), 100U);
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  double trips = 0;
  for (std::size_t i = 1; i < ends.size(); ++i)
    trips += ends[i] == 'c' ? 1 : 0;
  EXPECT_GT(trips, 100);

  const std::vector<ChainPart::Row> rows = part.rows();
  EXPECT_EQ(row(rows, "walk_inverse_temperature"), burn_in.ladder);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(row(rows, "walk_log_weight")[i], std::log(weight[i] / weight[3]), 1e-12);
  EXPECT_EQ(row(rows, "walk_visits"), visits);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(row(rows, "walk_acceptance")[i], moves[1][i] / moves[0][i]);
  EXPECT_TRUE(std::isnan(row(rows, "walk_acceptance")[3]));
  EXPECT_EQ(row(rows, "walk_round_trips"), std::vector<double>{trips});
  EXPECT_EQ(row(rows, "draw_scan"), draw_scans);
}

TEST(SimulatedTempering, WalksOnWhereAStepOfLogZIsNotKnown) {
  // Goal: if the burn-in saw no density at a level, the level's log Z is -infinity. The walk then
  // skips this level but visits the levels above it. Method: set the step of log Z at the prior's
  // level to -infinity.
  SimulatedTempering part(burn_in_of({-k_infinity, -1.5, -0.8}));
  for (std::uint64_t scan = 70; scan < 2070; ++scan) {
    const plan::Unit unit = part.next_unit(5000, 1).value();
    const plan::ScanRecord record = record_of(unit, -0.5, false);
    part.consume(base::ReplicaId{2}, scan, std::span(&record, 1));
  }
  const std::vector<double> visits = row(part.rows(), "walk_visits");
  EXPECT_EQ(visits[0], 0);
  for (std::size_t level = 1; level < 4; ++level)
    EXPECT_GT(visits[level], 100);
}

}  // namespace sleight::sampling::simulated_tempering_test
