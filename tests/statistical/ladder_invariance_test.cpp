// Tests parallel tempering on a world that can be enumerated. Swaps and scans together must leave
// the product of all tempered distributions invariant.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/statistical/support/run_serially.h"
#include "tests/statistical/support/toy_worlds.h"
#include "tests/support/property.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"

namespace sleight::statistical::ladder_invariance_test {

constexpr std::uint64_t k_seed = 602214;
const std::vector<double> k_ladder{0, 0.1, 0.3, 0.6, 1};
constexpr std::size_t k_places = RuggedRing::k_places;

sampling::ParallelTemperingOptions options_of(std::uint64_t seed, std::uint64_t scans) {
  return {.ladders = 1,
          .ladder = {.seed = seed,
                     .chain = {},
                     .first_ladder = k_ladder,
                     .levels_chosen = false,
                     .levels_max = 64,
                     .ladder_adapts = false,
                     .has_scale = {},
                     .round_scans = 3},
          .stop = {.scans = scans, .rounds = {}, .independent_solutions = {}}};
}

std::size_t level_of(double beta) {
  return static_cast<std::size_t>(std::ranges::find(k_ladder, beta) - k_ladder.begin());
}

struct Census {
  std::vector<std::vector<double>> levels{k_ladder.size(), std::vector<double>(k_places, 0.0)};
  std::vector<std::vector<double>> neighbours{k_ladder.size() - 1,
                                              std::vector<double>(k_places* k_places, 0.0)};
  void add(const std::vector<std::size_t>& places) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      ++levels[i][places[i]];
      if (i + 1 < places.size()) ++neighbours[i][places[i] * k_places + places[i + 1]];
    }
  }
};

TEST(LadderInvariance, ExactDrawsStayExact) {
  // Goal: in a fixed ladder, swaps, scans and ends of rounds leave the distribution of each level
  // unchanged, and levels stay independent. Method: start many ladders of five levels from exact
  // draws. After one scan and after ten scans, make chi-square tests: compare each level, and each
  // pair of neighbouring levels, with enumeration. Each of the 18 p-values is below 1e-6 by chance
  // once in a million runs. Compare the four mean rejection rates with enumeration. The rates must
  // agree within 5 standard errors. The comparison of rates fails by chance with probability
  // 2.3e-6. The fast tier uses as many repeats as mutants/ladder_checks.cpp, which rejects every
  // mutant.
  const std::uint64_t repeats = property::of_tier(6'000, 100'000);
  const RuggedRing ring;
  const std::vector<std::uint64_t> looked_at{1, 10};
  std::vector<Census> censuses(looked_at.size());
  std::vector<std::vector<double>> rejections(k_ladder.size() - 1);
  for (std::uint64_t repeat = 0; repeat < repeats; ++repeat) {
    const std::uint64_t seed = k_seed + repeat;
    const run::ChainWorker<RuggedRing> worker(ring, {});
    const ExactStarts<RuggedRing> from_exact(ring, seed, worker);
    sampling::ParallelTempering plan(options_of(seed, 11));
    std::vector<std::vector<std::size_t>> places(looked_at.size(),
                                                 std::vector<std::size_t>(k_ladder.size()));
    run_serially(plan, from_exact, [&](const plan::UnitResult& result) {
      const auto which = std::ranges::find(looked_at, result.unit.first_scan.value);
      if (which == looked_at.end()) return;
      const plan::ScanRecord& record = result.scans.front();
      places[static_cast<std::size_t>(which - looked_at.begin())]
            [level_of(record.inverse_temperature)] =
                static_cast<std::size_t>(record.outcome.front());
    });
    for (std::size_t i = 0; i < looked_at.size(); ++i)
      censuses[i].add(places[i]);
    const std::vector<double> rates = plan.ladders()[0].rounds()[1].statistics.rejections();
    for (std::size_t i = 0; i < rates.size(); ++i)
      rejections[i].push_back(rates[i]);
  }

  for (std::size_t s = 0; s < looked_at.size(); ++s) {
    for (std::size_t i = 0; i < k_ladder.size(); ++i) {
      const std::vector<double> here = RuggedRing::exact(k_ladder[i]);
      const double p = chi_square_p(censuses[s].levels[i], here);
      double p_joint = 1;
      if (i + 1 < k_ladder.size()) {
        const std::vector<double> cooler = RuggedRing::exact(k_ladder[i + 1]);
        std::vector<double> joint;
        for (const double a : here) {
          for (const double b : cooler)
            joint.push_back(a * b);
        }
        p_joint = chi_square_p(censuses[s].neighbours[i], joint);
      }
      fmt::print("after {} scans, level {}: p {:.3g}, with its neighbour {:.3g}\n", looked_at[s], i,
                 p, p_joint);
      EXPECT_GT(p, 1e-6) << "seed " << k_seed;
      EXPECT_GT(p_joint, 1e-6) << "seed " << k_seed;
    }
  }
  for (std::size_t i = 0; i + 1 < k_ladder.size(); ++i) {
    const std::vector<double> here = RuggedRing::exact(k_ladder[i]);
    const std::vector<double> cooler = RuggedRing::exact(k_ladder[i + 1]);
    double exact = 0;
    for (std::size_t a = 0; a < k_places; ++a) {
      for (std::size_t b = 0; b < k_places; ++b) {
        if (here[a] * cooler[b] == 0) continue;
        const double ratio = here[b] * cooler[a] / (here[a] * cooler[b]);
        exact += here[a] * cooler[b] * (1 - std::min(1.0, ratio));
      }
    }
    const MeanWithError seen = mean_of_independent(rejections[i]);
    fmt::print("rejections {}: {:.4f} +- {:.4f}, exactly {:.4f}\n", i, seen.mean,
               seen.standard_error, exact);
    EXPECT_NEAR(seen.mean, exact, 5 * seen.standard_error) << "seed " << k_seed;
  }
}

TEST(LadderInvariance, LearningLaddersFindTheDistribution) {
  // Goal: an ordinary run reaches p_w p_c even if no proposal connects the parts of the ring. The
  // run starts from prior draws, and adapts the ladder and its size. Method: run 300 independent
  // ladders. In the last of five rounds, each place's mean share must be within 5 standard errors
  // of the exact share. There are 11 places, so the test fails by chance with probability 6e-6.
  // Lineages must begin only at prior draws.
  constexpr std::uint64_t k_repeats = 300;
  const RuggedRing ring;
  std::vector<std::vector<double>> shares(k_places);
  std::size_t levels_max = 0;
  for (std::uint64_t repeat = 0; repeat < k_repeats; ++repeat) {
    const std::uint64_t seed = 2 * k_seed + repeat;
    const run::ChainWorker<RuggedRing> worker(ring, {.iterations_per_scan = 2});
    sampling::ParallelTemperingOptions options = options_of(seed, 31 * 32);
    options.ladder.levels_chosen = true;
    options.ladder.ladder_adapts = true;
    options.ladder.round_scans = 32;
    sampling::ParallelTempering plan(options);
    std::vector<double> counts(k_places, 0.0);
    run_serially(plan, worker, [&](const plan::UnitResult& result) {
      const plan::ScanRecord& record = result.scans.front();
      const plan::Unit& unit = result.unit;
      const bool fresh = unit.starts || record.inverse_temperature == 0;
      ASSERT_EQ(
          record.lineage,
          fresh ? plan::lineage_from(unit.replica.replica, unit.first_scan.value) : unit.lineage);
      if (record.inverse_temperature != 1 || unit.first_scan.value < 15 * 32) return;
      ++counts[static_cast<std::size_t>(record.outcome.front())];
    });
    for (std::size_t place = 0; place < k_places; ++place)
      shares[place].push_back(counts[place] / (16 * 32));
    levels_max = std::max(levels_max, plan.ladders()[0].rounds().back().counts.size());
  }
  const std::vector<double> exact = RuggedRing::exact(1);
  for (std::size_t place = 0; place < k_places; ++place) {
    const MeanWithError seen = mean_of_independent(shares[place]);
    fmt::print("place {}: {:.4f} +- {:.4f}, exactly {:.4f}\n", place, seen.mean,
               seen.standard_error, exact[place]);
    EXPECT_NEAR(seen.mean, exact[place], 5 * seen.standard_error) << "seed " << k_seed;
    EXPECT_LT(seen.standard_error, 0.01);
  }
  EXPECT_LE(levels_max, 8U);
}

}  // namespace sleight::statistical::ladder_invariance_test
