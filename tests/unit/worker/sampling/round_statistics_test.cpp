#include "worker/sampling/round_statistics.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/random/linear_distributions.h"
#include "tests/support/numbers.h"

namespace sleight::sampling {
namespace {

constexpr std::uint64_t k_seed = 662607;
const std::vector<double> k_ladder{0, 0.15, 0.4, 1};
using Scans = std::vector<std::vector<LevelScan>>;

Scans random_scans(std::uint64_t count, std::uint64_t index) {
  random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, index);
  Scans scans(count);
  for (std::vector<LevelScan>& scan : scans) {
    for (std::size_t level = 0; level < k_ladder.size(); ++level) {
      const bool broken = level + 1 < k_ladder.size() && stream.uniform() < 0.2;
      scan.push_back({.log_constraint = broken ? -k_infinity : -6 * stream.uniform(),
                      .satisfied = stream.uniform() < 0.5});
    }
  }
  return scans;
}

RoundStatistics statistics_of(const Scans& scans, std::uint64_t wanted) {
  RoundStatistics statistics(k_ladder, wanted);
  for (const std::vector<LevelScan>& scan : scans)
    statistics.add(scan);
  return statistics;
}

/// Computes the header's formulas in plain arithmetic.
double plain_log_z(const Scans& scans) {
  double log_z = 0;
  for (std::size_t i = 0; i + 1 < k_ladder.size(); ++i) {
    double sum = 0;
    for (const std::vector<LevelScan>& scan : scans)
      sum += std::exp((k_ladder[i + 1] - k_ladder[i]) * scan[i].log_constraint);
    log_z += std::log(sum / static_cast<double>(scans.size()));
  }
  return log_z;
}
double plain_log_satisfied(const Scans& scans) {
  double sum = 0;
  for (const std::vector<LevelScan>& scan : scans) {
    if (scan.back().satisfied && scan.back().log_constraint != -k_infinity)
      sum += std::exp(-scan.back().log_constraint);
  }
  return plain_log_z(scans) + std::log(sum / static_cast<double>(scans.size()));
}

/// Computes the jackknife's error. Leaves out each part in turn. Part p contains the scans s with
/// floor(20 s / wanted) = p.
double plain_jackknife(const Scans& scans, std::uint64_t wanted, double (*value)(const Scans&)) {
  std::vector<double> values;
  for (std::uint64_t part = 0; part < k_batches; ++part) {
    Scans rest;
    for (std::uint64_t s = 0; s < scans.size(); ++s) {
      if (s * k_batches / wanted != part) rest.push_back(scans[s]);
    }
    if (rest.size() < scans.size()) values.push_back(value(rest));
  }
  const auto count = static_cast<double>(values.size());
  double mean = 0;
  for (const double x : values)
    mean += x / count;
  double sum = 0;
  for (const double x : values)
    sum += (x - mean) * (x - mean);
  return std::sqrt((count - 1) / count * sum);
}

TEST(RoundStatistics, EqualsDirectComputation) {
  // Goal: rejections, log Z, log P(satisfied) and their errors follow the header's formulas.
  // Method: compare random rounds with plain arithmetic. Some rounds are shortened, and some
  // lengths are not divisible by 20.
  for (const auto& [count, wanted] : {std::pair<std::uint64_t, std::uint64_t>{100, 100},
                                      {64, 64},
                                      {37, 64},
                                      {21, 64},
                                      {1000, 1001},
                                      {7, 7}}) {
    SCOPED_TRACE(fmt::format("seed {}, {} of {} scans", k_seed, count, wanted));
    const Scans scans = random_scans(count, count);
    const RoundStatistics statistics = statistics_of(scans, wanted);
    EXPECT_EQ(statistics.scans(), count);
    const std::vector<double> rejections = statistics.rejections();
    ASSERT_EQ(rejections.size(), k_ladder.size() - 1);
    for (std::size_t i = 0; i + 1 < k_ladder.size(); ++i) {
      double sum = 0;
      for (const std::vector<LevelScan>& scan : scans) {
        const double l = scan[i].log_constraint;
        const double cooler = scan[i + 1].log_constraint;
        const bool same = l == cooler;
        const double ratio = same ? 1 : std::exp((k_ladder[i + 1] - k_ladder[i]) * (l - cooler));
        sum += 1 - std::min(1.0, ratio);
      }
      EXPECT_NEAR(rejections[i], sum / static_cast<double>(count), 1e-13);
    }
    EXPECT_NEAR(statistics.log_z().value, plain_log_z(scans), 1e-12);
    EXPECT_NEAR(statistics.log_z().error, plain_jackknife(scans, wanted, plain_log_z), 1e-12);
    EXPECT_NEAR(statistics.log_satisfied().value, plain_log_satisfied(scans), 1e-12);
    EXPECT_NEAR(statistics.log_satisfied().error,
                plain_jackknife(scans, wanted, plain_log_satisfied), 1e-12);
  }
}

TEST(RoundStatistics, SaysWhereItCannotSay) {
  // Goal: a round with a single part has no error estimate. If a round has no solutions, log
  // P(satisfied) is -infinity and has no error estimate. States without density at the coolest
  // level are no solutions.
  const std::vector<LevelScan> scan(4, {.log_constraint = -1, .satisfied = false});
  std::vector<LevelScan> broken = scan;
  broken.back() = {.log_constraint = -k_infinity, .satisfied = true};
  const RoundStatistics one = statistics_of({scan}, 64);
  EXPECT_NEAR(one.log_z().value, -1, 1e-14);
  EXPECT_TRUE(std::isnan(one.log_z().error));
  const RoundStatistics unsolved = statistics_of(Scans(64, broken), 64);
  EXPECT_EQ(unsolved.log_satisfied().value, -k_infinity);
  EXPECT_TRUE(std::isnan(unsolved.log_satisfied().error));
  EXPECT_NEAR(unsolved.log_z().error, 0, 1e-13);
  EXPECT_TRUE(std::isnan(RoundStatistics(k_ladder, 64).rejections().front()));
}

TEST(RoundStatistics, ErrorsAreRightForIndependentDraws) {
  // Goal: the jackknife's error matches the spread of the estimates. Method: simulate 2000 rounds
  // of 400 scans. At each level, draws are exact and independent. The prior is N(0, 1), the
  // constraint is exp(-x^2 / 2 (1 / 0.5^2)), and |x| < 0.4 satisfies it. Compute z-scores of log Z
  // and log P(satisfied). With 20 parts, z has Student's distribution with 19 degrees of freedom,
  // whose variance is 19/17 and whose kurtosis is 3.4. So over 2000 rounds the mean is within 5 x
  // 1.06 / sqrt(2000) = 0.12 of 0. This limit also covers a bias of half a variance. The variance
  // is within 5 x sqrt(2.4 / 2000) = 17% of 19/17.
  constexpr double k_precision = 4;
  const double log_z = -0.5 * std::log(1 + k_precision);
  const double log_satisfied = std::log(std::erf(0.4 / std::sqrt(2.0)));
  constexpr int k_repeats = 2000;
  double mean[2] = {};
  double squares[2] = {};
  for (std::uint64_t repeat = 0; repeat < k_repeats; ++repeat) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, 10'000 + repeat);
    RoundStatistics statistics(k_ladder, 400);
    for (int s = 0; s < 400; ++s) {
      std::vector<LevelScan> scan;
      for (const double beta : k_ladder) {
        const double x =
            random::Normal{.mean = 0, .sd = 1 / std::sqrt(1 + beta * k_precision)}.draw(stream);
        scan.push_back(
            {.log_constraint = -0.5 * k_precision * x * x, .satisfied = std::abs(x) < 0.4});
      }
      statistics.add(scan);
    }
    const double z[2] = {
        (statistics.log_z().value - log_z) / statistics.log_z().error,
        (statistics.log_satisfied().value - log_satisfied) / statistics.log_satisfied().error};
    for (int i = 0; i < 2; ++i) {
      mean[i] += z[i] / k_repeats;
      squares[i] += z[i] * z[i] / k_repeats;
    }
  }
  for (int i = 0; i < 2; ++i) {
    fmt::print("z-scores: mean {:.3f}, variance {:.3f}\n", mean[i], squares[i] - mean[i] * mean[i]);
    EXPECT_NEAR(mean[i], 0, 0.12) << "seed " << k_seed;
    EXPECT_NEAR(squares[i] - mean[i] * mean[i], 19.0 / 17, 0.17 * 19 / 17) << "seed " << k_seed;
  }
}

}  // namespace
}  // namespace sleight::sampling
