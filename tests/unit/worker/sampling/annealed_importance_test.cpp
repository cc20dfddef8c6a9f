#include "worker/sampling/annealed_importance.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/numbers.h"
#include "tests/support/property.h"
#include "tests/unit/worker/sampling/any_plan.h"
#include "tests/unit/worker/sampling/scans_of.h"

namespace sleight::sampling::annealed_importance_test {

constexpr std::uint64_t k_seed = 138064;

BurnIn burn_in() {
  return {.seed = k_seed,
          .chain = base::ChainId{1},
          .scans = 31,
          .coolest = base::ReplicaId{2},
          .first_free = base::ReplicaId{6},
          .lineage = 0,
          .ladder = {0, 1},
          .scales = {{}, {}},
          .log_z_steps = {-1},
          .next_ladder = {0, 0.1, 0.4, 1},
          .next_scales = {{1}, {2}, {3}, {3}}};
}

const std::vector<double>& row(const std::vector<ChainPart::Row>& rows, std::string_view name) {
  return std::ranges::find(rows, name, &ChainPart::Row::name)->values;
}

TEST(AnnealedImportance, ScheduleIsTheLaddersWithStepsBetween) {
  // Goal: each unit has the right inverse temperatures, proposal size, lane and start. A unit ends
  // where the proposal size changes or where its ascent ends. Method: use two lanes. Compare their
  // longest possible units with a table of expected values.
  AnnealedImportance part(burn_in(), 2, 2);
  const std::vector<double> betas{0, 0.05, 0.1, 0.25, 0.4, 0.7, 1};
  ASSERT_EQ(part.schedule().size(), betas.size());
  for (std::size_t k = 0; k < betas.size(); ++k)
    EXPECT_NEAR(part.schedule()[k], betas[k], 1e-15);
  EXPECT_EQ(part.schedule().back(), 1.0);

  struct Expected {
    std::uint32_t lane;
    std::uint64_t first;
    std::uint32_t scans;
    std::vector<double> scales;
  };
  // In each ascent, the first 3 scans use the proposal size of level 0.1. The next 4 scans use the
  // size of levels 0.4 and 1.
  const std::vector<Expected> expected{{0, 0, 3, {2}},  {1, 0, 3, {2}}, {0, 3, 4, {3}},
                                       {1, 3, 4, {3}},  {0, 7, 3, {2}}, {1, 7, 3, {2}},
                                       {0, 10, 2, {3}}, {1, 10, 2, {3}}};
  for (const Expected& unit : expected) {
    const plan::Unit got = part.next_unit(31 + 12, 100).value();
    EXPECT_EQ(got.replica, (plan::ReplicaKey{base::ChainId{1}, base::ReplicaId{6 + unit.lane}}));
    EXPECT_EQ(got.first_scan.value, 31 + unit.first);
    EXPECT_EQ(got.scans, unit.scans);
    EXPECT_EQ(got.proposal_scales, unit.scales);
    EXPECT_EQ(got.starts, unit.first == 0);
    EXPECT_TRUE(got.excursion.empty());
    std::vector<plan::ScanRecord> records;
    for (std::uint32_t nth = 0; nth < got.scans; ++nth) {
      EXPECT_EQ(got.inverse_temperature(nth), part.schedule()[(unit.first + nth) % 7]);
      records.emplace_back().inverse_temperature = got.inverse_temperature(nth);
    }
    part.consume(got.replica.replica, got.first_scan.value, records);
  }
  EXPECT_EQ(part.next_unit(31 + 12, 100), std::nullopt);
  EXPECT_EQ(part.scans(), 31U + 12);
  EXPECT_EQ(part.draws(), 2U);
}

TEST(AnnealedImportance, WeightsAreThoseOfTheFormula) {
  // Goal: the log weights, their order and the estimates that use them follow the formula. Method:
  // report random densities. Some densities are zero. Compare the results with products and sums of
  // plain doubles.
  for (const std::uint64_t index : property::cases(50)) {
    Dice dice(k_seed, index);
    const auto lanes = static_cast<std::uint32_t>(1 + dice.below(4));
    AnnealedImportance part(burn_in(), lanes, static_cast<std::uint32_t>(1 + dice.below(3)));
    const std::vector<double> betas = part.schedule();
    const std::uint64_t end = 31 + 5 * betas.size() + dice.below(betas.size());
    std::vector<std::vector<plan::ScanRecord>> seen(lanes);
    std::vector<plan::Unit> running;
    while (part.scans() < end) {
      while (const auto unit = part.next_unit(end, static_cast<std::uint32_t>(1 + dice.below(9))))
        running.push_back(*unit);
      const std::size_t which = dice.below(running.size());
      const plan::Unit unit = running[which];
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(which));
      std::vector<plan::ScanRecord> records;
      for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
        plan::ScanRecord& record = records.emplace_back();
        record.inverse_temperature = unit.inverse_temperature(nth);
        record.log_constraint =
            dice.once_in(40) ? -k_infinity : -4 * static_cast<double>(dice.below(1000)) / 1000;
        record.satisfied = dice.once_in(2);
        // Each ascent begins with a draw from the prior.
        const std::uint64_t ascent = (unit.first_scan.value + nth - 31) / betas.size();
        record.lineage = plan::lineage_from(unit.replica.replica, 31 + ascent * betas.size());
      }
      auto& lane = seen[unit.replica.replica.value - 6];
      lane.insert(lane.end(), records.begin(), records.end());
      part.consume(unit.replica.replica, unit.first_scan.value, records);
    }
    std::vector<double> logs;
    double sum = 0;
    double squares = 0;
    double satisfied = 0;
    std::vector<std::uint64_t> solutions;
    for (std::uint64_t ascent = 0; ascent < 5; ++ascent) {
      for (const std::vector<plan::ScanRecord>& lane : seen) {
        const std::size_t first = ascent * betas.size();
        double weight = 1;
        for (std::size_t k = 1; k < betas.size(); ++k)
          weight *= std::exp((betas[k] - betas[k - 1]) * lane[first + k - 1].log_constraint);
        const plan::ScanRecord& last = lane[first + betas.size() - 1];
        logs.push_back(std::log(weight));
        sum += weight;
        squares += weight * weight;
        if (last.satisfied && std::isfinite(last.log_constraint))
          satisfied += weight / std::exp(last.log_constraint);
        if (last.satisfied) solutions.push_back(31 + first + betas.size() - 1);
      }
    }
    const auto n = static_cast<double>(logs.size());
    EXPECT_EQ(part.draws(), logs.size());
    EXPECT_EQ(scans_of(part.solutions()), solutions);
    const std::vector<ChainPart::Row> rows = part.rows();
    EXPECT_EQ(row(rows, "ascent_inverse_temperature"), betas);
    ASSERT_EQ(row(rows, "log_weight").size(), logs.size());
    for (std::size_t i = 0; i < logs.size(); ++i) {
      if (std::isinf(logs[i])) {
        EXPECT_EQ(row(rows, "log_weight")[i], logs[i]);
      } else {
        EXPECT_NEAR(row(rows, "log_weight")[i], logs[i], 1e-12);
      }
    }
    const double variance = (squares - sum * sum / n) / (n - 1) / n;
    EXPECT_NEAR(row(rows, "ais_log_z")[0], std::log(sum / n), 1e-12);
    EXPECT_NEAR(row(rows, "ais_effective_size")[0], sum * sum / squares, 1e-10);
    if (n > 1) {
      EXPECT_NEAR(row(rows, "ais_log_z_error")[0], std::sqrt(variance) / (sum / n), 1e-7);
    }
    if (satisfied > 0) {
      EXPECT_NEAR(row(rows, "ais_log_p_satisfied")[0], std::log(satisfied / n), 1e-12);
    }
  }
}

TEST(WeightSummary, OfNothingOfOneOfZerosAndOfEqualWeights) {
  // Goal: summary_of() is right for no weight, for one weight, for zero weights and for equal
  // weights. A weight may be too small for a double.
  EXPECT_TRUE(std::isnan(summary_of({}).log_mean.value));
  EXPECT_EQ(summary_of({}).effective_size, 0);
  const WeightSummary one = summary_of(std::vector{-3.0});
  EXPECT_EQ(one.log_mean.value, -3);
  EXPECT_TRUE(std::isnan(one.log_mean.error));
  EXPECT_EQ(one.effective_size, 1);
  const WeightSummary zeros = summary_of(std::vector{-k_infinity, -k_infinity});
  EXPECT_EQ(zeros.log_mean.value, -k_infinity);
  EXPECT_TRUE(std::isnan(zeros.log_mean.error));
  EXPECT_EQ(zeros.effective_size, 0);
  const WeightSummary equal = summary_of(std::vector(4, -2000.0));
  EXPECT_NEAR(equal.log_mean.value, -2000, 1e-12);
  EXPECT_NEAR(equal.log_mean.error, 0, 1e-6);
  EXPECT_NEAR(equal.effective_size, 4, 1e-12);
  // If one of four weights is nonzero, (sum w)^2 / sum w^2 is 1, and the relative error is sqrt(4/3
  // (1 - 1/4)) = 1.
  const WeightSummary single = summary_of(std::vector{-k_infinity, 5.0, -k_infinity, -k_infinity});
  EXPECT_NEAR(single.log_mean.value, 5 - std::log(4.0), 1e-12);
  EXPECT_NEAR(single.log_mean.error, 1, 1e-12);
  EXPECT_NEAR(single.effective_size, 1, 1e-12);
}

}  // namespace sleight::sampling::annealed_importance_test
