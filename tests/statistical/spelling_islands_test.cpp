// Compares islands of balls that spell with draws from the prior, and particle steps with exact
// draws.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/compare_islands.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/statistical/support/spelling_fixture.h"
#include "tests/support/property.h"
#include "worker/sampling/particle_steps.h"
#include "worker/worlds/spelling/pouring_stages.h"

namespace sleight::statistical::spelling_islands_test {

using worlds::spelling::LandingMap;
using worlds::spelling::PouringGuide;
using worlds::spelling::StagedSpelling;

constexpr std::uint64_t k_seed = 173205;

sampling::ChainStreams streams_of(std::uint32_t chain) {
  return {.seed = k_seed, .chain = base::ChainId{chain}, .replica = base::ReplicaId{0}};
}

PouringGuide guide_of(const StagedSpelling& world, std::uint32_t drops_per_bin) {
  return {.map = LandingMap(worlds::spelling::landings_of(world, k_seed, 10)),
          .takes_part = 0.8,
          .log_elsewhere = -1.5,
          .drops_per_bin = drops_per_bin};
}

struct Estimates {
  std::vector<double> z;
  std::vector<double> satisfied;
};

void expect_mean(const char* name, const std::vector<double>& draws, double expected) {
  const MeanWithError found = mean_of_independent(draws);
  fmt::print("{}: {:.4g} +- {:.2g}, expected {}\n", name, found.mean, found.standard_error,
             expected);
  EXPECT_LT(std::abs(found.mean - expected), 4 * found.standard_error) << name;
}

TEST(SpellingIslands, AgreeWithRejection) {
  // Goal: islands and draws from the prior give the same Z and P(satisfied) for three balls.
  // Method: estimate Z and P(satisfied) from prior draws, from joint islands, and from islands with
  // each of two guides. The estimates must agree within 4 combined standard errors.
  worlds::spelling::Parameters parameters;
  parameters.pattern = worlds::spelling::pattern_of_rows("#.#\n.#.").value();
  parameters.constraint.log_lambda = 1.5;
  const StagedSpelling world(parameters);
  const int throws = property::long_run() ? 400'000 : 30'000;
  const std::uint32_t islands = property::long_run() ? 10'000 : 600;

  // If all three balls are active, P(satisfied) is eight times as high. So activate all balls.
  Estimates blind;
  for (int i = 0; i < throws; ++i) {
    random::Stream stream = streams_of(0).at(random::Purpose::prior, static_cast<std::uint64_t>(i));
    auto state = world.draw_prior(stream);
    blind.z.push_back(std::exp(world.log_constraint(world.simulate(state))));
    for (std::size_t ball = 0; ball < world.balls(); ++ball) {
      if (state.active[ball] != 0) continue;
      state.active[ball] = 1;
      state.drops_m[ball] = world.prior().draw_drop(stream);
    }
    blind.satisfied.push_back(world.satisfied(world.simulate(state)) ? 0.125 : 0);
  }

  PouringGuide guide = guide_of(world, 20);
  std::uint32_t chain = 1;
  for (const auto& [takes_part, together] : {std::pair(0.8, false), {0.5, false}, {0.8, true}}) {
    guide.takes_part = takes_part;
    Estimates by_islands;
    for (std::uint32_t i = 0; i < islands; ++i) {
      const PouringGuide used = together ? world.for_odds(guide) : guide;
      const sampling::Islands made(world, used, {.particles = 12}, streams_of(chain++));
      const auto island = together ? made.joint(0) : made.free(0);
      by_islands.z.push_back(std::exp(island.log_z));
      by_islands.satisfied.push_back(std::exp(island.log_satisfied));
      if (island.drawn && i < 20) {
        const auto fresh = world.simulate(island.drawn->state);
        EXPECT_EQ(fresh.filling, island.drawn->outcome.filling);
      }
    }
    expect_equal_means("Z", by_islands.z, blind.z);
    expect_equal_means("P(satisfied)", by_islands.satisfied, blind.satisfied);
  }
}

TEST(SpellingIslands, BallsThatOthersRescueCount) {
  // Goal: joint islands lose no prefix that later balls would rescue. Method: use two balls. Let A
  // be the states whose first ball fills no bin if it is simulated alone. Among 54,000 blind throws
  // that satisfy the constraint, 10.2% are in A. Draw states by 1,500 islands. The states in A must
  // have the same share of the weight of all satisfying states, within 4 standard errors of 0.008
  // each.
  worlds::spelling::Parameters parameters;
  parameters.pattern = worlds::spelling::pattern_of_rows("#.#").value();
  const StagedSpelling world(parameters);
  const PouringGuide guide = world.for_odds(world.learn(k_seed));
  double rescued = 0;
  double all = 0;
  for (std::uint32_t i = 0; i < 1'500; ++i) {
    const auto island =
        sampling::Islands(world, guide, {.particles = 32}, streams_of(7'000'000 + i)).joint(0);
    if (!island.drawn || !world.satisfied(island.drawn->outcome)) continue;
    const double z = std::exp(island.log_z);
    all += z;
    auto first_alone = island.drawn->state;
    first_alone.active[1] = 0;
    if (world.simulate(first_alone).filled == 0) rescued += z;
  }
  fmt::print("rescued: {:.4f} of what satisfies\n", rescued / all);
  EXPECT_NEAR(rescued / all, 0.102, 0.032);
}

TEST(SpellingIslands, PoolsGiveThePrior) {
  // Goal: a drop's weight corrects for how its pool was drawn, shared and used, even if the pool is
  // the smallest. Method: estimate Z at inverse temperature 0. The mean of Z must be 1 for any
  // guide. If a ball takes no part, count Z as 0; then the mean must be 1/4. If the first ball is
  // on the right, also count Z as 0; then the mean must be 1/8. Use free and joint islands of one
  // particle, bins that are far apart, and two drops per bin. Means must agree within 4 standard
  // errors.
  worlds::spelling::Parameters parameters;
  parameters.pattern = worlds::spelling::pattern_of_rows("#...#").value();
  parameters.constraint.log_lambda = 0.5;
  const StagedSpelling world(parameters);
  PouringGuide guide = guide_of(world, 2);
  guide.log_elsewhere = -0.5;
  guide.prior_share = 0.5;
  guide.odds = {.own_bin = 0.5,
                .beside = {0.4, 0.4, 0.4, 0.4},
                .above_full = {0.3, 0.2, 0.3, 0.3},
                .meets_full = {0.2, 0.1, 0.2, 0.2},
                .misses = {0.2, 0.2, 0.2, 0.2}};
  const std::uint32_t islands = property::long_run() ? 200'000 : 10'000;
  for (const bool together : {false, true}) {
    std::vector<double> z;
    std::vector<double> both;
    std::vector<double> both_and_left;
    for (std::uint32_t i = 0; i < islands; ++i) {
      const sampling::IslandOptions options{.particles = 1, .inverse_temperature = 0};
      const sampling::Islands made(world, guide, options, streams_of(5'000'000 + i));
      const auto island = together ? made.joint(0) : made.free(0);
      z.push_back(std::exp(island.log_z));
      const bool has_both = island.drawn && island.drawn->state.active_count() == 2;
      both.push_back(has_both ? z.back() : 0);
      both_and_left.push_back(has_both && island.drawn->state.drops_m[0].x() < 0 ? z.back() : 0);
    }
    expect_mean("Z", z, 1);
    expect_mean("with both balls", both, 0.25);
    expect_mean("and the first on the left", both_and_left, 0.125);
  }
}

TEST(SpellingIslands, GivenDropsLieInTheStrataThatGaveThem) {
  // Goal: if a pool is drawn given a state, each of the state's drops is in stratum b with a
  // probability proportional to q_b at the drop. All places of a stratum are equally likely.
  // Method: draw 4,000 pools for two drops. Shares must be right within 5 standard errors. Each
  // drop must be at its own place and at no other.
  auto parameters = world_with(worlds::spelling::Kernel::correct).parameters();
  parameters.pattern = worlds::spelling::pattern_of_rows("#...#").value();
  const StagedSpelling world(parameters);
  const PouringGuide guide = guide_of(world, 3);
  random::Stream stream = streams_of(6'000'000).at(random::Purpose::ground, 0);
  auto state = world.draw_prior(stream);
  state.active = {1, 1};
  state.drops_m = {0.9 * world.middle_m(0), 0.7 * world.middle_m(1)};
  constexpr int k_pools = 4'000;
  constexpr std::uint32_t k_places = 3;
  std::array<int, 2> in_first_stratum{};
  std::array<std::array<int, 2 * k_places>, 2> at_place{};
  for (int pool = 0; pool < k_pools; ++pool) {
    const auto ground = world.ground_given(guide, state, stream);
    ASSERT_EQ(ground.pool.size(), 2 * k_places);
    for (std::size_t ball = 0; ball < 2; ++ball) {
      const std::uint32_t place = ground.retained[ball];
      in_first_stratum.at(ball) += place < k_places ? 1 : 0;
      ++at_place.at(ball).at(place);
      for (std::uint32_t other = 0; other < 2 * k_places; ++other)
        ASSERT_EQ(ground.pool[other].drop_m == state.drops_m[ball], other == place);
    }
  }
  for (std::size_t ball = 0; ball < 2; ++ball) {
    const double first = world.density_of_stratum(guide, 0, state.drops_m[ball]);
    const double second = world.density_of_stratum(guide, 1, state.drops_m[ball]);
    const double share = first / (first + second);
    EXPECT_NEAR(in_first_stratum.at(ball) / double{k_pools}, share,
                5 * std::sqrt(share * (1 - share) / k_pools))
        << "ball " << ball;
    for (std::uint32_t place = 0; place < 2 * k_places; ++place) {
      const double each = (place < k_places ? share : 1 - share) / k_places;
      EXPECT_NEAR(at_place.at(ball).at(place) / double{k_pools}, each,
                  5 * std::sqrt(each * (1 - each) / k_pools))
          << "ball " << ball << ", place " << place;
    }
    // Check that the strata have different shares.
    EXPECT_GT(std::abs(share - 0.5), 0.1);
  }
}

struct Seen {
  std::vector<double> filled = std::vector<double>(3, 0.0);  ///< Counts.
  std::vector<double> active = std::vector<double>(3, 0.0);
  std::array<std::vector<double>, 2> drop_x_m;  ///< Of each ball, if active.

  void add(const sampling::Sample<StagedSpelling>& sample) {
    ++filled.at(sample.outcome.filled);
    ++active.at(sample.state.active_count());
    for (std::size_t ball = 0; ball < 2; ++ball)
      if (sample.state.active[ball] != 0)
        drop_x_m.at(ball).push_back(sample.state.drops_m[ball].x());
  }
};

TEST(SpellingIslands, StepsKeepExactDrawsExact) {
  // Goal: both particle steps (conditional and independence) leave p_w p_c of two balls invariant.
  // Method: move exact draws by five steps. Compare them with the same number of other exact draws.
  // Compare the number of active balls, the number of filled bins, and the places of drops. All
  // eight p-values must be above 1e-5. Bins are far apart and drops are few, so that the pool's
  // strata and places matter as much as possible.
  auto parameters = world_with(worlds::spelling::Kernel::correct).parameters();
  parameters.pattern = worlds::spelling::pattern_of_rows("#...#").value();
  const StagedSpelling world(parameters);
  PouringGuide guide = guide_of(world, 2);
  guide.prior_share = 0.1;
  const sampling::IslandOptions options{.particles = 4, .resample_below = 0.9};
  const int draws = property::long_run() ? 30'000 : static_cast<int>(property::of_tier(800, 2'500));
  const auto exact = [&](std::uint64_t number) {
    random::Stream stream = streams_of(2'000'000).at(random::Purpose::prior, number);
    SpellingSample drawn = exact_draw(static_cast<const Spelling&>(world), 1, stream);
    return sampling::Sample<StagedSpelling>{std::move(drawn.state), std::move(drawn.outcome),
                                            drawn.log_prior, drawn.log_constraint};
  };
  for (const bool conditional : {true, false}) {
    Seen after;
    Seen fresh;
    int moved = 0;
    for (int i = 0; i < draws; ++i) {
      const auto number = static_cast<std::uint64_t>(2 * i);
      sampling::ParticleSample<StagedSpelling> current{.sample = exact(number)};
      fresh.add(exact(number + 1));
      const auto before = current.sample.state;
      const sampling::ChainStreams streams =
          streams_of(3'000'000 + static_cast<std::uint32_t>(2 * i + (conditional ? 1 : 0)));
      const sampling::Islands islands(world, guide, options, streams);
      for (std::uint64_t step = 0; step < 5; ++step) {
        if (conditional) {
          sampling::conditional_step(islands, step, current);
          ASSERT_EQ(current.sample.state.offsets_m, before.offsets_m);
        } else {
          sampling::independence_step(islands, 2 * step, current);
        }
      }
      after.add(current.sample);
      moved += current.sample.state == before ? 0 : 1;
    }
    const std::vector<double> p{two_sample_p(after.filled, fresh.filled),
                                two_sample_p(after.active, fresh.active),
                                kolmogorov_smirnov_p(after.drop_x_m[0], fresh.drop_x_m[0]),
                                kolmogorov_smirnov_p(after.drop_x_m[1], fresh.drop_x_m[1])};
    fmt::print("{} steps: p {:.3g} {:.3g} {:.3g} {:.3g}, {:.2f} moved\n",
               conditional ? "conditional" : "independence", p[0], p[1], p[2], p[3],
               moved / static_cast<double>(draws));
    for (const double value : p)
      EXPECT_GT(value, 1e-5);
    EXPECT_GT(moved, draws / 2);
  }
}

}  // namespace sleight::statistical::spelling_islands_test
