// Tests that simulated tempering, tempered transitions and annealed importance sampling sample
// their targets after a burn-in. Also tests annealed starts. The targets are known by enumeration.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/math/elementary.h"
#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/statistical/support/run_serially.h"
#include "tests/statistical/support/toy_worlds.h"
#include "tests/support/property.h"
#include "worker/sampling/annealed_importance.h"
#include "worker/sampling/burnt_in_chains.h"
#include "worker/sampling/excursions.h"
#include "worker/sampling/independent_chains.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"
#include "worker/sampling/simulated_tempering.h"

namespace sleight::statistical::burnt_in_methods_test {

constexpr std::uint64_t k_seed = 891058;
constexpr std::size_t k_places = RuggedRing::k_places;
constexpr double k_p_least = 1e-6;

sampling::LadderOptions ladder_options(std::uint64_t seed, std::uint64_t anneal_scans = 0) {
  return {.seed = seed,
          .chain = {},
          .first_ladder = sampling::first_ladder(4),
          .levels_chosen = false,
          .levels_max = 4,
          .ladder_adapts = true,
          .has_scale = {},
          .round_scans = 20,
          .anneal_scans = anneal_scans};
}

sampling::StopRule after(std::uint64_t scans) {
  return {.scans = scans, .rounds = {}, .independent_solutions = {}};
}

/// Log of the sum of p_w p_c^beta.
double log_z(double beta) {
  double sum = 0;
  for (std::size_t i = 0; i < k_places; ++i)
    sum +=
        RuggedRing::k_prior[i] * (beta == 0 ? 1 : std::exp(beta * RuggedRing::k_log_constraint[i]));
  return std::log(sum);
}

double log_p_satisfied() {
  return std::log(RuggedRing::k_prior[5] + RuggedRing::k_prior[10]);
}

std::size_t place_of(const plan::ScanRecord& record) {
  return static_cast<std::size_t>(record.outcome.front());
}

/// A part of a chain. The part starts from an exact draw and continues a given burn-in.
template <class Part>
class StartedPart {
 public:
  StartedPart(Part part, std::uint64_t seed, const sampling::BurnIn& burn_in)
      : part_(std::move(part)), worker_({}, {}) {
    random::Stream stream({.seed = seed, .chain = burn_in.chain, .purpose = random::Purpose::start},
                          0);
    state_ = RuggedRing{}.encode(RuggedRing{}.draw_exact(1, stream));
  }
  plan::ScanRecord step() {
    const plan::Unit unit = part_.next_unit(UINT64_MAX, 1).value();
    const plan::UnitResult result = worker_.run(unit, state_);
    state_ = result.state_after;
    part_.consume(unit.replica.replica, unit.first_scan.value, result.scans);
    return result.scans.front();
  }

 private:
  Part part_;
  run::ChainWorker<RuggedRing> worker_;
  base::Bytes state_;
};

sampling::BurnIn ring_burn_in(std::uint32_t chain) {
  sampling::BurnIn burn_in{.seed = k_seed,
                           .chain = base::ChainId{chain},
                           .scans = 1,
                           .coolest = base::ReplicaId{0},
                           .first_free = base::ReplicaId{1},
                           .lineage = 0,
                           .ladder = {0, 0.15, 0.5, 1},
                           .scales = {{}, {}, {}, {}},
                           .log_z_steps = {},
                           .next_ladder = {0, 0.15, 0.5, 1},
                           .next_scales = {{}, {}, {}, {}}};
  // Make the weights wrong by factors that a test can detect.
  const double off[3] = {0.4, -0.7, 0.5};
  for (std::size_t i = 0; i + 1 < burn_in.ladder.size(); ++i)
    burn_in.log_z_steps.push_back(log_z(burn_in.ladder[i + 1]) - log_z(burn_in.ladder[i]) + off[i]);
  return burn_in;
}

TEST(SimulatedTempering, HasItsJointDistribution) {
  // Goal: for any weights w_i, simulated tempering samples (level, place) with density w_i p_w
  // p_c^beta_i. Method: start chains from exact draws at the coolest level, and run each for 120
  // scans. Compare the last states with enumeration, in three tests: levels alone, levels together
  // with places, and places at the coolest level. The fast tier uses as many chains as
  // mutants/method_checks.cpp, which rejects every mutant.
  const std::uint64_t chains = property::of_tier(12'000, 20'000);
  constexpr std::size_t k_levels = 4;
  const sampling::BurnIn first = ring_burn_in(0);
  std::vector<double> exact;
  double log_w = 0;
  for (std::size_t level = 0; level < k_levels; ++level) {
    if (level > 0) log_w -= first.log_z_steps[level - 1];
    for (const double p : RuggedRing::exact(first.ladder[level]))
      exact.push_back(p * std::exp(log_w + log_z(first.ladder[level])));
  }
  const double sum = std::accumulate(exact.begin(), exact.end(), 0.0);
  for (double& p : exact)
    p /= sum;
  std::vector<double> levels(k_levels, 0);
  std::vector<double> exact_levels(k_levels, 0);
  std::vector<double> counts(k_levels * k_places, 0);
  std::vector<double> coolest(k_places, 0);
  for (std::uint32_t chain = 0; chain < chains; ++chain) {
    const sampling::BurnIn burn_in = ring_burn_in(chain);
    StartedPart walk(sampling::SimulatedTempering(burn_in), k_seed, burn_in);
    plan::ScanRecord last;
    for (int scan = 0; scan < 120; ++scan)
      last = walk.step();
    const auto level = static_cast<std::size_t>(
        std::ranges::find(burn_in.ladder, last.inverse_temperature) - burn_in.ladder.begin());
    ++levels.at(level);
    ++counts.at(level * k_places + place_of(last));
    if (level + 1 == k_levels) ++coolest[place_of(last)];
  }
  for (std::size_t cell = 0; cell < exact.size(); ++cell)
    exact_levels[cell / k_places] += exact[cell];
  const double p_levels = chi_square_p(levels, exact_levels);
  const double p_joint = chi_square_p(counts, exact);
  const double p_coolest = chi_square_p(coolest, RuggedRing::exact(1));
  fmt::print("levels {:.4f} {:.4f} {:.4f} {:.4f}; p {:.3g}, joint {:.3g}, at 1 {:.3g}\n",
             exact_levels[0], exact_levels[1], exact_levels[2], exact_levels[3], p_levels, p_joint,
             p_coolest);
  EXPECT_GT(p_levels, k_p_least) << "seed " << k_seed;
  EXPECT_GT(p_joint, k_p_least) << "seed " << k_seed;
  EXPECT_GT(p_coolest, k_p_least) << "seed " << k_seed;
  // The test must detect the wrong weights: it must reject equal occupancy of all levels.
  EXPECT_LT(chi_square_p(levels, std::vector<double>(k_levels, 0.25)), 1e-12);
}

/// Makes a run and counts its draws at each place, from `first_draw` on.
std::vector<double> place_counts(plan::Plan& plan, std::uint64_t first_draw) {
  const run::ChainWorker<RuggedRing> worker({}, {});
  std::vector<double> counts(k_places, 0);
  run_serially(plan, worker, [&](const plan::UnitResult& result) {
    for (std::uint64_t nth = 0; nth < result.scans.size(); ++nth) {
      if (result.unit.first_scan.value + nth < first_draw) continue;
      if (result.scans[nth].inverse_temperature == 1) ++counts[place_of(result.scans[nth])];
    }
  });
  return counts;
}

/// Expects that each place's share of the draws is within 5 standard errors of the place's
/// probability. The errors come from independent runs.
void expect_shares(const char* name, const std::vector<std::vector<double>>& runs) {
  const std::vector<double> exact = RuggedRing::exact(1);
  const auto n = static_cast<double>(runs.size());
  double draws = 0;
  for (const std::vector<double>& run : runs)
    draws += std::accumulate(run.begin(), run.end(), 0.0) / n;
  double worst = 0;
  for (std::size_t i = 0; i < k_places; ++i) {
    if (exact[i] == 0) {
      for (const std::vector<double>& run : runs)
        EXPECT_EQ(run[i], 0) << name << ", place " << i;
      continue;
    }
    std::vector<double> deviations;
    for (const std::vector<double>& run : runs)
      deviations.push_back((run[i] - exact[i] * std::accumulate(run.begin(), run.end(), 0.0)) /
                           draws);
    const MeanWithError mean = mean_of_independent(deviations);
    const double z = mean.mean / mean.standard_error;
    worst = std::max(worst, std::abs(z));
    EXPECT_LT(std::abs(z), 5) << name << ", place " << i << ", seed " << k_seed;
    EXPECT_LT(mean.standard_error, 0.02);
  }
  fmt::print("{}: {:.0f} draws a run, largest |z| {:.2f}\n", name, draws, worst);
}

template <class MakePart>
std::unique_ptr<plan::Plan> burnt_in(std::uint64_t seed, std::uint64_t scans, MakePart make) {
  return std::make_unique<sampling::BurntInChains>(sampling::BurntInOptions{
      .chains = 1,
      .ladder = ladder_options(seed),
      .burn_in_rounds = 3,
      .stop = after(scans),
      .go_on = [=](const sampling::BurnIn& found) -> std::unique_ptr<sampling::ChainPart> {
        return make(found);
      }});
}
constexpr std::uint64_t k_burn_in = 140;

TEST(SimulatedTempering, IsRightAfterALearntBurnIn) {
  // Goal: if the weights come from a burn-in, simulated tempering draws from the target at inverse
  // temperature 1, and visits each level often. Method: make 400 runs of 1,500 scans after three
  // burn-in rounds, and compare the shares of places with enumeration.
  std::vector<std::vector<double>> runs;
  double least = 1;
  double trips = 0;
  for (std::uint64_t repeat = 0; repeat < 400; ++repeat) {
    const auto plan = burnt_in(k_seed + repeat, k_burn_in + 1500, [](const auto& found) {
      return std::make_unique<sampling::SimulatedTempering>(found);
    });
    runs.push_back(place_counts(*plan, k_burn_in));
    for (const plan::Table& table : plan->report().tables) {
      if (table.name == "walk_visits")
        least = std::min(least, std::ranges::min(table.values) / 1500);
      if (table.name == "walk_round_trips") trips += table.values[0] / 400;
    }
  }
  expect_shares("simulated tempering", runs);
  fmt::print("least share of a level {:.3f}; {:.1f} round trips a run\n", least, trips);
  EXPECT_GT(least, 0.02);
  EXPECT_GT(trips, 20);
}

TEST(TemperedTransitions, AreRightAfterALearntBurnIn) {
  // Goal: tempered transitions sample the target. Method: make 400 runs of 300 scans after a
  // burn-in, and compare the shares of places with enumeration.
  std::vector<std::vector<double>> runs;
  double acceptance = 0;
  for (std::uint64_t repeat = 0; repeat < 400; ++repeat) {
    const auto plan = burnt_in(k_seed + repeat, k_burn_in + 300, [](const auto& found) {
      return std::make_unique<sampling::Excursions>(found, 2);
    });
    runs.push_back(place_counts(*plan, k_burn_in));
    for (const plan::Table& table : plan->report().tables) {
      if (table.name == "excursion_acceptance") acceptance += table.values[0] / 400;
    }
  }
  expect_shares("tempered transitions", runs);
  fmt::print("accepted {:.3f}\n", acceptance);
  EXPECT_GT(acceptance, 0.05);
}

TEST(AnnealedImportance, WeightsAreUnbiased) {
  // Goal: annealed importance sampling estimates Z and P(satisfied) without bias, and its errors
  // are calibrated. Weighted draws have the target's distribution. Method: make 1,500 runs, each
  // with a short burn-in and 24 ascents. The mean ratio of an estimate to the exact value must be
  // 1. The z-scores of the log estimates must have a standard deviation between 0.8 and 1.4. The
  //    range is wide because the weights of 24 ascents are skewed. Each place's share of the
  //    weights must equal its probability.
  constexpr std::uint64_t k_repeats = 1500;
  std::vector<double> ratios[2];
  std::vector<double> z[2];
  std::vector<std::vector<double>> places;
  std::vector<double> unweighted(k_places, 0);
  const double exact[2] = {log_z(1), log_p_satisfied()};
  for (std::uint64_t repeat = 0; repeat < k_repeats; ++repeat) {
    const std::uint64_t seed = k_seed + repeat;
    std::uint64_t per_ascent = 0;
    const auto plan = burnt_in(seed, k_burn_in + 6 * 7, [&](const auto& found) {
      auto part = std::make_unique<sampling::AnnealedImportance>(found, 4, 2);
      per_ascent = part->schedule().size();
      return part;
    });
    const run::ChainWorker<RuggedRing> worker({}, {});
    std::map<std::pair<std::uint64_t, std::uint32_t>, std::size_t> ends;
    run_serially(*plan, worker, [&](const plan::UnitResult& result) {
      const plan::ScanRecord& record = result.scans.front();
      const std::uint64_t scan = result.unit.first_scan.value;
      if (scan >= k_burn_in && record.inverse_temperature == 1)
        ends[{scan, result.unit.replica.replica.value}] = place_of(record);
    });
    ASSERT_EQ(per_ascent, 7U);
    ASSERT_EQ(ends.size(), 24U);
    double found[2] = {};
    double errors[2] = {};
    std::vector<double> log_weights;
    for (const plan::Table& table : plan->report().tables) {
      if (table.name == "ais_log_z") found[0] = table.values[0];
      if (table.name == "ais_log_z_error") errors[0] = table.values[0];
      if (table.name == "ais_log_p_satisfied") found[1] = table.values[0];
      if (table.name == "ais_log_p_satisfied_error") errors[1] = table.values[0];
      if (table.name == "log_weight") log_weights = table.values;
    }
    ASSERT_EQ(log_weights.size(), ends.size());
    for (int i = 0; i < 2; ++i) {
      ratios[i].push_back(std::exp(found[i] - exact[i]));
      if (std::isfinite(errors[i])) z[i].push_back((found[i] - exact[i]) / errors[i]);
    }
    std::vector<double>& sums = places.emplace_back(k_places, 0.0);
    std::size_t draw = 0;
    for (const auto& [place, end] : ends) {
      sums[end] += std::exp(log_weights[draw++] - exact[0]);
      ++unweighted[end];
    }
  }
  const char* const names[2] = {"Z", "P"};
  for (int i = 0; i < 2; ++i) {
    const MeanWithError ratio = mean_of_independent(ratios[i]);
    const MeanWithError score = mean_of_independent(z[i]);
    const double sd = score.standard_error * std::sqrt(static_cast<double>(z[i].size()));
    fmt::print("{}: mean ratio {:.4f} +- {:.4f}; z of the log: mean {:.3f}, sd {:.3f}\n", names[i],
               ratio.mean, ratio.standard_error, score.mean, sd);
    EXPECT_NEAR(ratio.mean, 1, 5 * ratio.standard_error) << "seed " << k_seed;
    EXPECT_LT(ratio.standard_error, 0.02);
    EXPECT_GT(sd, 0.8);
    EXPECT_LT(sd, 1.4);
  }
  expect_shares("weighted ascents", places);
  // Without their weights, ascents have a wrong distribution. The comparison must reject this
  // distribution.
  EXPECT_LT(chi_square_p(unweighted, RuggedRing::exact(1)), 1e-12);
}

TEST(AnnealedImportance, ErrorsAreHonestWithManyAscents) {
  // Goal: if a run has many ascents, the reported standard errors of log Z and log P equal the
  // spread of the estimates. Method: make 200 runs of 800 ascents, and compute a z-score for each
  // run. For 200 runs, 5 standard errors are 0.35 for the mean of z, and 25% for the standard
  // deviation of z.
  std::vector<double> z[2];
  for (std::uint64_t repeat = 0; repeat < 200; ++repeat) {
    const std::uint64_t seed = k_seed + 10'000 + repeat;
    const auto plan = burnt_in(seed, k_burn_in + 200 * 7, [](const auto& found) {
      return std::make_unique<sampling::AnnealedImportance>(found, 4, 2);
    });
    const run::ChainWorker<RuggedRing> worker({}, {});
    run_serially(*plan, worker, {});
    double found[4] = {};
    const char* const names[4] = {"ais_log_z", "ais_log_z_error", "ais_log_p_satisfied",
                                  "ais_log_p_satisfied_error"};
    for (const plan::Table& table : plan->report().tables) {
      for (int i = 0; i < 4; ++i) {
        if (table.name == names[i]) found[i] = table.values[0];
      }
    }
    z[0].push_back((found[0] - log_z(1)) / found[1]);
    z[1].push_back((found[2] - log_p_satisfied()) / found[3]);
  }
  for (const std::vector<double>& scores : z) {
    const MeanWithError mean = mean_of_independent(scores);
    const double sd = mean.standard_error * std::sqrt(200.0);
    fmt::print("z: mean {:.3f}, sd {:.3f}\n", mean.mean, sd);
    EXPECT_NEAR(mean.mean, 0, 0.36) << "seed " << k_seed;
    EXPECT_NEAR(sd, 1, 0.26) << "seed " << k_seed;
  }
}

TEST(AnnealedStarts, LeaveTheTargetRight) {
  // Goal: if ladders and plain chains start by annealing, they sample the target. Method: anneal
  // 400 ladders over 30 scans, skip 100 more scans, then compare the shares of places with
  // enumeration. In a world that a random walk can cover, anneal 20,000 plain chains over 25 scans.
  // Run these chains for 60 more scans. Compare the last states of these chains with exact draws
  // (Kolmogorov-Smirnov).
  std::vector<std::vector<double>> runs;
  for (std::uint64_t repeat = 0; repeat < 400; ++repeat) {
    sampling::ParallelTempering plan({.ladders = 1,
                                      .ladder = ladder_options(k_seed + repeat, 30),
                                      .stop = after(30 + 100 + 400)});
    runs.push_back(place_counts(plan, 30 + 100));
  }
  expect_shares("annealed ladders", runs);

  Bullseye world;
  world.target = 1.5;
  world.sigma = 0.3;
  world.step_sd = 0.5;
  constexpr std::uint32_t k_chains = 20'000;
  const run::ChainWorker<Bullseye> worker(world, {});
  sampling::IndependentChains plan({.seed = k_seed,
                                    .chains = k_chains,
                                    .round_scans = 10,
                                    .anneal_scans = 25,
                                    .stop = after(86)});
  std::vector<double> ends;
  run_serially(plan, worker, [&](const plan::UnitResult& result) {
    if (result.unit.first_scan.value == 85) ends.push_back(result.scans.front().outcome.front());
  });
  std::vector<double> exact;
  for (std::uint32_t i = 0; i < k_chains; ++i) {
    random::Stream stream(
        {.seed = k_seed, .chain = base::ChainId{i}, .purpose = random::Purpose::start}, 0);
    exact.push_back(world.draw_exact(1, stream));
  }
  ASSERT_EQ(ends.size(), std::size_t{k_chains});
  const double p = kolmogorov_smirnov_p(ends, exact);
  fmt::print("annealed plain chains: p {:.3g}\n", p);
  EXPECT_GT(p, k_p_least) << "seed " << k_seed;
}

}  // namespace sleight::statistical::burnt_in_methods_test
