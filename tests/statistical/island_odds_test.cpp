// Goal: if the rule in [stop] sets a batch's number of islands, the batch's odds are right on
// average and their errors are calibrated. If a run instead stops when its own estimate looks good,
// it underestimates P. Method: draw lognormal estimates whose mean is known, and deliver them as
// chains of islands.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/math/island_odds.h"
#include "common/random/linear_distributions.h"
#include "common/random/stream.h"
#include "worker/sampling/free_islands.h"
#include "worker/sampling/island_estimate.h"

namespace sleight::statistical::island_odds_test {

constexpr std::uint64_t k_seed = 137035;
constexpr int k_runs = 1000;
constexpr double k_log_p = -207;  ///< e^-207 is about 1e-90.
constexpr double k_log_sd = 1.3;  ///< One island in 650 exceeds 20 times the mean.
constexpr double k_odds = 0.1;

/// Draws the log of an estimate. The estimate is unbiased, because the mean of a lognormal is
/// e^(mean + sd^2 / 2).
double draw_island(random::Stream& stream) {
  return random::Normal{.mean = k_log_p - k_log_sd * k_log_sd / 2, .sd = k_log_sd}.draw(stream);
}

random::Stream stream_of(int run) {
  return {{.seed = k_seed, .purpose = random::Purpose::prior}, static_cast<std::uint64_t>(run)};
}

/// Makes a run that follows the rule. Returns the islands that count towards its odds, in order.
std::vector<double> told_by_the_rule(random::Stream& stream) {
  sampling::FreeIslands plan({.seed = k_seed, .log_error = k_odds});
  while (const auto unit = plan.next_unit(1)) {
    std::vector<plan::ScanRecord> records(1);
    sampling::IslandEstimate{.log_z = 0, .log_satisfied = draw_island(stream)}.append_to(
        records[0].method_values);
    plan.consume(unit->replica, unit->first_scan, records);
  }
  const plan::Report report = plan.report();
  const auto table = [&](const char* name) {
    return std::ranges::find(report.tables, name, &plan::Table::name)->values;
  };
  const std::vector<double> islands = table("island_log_satisfied");
  const auto from = static_cast<std::ptrdiff_t>(table("odds_from_island").at(0));
  return {islands.begin() + from, islands.end()};
}

/// Makes a run that stops as soon as its own estimate has the requested error. Returns the odds
/// from all its islands.
math::IslandOdds stopped_by_itself(random::Stream& stream) {
  math::IslandSums sums;
  while (true) {
    sums.add(draw_island(stream));
    const math::IslandOdds odds = sums.odds();
    if (odds.islands >= 50 && odds.log_error() <= k_odds) return odds;
  }
}

/// Compares estimates with the truth.
class Coverage {
 public:
  void add(const math::IslandOdds& odds) {
    const double off = odds.log_mean - k_log_p;
    ++runs_;
    within_one_ += std::abs(off) <= odds.log_error() ? 1 : 0;
    within_two_ += std::abs(off) <= 2 * odds.log_error() ? 1 : 0;
    errors_ += odds.log_error();
    islands_ += static_cast<double>(odds.islands);
    const double relative = std::expm1(off);
    sum_ += relative;
    squares_ += relative * relative;
  }
  int runs() const { return runs_; }
  double within_one() const { return within_one_ / runs_; }
  double within_two() const { return within_two_ / runs_; }
  /// Mean relative deviation of the estimates from P. bias_error() is its standard error.
  double bias() const { return sum_ / runs_; }
  double bias_error() const { return std::sqrt((squares_ / runs_ - bias() * bias()) / runs_); }
  double mean_error() const { return errors_ / runs_; }
  void print(const char* what) const {
    fmt::print(
        "{}: {} runs of {:.0f} islands, error {:.3f}, {:.3f} within one error, {:.3f} "
        "within two, P off by {:+.4f} +- {:.4f}\n",
        what, runs_, islands_ / runs_, mean_error(), within_one(), within_two(), bias(),
        bias_error());
  }

 private:
  int runs_ = 0;
  double within_one_ = 0;
  double within_two_ = 0;
  double errors_ = 0;
  double islands_ = 0;
  double sum_ = 0;
  double squares_ = 0;
};

TEST(IslandOdds, SizedBatchesAreRightAndSoAreTheirErrors) {
  // Goal: if the rule sets the size of batches, the mean of P over all runs is right, and the error
  // is about as requested. About 65% of the runs that report an error are within one error of the
  // truth, and about 92% are within two errors. If the estimates were normal, these shares would be
  // larger. But the sum of islands is skewed, and its spread is estimated. Two rules bias P by less
  // than a quarter of its error. The first rule extends a batch if one island has a tenth of the
  // sum. If the extension doesn't help, the second rule reports no error. Method: make 1,000 runs
  // of the plan itself. The shares may be lower by five binomial standard errors, and the mean may
  // differ by four standard errors.
  Coverage all;
  Coverage known;
  for (int run = 0; run < k_runs; ++run) {
    random::Stream stream = stream_of(run);
    const math::IslandOdds odds = math::island_odds(told_by_the_rule(stream));
    all.add(odds);
    if (odds.known()) known.add(odds);
  }
  all.print("sized, all");
  known.print("sized, known");
  EXPECT_LT(std::abs(all.bias()), 4 * all.bias_error()) << "seed " << k_seed;
  EXPECT_GT(known.runs(), 0.8 * k_runs) << "seed " << k_seed;
  EXPECT_LT(std::abs(known.bias()), k_odds / 4) << "seed " << k_seed;
  EXPECT_GT(known.within_one(), 0.65 - 5 * std::sqrt(0.65 * 0.35 / known.runs())) << k_seed;
  EXPECT_GT(known.within_two(), 0.92 - 5 * std::sqrt(0.92 * 0.08 / known.runs())) << k_seed;
  EXPECT_GT(known.mean_error(), 0.07) << "seed " << k_seed;
  EXPECT_LT(known.mean_error(), 0.11) << "seed " << k_seed;
}

TEST(IslandOdds, ARunThatStopsByItsOwnEstimateSaysTooLittle) {
  // Goal (negative control): if runs stop by their own estimate, P is too low by more than chance.
  // Method: stop each run at the first island after which the estimate looks good enough, and count
  // all islands. The bias must exceed four standard errors of the mean.
  Coverage stopped;
  for (int run = 0; run < k_runs; ++run) {
    random::Stream stream = stream_of(k_runs + run);
    stopped.add(stopped_by_itself(stream));
  }
  stopped.print("stopped by itself");
  EXPECT_LT(stopped.bias(), -4 * stopped.bias_error()) << "seed " << k_seed;
}

}  // namespace sleight::statistical::island_odds_test
