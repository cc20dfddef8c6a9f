// Tests parallel tempering as users run it. Compares the weights of modes, the evidence and the
// rate of round trips with closed forms.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/statistical/support/ball_fixture.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/statistical/support/run_serially.h"
#include "tests/statistical/support/spelling_fixture.h"
#include "tests/statistical/support/toy_worlds.h"
#include "worker/sampling/independent_chains.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"

namespace sleight::statistical {
namespace {

constexpr std::uint64_t k_seed = 299792;
constexpr std::uint64_t k_round_scans = 64;

sampling::ParallelTemperingOptions options_of(std::uint64_t seed, std::uint32_t ladders,
                                              std::uint32_t rounds) {
  return {.ladders = ladders,
          .ladder = {.seed = seed,
                     .chain = {},
                     .first_ladder = sampling::first_ladder(6),
                     .levels_chosen = true,
                     .levels_max = 64,
                     .ladder_adapts = true,
                     .has_scale = {true},
                     .round_scans = k_round_scans},
          .stop = {.scans = {}, .rounds = rounds, .independent_solutions = {}}};
}
std::uint64_t first_scan_of_round(std::uint32_t round) {
  return sampling::scans_through_round(k_round_scans, round - 1);
}

double is_left(const plan::ScanRecord& record) {
  return record.outcome.front() < 0 ? 1 : 0;
}

TwoModes two_modes() {
  TwoModes world;
  world.prior_sd = 4;
  world.step_sd = 1;
  return world;
}

TEST(TwoModesWorld, IsCrossedByTempering) {
  // Goal: parallel tempering finds the weights of both modes. Method: run four ladders on two
  // modes, whose weights are 1 : 4. After six rounds of adaptation, the left mode's share must be
  // right within 5 standard errors. The standard errors include autocorrelation and must be small.
  const TwoModes world = two_modes();
  const run::ChainWorker<TwoModes> worker(world, {.iterations_per_scan = 3});
  sampling::ParallelTempering plan(options_of(k_seed, 4, 8));
  const auto left = run_and_collect(plan, worker, first_scan_of_round(7), is_left);
  const MeanWithError share = mean_of_chains(left);
  fmt::print("left: {:.4f} +- {:.4f}, exactly {:.4f}\n", share.mean, share.standard_error,
             world.left_weight());
  EXPECT_NEAR(share.mean, world.left_weight(), 5 * share.standard_error) << "seed " << k_seed;
  EXPECT_LT(share.standard_error, 0.01);
}

TEST(TwoModesWorld, IsNotCrossedByPlainChains) {
  // Goal: plain Metropolis-Hastings chains don't find the weights of both modes. Method: run 32
  // plain chains on the same two modes. After a tenth of the run, no chain may change its mode.
  // Each chain stays in the mode next to its start, so the left mode's share is near a half.
  const TwoModes world = two_modes();
  const run::ChainWorker<TwoModes> worker(world, {.iterations_per_scan = 3});
  sampling::IndependentChains plan(
      {.chains = 32,
       .round_scans = k_round_scans,
       .stop = {.scans = 20'000, .rounds = {}, .independent_solutions = {}}});
  const auto left = run_and_collect(plan, worker, 2000, is_left);
  std::vector<double> shares;
  for (const std::vector<double>& chain : left) {
    EXPECT_EQ(std::ranges::count(chain, chain.front()), static_cast<std::ptrdiff_t>(chain.size()));
    shares.push_back(chain.front());
  }
  const MeanWithError share = mean_of_independent(shares);
  fmt::print("plain chains: left {:.3f} +- {:.3f}, exactly {:.3f}\n", share.mean,
             share.standard_error, world.left_weight());
  EXPECT_GT(share.mean - world.left_weight(), 2.5 * share.standard_error);
}

TEST(Evidence, HasHonestErrorBars) {
  // Goal: adapting ladders give the right log Z and log P(satisfied), and the reported errors equal
  // the estimates' spread. Method: use an off-centre bullseye, whose values are known. Compute the
  // z-scores of the last round for 300 seeds. The jackknife has 20 parts, so z has about Student's
  // distribution with 19 degrees of freedom (standard deviation 1.06, kurtosis 3.4). The test
  // allows 5 standard errors for 300 seeds. For the mean of z, 5 standard errors are 0.31. The
  // standard error of the standard deviation of z is sqrt(2.4 / 1200) = 4.5%, and 5 standard errors
  // are 22%. Neighbouring parts of a round are slightly correlated, which makes errors too small.
  // The test accepts errors that are up to 10% too small.
  constexpr int k_repeats = 300;
  Bullseye world;
  world.target = 1.5;
  world.sigma = 0.05;
  world.tolerance = 0.06;
  world.step_sd = 0.2;
  const double exact[2] = {world.log_z(), world.log_p_satisfied()};
  std::vector<double> z[2];
  double errors[2] = {};
  for (std::uint64_t repeat = 0; repeat < k_repeats; ++repeat) {
    const std::uint64_t seed = k_seed + repeat;
    const run::ChainWorker<Bullseye> worker(world, {.iterations_per_scan = 2});
    sampling::ParallelTempering plan(options_of(seed, 1, 6));
    run_serially(plan, worker, {});
    const std::vector<sampling::RoundReport>& rounds = plan.ladders()[0].rounds();
    const sampling::RoundStatistics& last = rounds[rounds.size() - 2].statistics;
    const sampling::Estimate estimates[2] = {last.log_z(), last.log_satisfied()};
    for (int i = 0; i < 2; ++i) {
      z[i].push_back((estimates[i].value - exact[i]) / estimates[i].error);
      errors[i] += estimates[i].error / k_repeats;
    }
  }
  const char* const names[2] = {"log Z", "log P"};
  for (int i = 0; i < 2; ++i) {
    const MeanWithError mean = mean_of_independent(z[i]);
    const double sd = mean.standard_error * std::sqrt(double{k_repeats});
    fmt::print("{} {:.4f}, mean error {:.4f}; z: mean {:.3f}, sd {:.3f}\n", names[i], exact[i],
               errors[i], mean.mean, sd);
    EXPECT_NEAR(mean.mean, 0, 0.31) << "seed " << k_seed;
    EXPECT_GT(sd, 1.06 * 0.78) << "seed " << k_seed;
    EXPECT_LT(sd, 1.06 * 1.22 * 1.1) << "seed " << k_seed;
    EXPECT_LT(errors[i], 0.15);
  }
}

TEST(RoundTrips, AreAsManyAsPredicted) {
  // Goal: if exploration is perfect and rejection rates are r, the rate of round trips is 1 / (2 +
  // 2 sum r / (1 - r)). Method: run adapting ladders with workers that draw exactly from each
  // tempered distribution. Targets are narrow and wide, near and far. In the last round, observed
  // and predicted rates must differ by at most 10%. This tolerance is at least 5 standard errors,
  // because the number of trips is at least 2,500 and varies at most like a Poisson process.
  for (const auto& [target, sigma] : {std::pair{0.0, 0.3}, {1.0, 0.02}, {3.0, 0.1}, {0.0, 0.005}}) {
    Bullseye world;
    world.target = target;
    world.sigma = sigma;
    const ExactScans<Bullseye> worker(world, k_seed);
    sampling::ParallelTempering plan(options_of(k_seed, 1, 11));
    run_serially(plan, worker, {});
    const std::vector<sampling::RoundReport>& rounds = plan.ladders()[0].rounds();
    const sampling::RoundReport& last = rounds[rounds.size() - 2];
    const auto trips = static_cast<double>(last.round_trips);
    const double seen = trips / static_cast<double>(last.statistics.scans());
    const std::vector<double> rejections = last.statistics.rejections();
    const double predicted = sampling::predicted_round_trip_rate(rejections);
    const double barrier = sampling::cumulative_barrier(rejections).back();
    fmt::print(
        "barrier {:.3f}, {} levels, rejections {:.3f} to {:.3f}: {} trips, rate {:.5f}, "
        "predicted {:.5f}, ratio {:.3f} +- {:.3f} at most\n",
        barrier, last.counts.size(), std::ranges::min(rejections), std::ranges::max(rejections),
        last.round_trips, seen, predicted, seen / predicted, 1 / std::sqrt(trips));
    EXPECT_GT(last.round_trips, 2500U);
    EXPECT_NEAR(seen / predicted, 1, 0.1) << "seed " << k_seed;
    // The numbers of restarts and trips differ by at most one per replica.
    EXPECT_NEAR(static_cast<double>(last.restarts), trips, static_cast<double>(last.counts.size()));
    // The ladder has converged: rejection rates are about equal, although the first round's rates
    // weren't.
    EXPECT_LT(std::ranges::max(rejections) - std::ranges::min(rejections), 0.06);
    EXPECT_NEAR(static_cast<double>(last.counts.size()), sampling::levels_for(barrier), 1);
  }
}

TEST(BallByTempering, EqualsRejection) {
  // Goal: for the 2D ball, tempering agrees with rejection, and its log Z and log P(satisfied)
  // agree with blind throws. Method: run two ladders. In the last two rounds, compare the ball's
  // functions at inverse temperature 1 with those of 20,000 exact draws. Compare each ladder's log
  // Z and log P(satisfied) with values from 200,000 blind throws. All 12 numbers must agree within
  // 5 standard errors. The test fails by chance with probability 7e-6.
  const Ball ball{worlds::ball_2d::Parameters{}};
  const run::ChainWorker<Ball> worker(ball, {.iterations_per_scan = 4});
  sampling::ParallelTempering plan(options_of(k_seed, 2, 8));
  std::array<std::map<std::pair<std::uint32_t, std::uint64_t>, double>, k_ball_functions> seen;
  run_serially(plan, worker, [&](const plan::UnitResult& result) {
    const plan::ScanRecord& record = result.scans.front();
    const std::uint64_t scan = result.unit.first_scan.value;
    if (record.inverse_temperature != 1 || scan < first_scan_of_round(7)) return;
    const BallSample sample = sampling::evaluate(ball, ball.decode(result.state_after).value());
    const auto values = ball_functions(sample);
    for (std::size_t f = 0; f < values.size(); ++f)
      seen[f][{result.unit.replica.chain.value, scan}] = values[f];
  });

  std::array<std::vector<double>, k_ball_functions> exact;
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    random::Stream stream = streams_of(k_seed + 1, i).at(random::Purpose::start, 0);
    const auto values = ball_functions(exact_draw(ball, 1.0, stream));
    for (std::size_t f = 0; f < values.size(); ++f)
      exact[f].push_back(values[f]);
  }
  const auto expect_same = [](const char* name, const MeanWithError& a, const MeanWithError& b) {
    const double error = std::hypot(a.standard_error, b.standard_error);
    fmt::print("{}: {:.4f} and {:.4f}, z {:.2f}\n", name, a.mean, b.mean,
               (a.mean - b.mean) / error);
    EXPECT_NEAR(a.mean, b.mean, 5 * error) << name << ", seed " << k_seed;
  };
  for (std::size_t f = 0; f < k_ball_functions; ++f) {
    std::vector<std::vector<double>> chains(2);
    for (const auto& [place, value] : seen[f])
      chains[place.first].push_back(value);
    expect_same(k_ball_function_names[f], mean_of_chains(chains), mean_of_independent(exact[f]));
  }

  std::vector<double> densities;
  std::vector<double> satisfied;
  for (std::uint32_t i = 0; i < 200'000; ++i) {
    const auto blind = sampling::draw_afresh(ball, streams_of(k_seed + 2, i), 0);
    densities.push_back(math::exp(blind.log_constraint));
    satisfied.push_back(ball.satisfied(blind.outcome) ? 1 : 0);
  }
  const auto logarithm = [](const MeanWithError& of) {
    return MeanWithError{.mean = std::log(of.mean), .standard_error = of.standard_error / of.mean};
  };
  for (const sampling::LadderRun& ladder : plan.ladders()) {
    const sampling::RoundStatistics& last = ladder.rounds()[ladder.rounds().size() - 2].statistics;
    const sampling::Estimate log_z = last.log_z();
    const sampling::Estimate log_p = last.log_satisfied();
    expect_same("log Z", {log_z.value, log_z.error}, logarithm(mean_of_independent(densities)));
    expect_same("log P", {log_p.value, log_p.error}, logarithm(mean_of_independent(satisfied)));
    EXPECT_LT(log_p.error, 0.1);
  }
}

TEST(SpellingByTempering, EqualsRejection) {
  // Goal: tempering and rejection agree if the number of variables varies. Method: use two bins.
  // Run 32 ladders. In the last round, compare the set of active balls and the number of filled
  // bins with those of 20,000 exact draws. Each of the 12 shares must be right within 5 standard
  // errors. Standard errors come from the spread over ladders. The test fails by chance with
  // probability 7e-6.
  const Spelling world = world_with(worlds::spelling::Kernel::correct);
  const run::ChainWorker<Spelling> worker(world_with(worlds::spelling::Kernel::correct),
                                          {.iterations_per_scan = 2});
  constexpr std::uint32_t k_ladders = 32;
  sampling::ParallelTemperingOptions options = options_of(k_seed, k_ladders, 5);
  options.ladder.has_scale.clear();
  for (std::uint32_t kind = 0; kind < world.proposal_kinds(); ++kind)
    options.ladder.has_scale.push_back(world.has_scale(kind));
  options.ladder.round_scans = 32;
  sampling::ParallelTempering plan(options);
  constexpr std::size_t k_cells = 12;
  const auto cell_of = [&](const worlds::spelling::State& state, std::uint32_t filled) {
    return (state.active[0] + 2U * state.active[1]) * 3 + filled;
  };
  std::vector<std::vector<double>> shares(k_cells, std::vector<double>(k_ladders, 0.0));
  run_serially(plan, worker, [&](const plan::UnitResult& result) {
    const plan::ScanRecord& record = result.scans.front();
    if (record.inverse_temperature != 1 || result.unit.first_scan.value < 15 * 32) return;
    const auto state = world.decode(result.state_after).value();
    const std::size_t cell = cell_of(state, world.simulate(state).filled);
    shares[cell][result.unit.replica.chain.value] += 1 / (16.0 * 32);
  });
  std::vector<std::vector<double>> exact(k_cells);
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    random::Stream stream = streams_of(k_seed + 3, i).at(random::Purpose::start, 0);
    const SpellingSample sample = exact_draw(world, 1.0, stream);
    const std::size_t drawn = cell_of(sample.state, sample.outcome.filled);
    for (std::size_t cell = 0; cell < k_cells; ++cell)
      exact[cell].push_back(cell == drawn ? 1 : 0);
  }
  for (std::size_t cell = 0; cell < k_cells; ++cell) {
    const MeanWithError a = mean_of_independent(shares[cell]);
    const MeanWithError b = mean_of_independent(exact[cell]);
    const double error = std::hypot(a.standard_error, b.standard_error);
    fmt::print("cell {}: {:.4f} +- {:.4f} and {:.4f}\n", cell, a.mean, a.standard_error, b.mean);
    EXPECT_LE(std::abs(a.mean - b.mean), 5 * error) << "seed " << k_seed;
  }
}

}  // namespace
}  // namespace sleight::statistical
