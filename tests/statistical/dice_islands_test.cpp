// Compares islands of dice with draws from the prior, and particle steps with exact draws.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/statistical/support/compare_islands.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/support/property.h"
#include "worker/sampling/particle_steps.h"
#include "worker/worlds/dice/throw_stages.h"

namespace sleight::statistical::dice_islands_test {

using worlds::dice::Goal;
using worlds::dice::Parameters;
using worlds::dice::Place;
using worlds::dice::StagedDice;

constexpr std::uint64_t k_seed = 223606;

sampling::ChainStreams streams_of(std::uint32_t chain) {
  return {.seed = k_seed, .chain = base::ChainId{chain}, .replica = base::ReplicaId{0}};
}

/// Returns a world of two dice that start 40 mm apart and sometimes collide. Each die has a place
/// as its goal.
StagedDice two_dice(double sigma_m, double tolerance_m) {
  Parameters parameters;
  parameters.world.dice.assign(2, {});
  for (const std::uint32_t die : {0U, 1U}) {
    const double y_m = die == 0 ? -0.02 : 0.02;
    parameters.world.dice[die].position_m.y() = y_m;
    parameters.goals.push_back(
        Goal{.die = die, .wanted = Place{{0.03, y_m}}, .sigma = sigma_m, .tolerance = tolerance_m});
  }
  return StagedDice(parameters);
}

TEST(DiceIslands, AgreeWithRejection) {
  // Goal: islands and draws from the prior give the same Z and P(satisfied) for two dice. Method:
  // estimate Z and P(satisfied) from prior draws, and from islands whose pools have eight throws.
  // The estimates must agree within 4 combined standard errors.
  const StagedDice world = two_dice(0.02, 0.025);
  const int throws = property::long_run() ? 200'000 : 8'000;
  const std::uint32_t islands = property::long_run() ? 20'000 : 700;
  std::vector<double> blind_z;
  std::vector<double> blind_satisfied;
  for (int i = 0; i < throws; ++i) {
    random::Stream stream = streams_of(0).at(random::Purpose::prior, static_cast<std::uint64_t>(i));
    const auto outcome = world.simulate(world.draw_prior(stream));
    blind_z.push_back(std::exp(world.log_constraint(outcome)));
    blind_satisfied.push_back(world.satisfied(outcome) ? 1 : 0);
  }

  auto guide = world.learn(k_seed);
  guide.throws_of_pool = 8;
  std::vector<double> z;
  std::vector<double> satisfied;
  for (std::uint32_t i = 0; i < islands; ++i) {
    const auto island =
        sampling::Islands(world, guide, {.particles = 4}, streams_of(1 + i)).free(0);
    z.push_back(std::exp(island.log_z));
    satisfied.push_back(std::exp(island.log_satisfied));
  }
  expect_equal_means("Z", z, blind_z);
  expect_equal_means("P(satisfied)", satisfied, blind_satisfied);
}

TEST(DiceIslands, PoolsGiveThePrior) {
  // Goal: a throw's weight corrects for how its pool was drawn, and for how the throw was chosen
  // from the pool. Method: estimate Z at inverse temperature 0 from islands. An island has one
  // particle and a pool of two throws. The mean of Z must be 1. If Z counts as 0 whenever a chosen
  // die is slower than average, the mean of Z must be 1/2. Means must agree within 4 standard
  // errors.
  const StagedDice world = two_dice(0.04, 0.05);
  auto guide = world.learn(k_seed);
  guide.throws_of_pool = 2;
  guide.log_floor = -3;
  const std::uint64_t islands = property::long_run() ? 50'000 : property::of_tier(400, 1'500);
  std::array<std::vector<double>, 3> z;
  for (std::uint32_t i = 0; i < islands; ++i) {
    const sampling::IslandOptions options{.particles = 1, .inverse_temperature = 0};
    const auto island = sampling::Islands(world, guide, options, streams_of(5'000'000 + i)).free(0);
    z[0].push_back(std::exp(island.log_z));
    for (const std::size_t die : {0U, 1U}) {
      const bool fast = island.drawn && island.drawn->state.dice[die].velocity_mps.x() > 0.7;
      z.at(1 + die).push_back(fast ? z[0].back() : 0);
    }
  }
  const std::array<double, 3> expected{1, 0.5, 0.5};
  for (std::size_t i = 0; i < 3; ++i) {
    const MeanWithError found = mean_of_independent(z.at(i));
    fmt::print("{:.4g} +- {:.2g}, expected {}\n", found.mean, found.standard_error, expected.at(i));
    EXPECT_LT(std::abs(found.mean - expected.at(i)), 4 * found.standard_error) << i;
    EXPECT_LT(found.standard_error, 0.1) << "says little";
  }
}

TEST(DiceIslands, StepsKeepExactDrawsExact) {
  // Goal: both particle steps (conditional and independence) leave p_w p_c of two dice invariant.
  // Method: make exact draws by rejection, and move half of them by three steps. Compare the dice's
  // speeds and the total duration in the moved half with those in the other half. All p-values must
  // be above 1e-5.
  const StagedDice world = two_dice(0.06, 0.05);
  auto guide = world.learn(k_seed);
  guide.throws_of_pool = 3;
  const sampling::IslandOptions options{.particles = 3, .resample_below = 0.9};
  const std::uint32_t draws = property::long_run() ? 5'000 : 120;
  const auto exact = [&](std::uint64_t number) {
    random::Stream stream = streams_of(2'000'000).at(random::Purpose::prior, number);
    for (;;) {
      auto sample = sampling::evaluate(world, world.draw_prior(stream));
      if (std::log(stream.uniform()) < sample.log_constraint) return sample;
    }
  };
  const auto look_at = [](const auto& sample, std::array<std::vector<double>, 3>& seen) {
    for (const std::size_t die : {0U, 1U})
      seen.at(die).push_back(sample.state.dice[die].velocity_mps.x());
    seen[2].push_back(sample.outcome.end_s);
  };
  for (const bool conditional : {true, false}) {
    std::array<std::vector<double>, 3> after;
    std::array<std::vector<double>, 3> fresh;
    std::uint32_t moved = 0;
    for (std::uint32_t i = 0; i < draws; ++i) {
      sampling::ParticleSample<StagedDice> current{.sample = exact(2 * i)};
      look_at(exact(2 * i + 1), fresh);
      const auto before = current.sample.state;
      const std::uint32_t chain = 3'000'000 + 2 * i + (conditional ? 1 : 0);
      const sampling::Islands islands(world, guide, options, streams_of(chain));
      for (std::uint64_t step = 0; step < 3; ++step) {
        if (conditional) {
          sampling::conditional_step(islands, step, current);
          ASSERT_EQ(current.sample.state.table_key, before.table_key);
        } else {
          sampling::independence_step(islands, 2 * step, current);
        }
      }
      look_at(current.sample, after);
      moved += current.sample.state == before ? 0 : 1;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const double p = kolmogorov_smirnov_p(after.at(i), fresh.at(i));
      fmt::print("{} steps: p {:.3g}\n", conditional ? "conditional" : "independence", p);
      EXPECT_GT(p, 1e-5);
    }
    EXPECT_GT(moved, draws / 3);
  }
}

}  // namespace sleight::statistical::dice_islands_test
