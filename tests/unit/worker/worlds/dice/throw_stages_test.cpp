#include "worker/worlds/dice/throw_stages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/unit/worker/worlds/dice/support.h"
#include "worker/sampling/stage_search.h"

namespace sleight::worlds::dice {
namespace {

constexpr std::uint64_t k_seed = 20261124;

Goal place_of(std::uint32_t die, double x_m, double y_m) {
  return {.die = die, .wanted = Place{{x_m, y_m}}, .sigma = 0.01, .tolerance = 0.015};
}

/// Two dice start beside each other. The dice's goal is to end 60 mm apart.
Parameters two_dice() {
  Parameters parameters;
  parameters.world.dice.assign(2, DieStart{});
  parameters.world.dice[0].position_m.y() = -0.03;
  parameters.world.dice[1].position_m.y() = 0.03;
  parameters.goals = {place_of(0, 0.03, -0.03), place_of(1, 0.03, 0.03)};
  return parameters;
}

std::vector<LoneThrow> throws_that_land_ahead(const DieStart& start, int count) {
  // Each throw moves at constant speed for half a second, then lands. The goal's sigma is small.
  std::vector<LoneThrow> throws;
  random::Stream stream = testing::stream_of(k_seed, 1);
  for (int i = 0; i < count; ++i) {
    const DieThrow one = draw_throw(start, stream);
    throws.push_back({.thrown = one, .misses = {{0.5 * one.velocity_mps.x() - 0.4, 0.001}}});
  }
  return throws;
}

TEST(ThrowMap, FindsTheThrowsThatMissByNothing) {
  // Goal: the map favours throws with small misses, and weighs each throw by p / q. Method: let a
  // die move at constant speed for half a second, then land. Only one speed, a standard deviation
  // from the mean, reaches the goal. More than three quarters of the draws must have about this
  // speed, and the mean of p / q must be 1.
  const DieStart start;
  const ThrowMap map(start, throws_that_land_ahead(start, 200));
  ASSERT_FALSE(map.is_prior());
  random::Stream stream = testing::stream_of(k_seed, 2);
  constexpr int k_draws = 20'000;
  int near = 0;
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < k_draws; ++i) {
    const DieThrow one = map.draw(stream);
    near += std::abs(one.velocity_mps.x() - 0.8) < 0.02 ? 1 : 0;
    const double v = map.prior_over_q(one);
    EXPECT_GT(v, 0);
    EXPECT_LE(v, 1 / ThrowMap::k_prior_share);
    sum += v;
    squares += v * v;
  }
  EXPECT_GT(near / double{k_draws}, 0.75);
  const double mean = sum / k_draws;
  const double error = std::sqrt((squares / k_draws - mean * mean) / k_draws);
  EXPECT_NEAR(mean, 1, 4 * error);
  EXPECT_LT(error, 0.03) << "says little";
}

TEST(ThrowMap, IsThePriorWhereNothingIsLearnt) {
  // Goal: if the map can learn nothing, it draws the same throws as the prior, with weight 1. It
  // learns nothing if no goal has signed misses, if there are too few throws, or if only the
  // orientation is random.
  const DieStart start;
  DieStart fixed;
  fixed.position_sd_m = fixed.velocity_sd_mps = fixed.spin_sd_radps = {0, 0, 0};
  std::vector<LoneThrow> aimless = throws_that_land_ahead(start, 200);
  for (LoneThrow& one : aimless)
    one.misses.clear();
  for (const auto& [of, throws] :
       {std::pair{start, aimless}, std::pair{start, throws_that_land_ahead(start, 20)},
        std::pair{start, std::vector<LoneThrow>{}},
        std::pair{fixed, throws_that_land_ahead(fixed, 200)}}) {
    const ThrowMap map(of, throws);
    EXPECT_TRUE(map.is_prior());
    random::Stream by_map = testing::stream_of(k_seed, 3);
    random::Stream by_prior = testing::stream_of(k_seed, 3);
    for (int i = 0; i < 20; ++i) {
      const DieThrow one = map.draw(by_map);
      EXPECT_EQ(one, draw_throw(of, by_prior));
      EXPECT_EQ(map.prior_over_q(one), 1);
    }
  }
}

TEST(ThrowMap, OneInTenThousandThrowsIsNotPlausible) {
  // Goal: the map calls only few of the prior's throws implausible. If a throw's speed is far from
  // the prior's speeds, the map calls the throw implausible. Method: test 100,000 draws from the
  // prior. Also test a throw that is eight standard deviations too fast.
  const DieStart start;
  const ThrowMap map(start, {});
  random::Stream stream = testing::stream_of(k_seed, 4);
  int implausible = 0;
  for (int i = 0; i < 100'000; ++i)
    implausible += map.is_plausible(draw_throw(start, stream)) ? 0 : 1;
  EXPECT_LE(implausible, 25);
  DieThrow fast = draw_throw(start, stream);
  fast.velocity_mps.x() = start.velocity_mps.x();
  EXPECT_TRUE(map.is_plausible(fast));
  fast.velocity_mps.x() += 8 * start.velocity_sd_mps.x();
  EXPECT_FALSE(map.is_plausible(fast));
}

TEST(ThrowMap, SurvivesThrowsThatSayNothing) {
  // Goal: the map's draws and weights are finite even if all throws, or all misses, are equal.
  const DieStart start;
  random::Stream stream = testing::stream_of(k_seed, 4);
  const DieThrow one = draw_throw(start, stream);
  const std::vector<LoneThrow> alike(200, LoneThrow{.thrown = one, .misses = {{0.1, 1e-6}}});
  std::vector<LoneThrow> same_miss = throws_that_land_ahead(start, 200);
  for (LoneThrow& each : same_miss)
    each.misses = {{1e6, 1e-6}, {0, 1e-6}};
  for (const auto& throws : {alike, same_miss}) {
    const ThrowMap map(start, throws);
    for (int i = 0; i < 200; ++i) {
      const DieThrow drawn = map.draw(stream);
      EXPECT_TRUE(std::isfinite(drawn.velocity_mps.x()));
      const double v = map.prior_over_q(drawn);
      EXPECT_TRUE(v >= 0 && v <= 1 / ThrowMap::k_prior_share) << v;
    }
  }
}

TEST(SignedMisses, AreAsLongAsDistances) {
  // Goal: for places and velocities, the vector of signed misses is as long as the goal's distance.
  // A region's miss is measured from its middle. Goals for faces and times have no misses.
  const std::vector<Goal> goals{place_of(1, 0.1, -0.2),
                                {.die = 0, .wanted = Region{{0, 0}, {0.2, 0.4}}, .sigma = 0.01},
                                {.die = 0, .wanted = Velocity{{0.1, 0.2, 0.3}}, .sigma = 0.5},
                                {.die = 0, .wanted = FaceDirection{.face = 2}},
                                {.die = 0, .wanted = RestBefore{1}}};
  Views views;
  views.at_end.resize(2);
  views.rest_s = {0.5, 0.5};
  views.at_end[0].position_m = {0.3, 0.1, 0};
  views.at_end[1].position_m = {0.4, 0.2, 0};
  const auto misses = signed_misses(goals, views, {});
  ASSERT_EQ(misses.size(), 2U + 2U + 3U);
  EXPECT_NEAR(std::hypot(misses[0].by, misses[1].by), distance_of(goals[0], views, {}, 0), 1e-12);
  EXPECT_NEAR(misses[0].by, 0.3, 1e-12);
  EXPECT_NEAR(misses[2].by, 0.2, 1e-12);
  EXPECT_NEAR(misses[3].by, -0.1, 1e-12);
  EXPECT_NEAR(misses[2].sigma, 0.06, 1e-12);
  EXPECT_EQ(misses[5].by, -0.2);
  EXPECT_EQ(misses[5].sigma, 0.5);
}

TEST(ThrowMap, SpreadsWithinRoundingAreNone) {
  // Goal: a component doesn't affect a throw's weight if the component's standard deviation is
  // smaller than the rounding error of its mean. Method: compare with the weights for a start in
  // which the component is fixed.
  DieStart without;
  without.position_m.x() = -0.15;
  without.position_sd_m.x() = 0;
  DieStart lost = without;
  lost.position_sd_m.x() = 1e-20;
  const auto throws = throws_that_land_ahead(without, 200);
  const ThrowMap map(without, throws);
  const ThrowMap map_of_lost(lost, throws);
  ASSERT_FALSE(map.is_prior());
  for (const LoneThrow& one : throws)
    EXPECT_EQ(map.prior_over_q(one.thrown), map_of_lost.prior_over_q(one.thrown));
}

TEST(StagedDice, LaterDiceMayMakeRoom) {
  // Goal: if dice overlap in a prefix, the prefix is rejected exactly if all dice are thrown at the
  // same time. Method: put two of three dice in one place, and throw the third die at the same time
  // or later.
  for (const double start_s : {0.0, 0.2}) {
    Parameters parameters;
    parameters.world.dice.assign(3, DieStart{});
    parameters.world.dice[1].position_sd_m.setZero();
    parameters.world.dice[0] = parameters.world.dice[1];
    parameters.world.dice[2].position_m.y() = 0.2;
    parameters.world.dice[2].start_s = start_s;
    const StagedDice world(parameters);
    auto guide = world.learn(k_seed);
    guide.throws_of_pool = 2;
    random::Stream stream = testing::stream_of(k_seed, 7);
    const auto ground = world.draw_ground(guide, stream);
    auto prefix = world.no_stages(guide, ground);
    EXPECT_TRUE(std::isfinite(world.extend(guide, ground, 0, prefix, stream).log_weight));
    const double log_weight = world.extend(guide, ground, 1, prefix, stream).log_weight;
    ASSERT_EQ(prefix.outcome.end, End::impossible);
    EXPECT_EQ(std::isfinite(log_weight), start_s > 0);
  }
}

TEST(StagedDice, PrefixesAreWholeSimulations) {
  // Goal: a complete prefix equals a simulation of its state, bit for bit. The first die's prefix
  // equals a simulation of that die alone. Method: extend prefixes on random grounds, and on the
  // ground of a given state.
  const StagedDice world(two_dice());
  auto guide = world.learn(k_seed);
  guide.throws_of_pool = 3;
  random::Stream stream = testing::stream_of(k_seed, 5);
  for (int nth = 0; nth < 5; ++nth) {
    const auto ground = world.draw_ground(guide, stream);
    auto prefix = world.no_stages(guide, ground);
    world.extend(guide, ground, 0, prefix, stream);
    EXPECT_EQ(prefix.outcome.judgement.distances,
              world.first(1).simulate(prefix.state).judgement.distances);
    EXPECT_EQ(prefix.outcome.judgement.distances.size(), 1U);
    EXPECT_GE(world.log_potential(guide, ground, prefix), guide.log_floor);
    world.extend(guide, ground, 1, prefix, stream);
    const State state = world.state_of(ground, prefix);
    const Outcome fresh = world.simulate(state);
    EXPECT_EQ(prefix.outcome.judgement.distances, fresh.judgement.distances);
    EXPECT_EQ(prefix.outcome.end_s, fresh.end_s);
    EXPECT_EQ(world.simulations_of(ground).size(), 6U);

    // Rebuild the same state from its own throws.
    const auto given = world.ground_given(guide, state, stream);
    auto again = world.no_stages(guide, given);
    for (std::uint32_t stage = 0; stage < 2; ++stage) {
      EXPECT_EQ(given.pools[stage].throws[0].thrown, state.dice[stage]);
      world.extend_as(guide, given, state, stage, again);
    }
    EXPECT_EQ(world.state_of(given, again), state);
    EXPECT_EQ(again.outcome.judgement.distances, fresh.judgement.distances);
  }
}

TEST(StagedDice, GivenTablesKeepTheirOverrides) {
  // Goal: a state's ground contains the control points that the state overrides. Method: change one
  // control point of a state, and rebuild the state on its ground. The rebuilt state must contain
  // the change and have the outcome of a fresh simulation.
  const StagedDice world(two_dice());
  auto guide = world.learn(k_seed);
  guide.throws_of_pool = 2;
  random::Stream stream = testing::stream_of(k_seed, 6);
  State state = world.draw_prior(stream);
  GridIndex index{};
  index.i = 20;
  index.j = 30;
  SurfaceControl control = control_at(world.parameters().world, state, index);
  control.height_m += 0.002;
  state.overrides.push_back({index, control});
  const auto ground = world.ground_given(guide, state, stream);
  auto prefix = world.no_stages(guide, ground);
  for (std::uint32_t stage = 0; stage < 2; ++stage)
    world.extend_as(guide, ground, state, stage, prefix);
  EXPECT_EQ(world.state_of(ground, prefix), state);
  EXPECT_EQ(prefix.outcome.judgement.distances, world.simulate(state).judgement.distances);
}

TEST(StagedDice, WeightsOfAPoolAreItsSum) {
  // Goal: throw j of a pool of n throws has weight S / (n g_j). Here g is a throw's guessed
  // density, and S is the sum of (p / q) g over the pool.
  const StagedDice world(two_dice());
  auto guide = world.learn(k_seed);
  guide.throws_of_pool = 4;
  random::Stream stream = testing::stream_of(k_seed, 7);
  const auto ground = world.draw_ground(guide, stream);
  double sum = 0;
  for (const PoolThrow& one : ground.pools[0].throws) {
    EXPECT_EQ(one.v, guide.maps[0].prior_over_q(one.thrown));
    const State alone{ground.table_key, {}, {one.thrown}};
    EXPECT_EQ(
        one.log_guess,
        std::max(guide.log_floor, world.alone(0).log_constraint(world.alone(0).simulate(alone))));
    sum += one.v * std::exp(one.log_guess);
  }
  for (int nth = 0; nth < 10; ++nth) {
    auto prefix = world.no_stages(guide, ground);
    const double log_weight = world.extend(guide, ground, 0, prefix, stream).log_weight;
    for (const PoolThrow& one : ground.pools[0].throws) {
      if (one.thrown == prefix.state.dice[0]) {
        EXPECT_NEAR(log_weight, std::log(sum / 4) - one.log_guess, 1e-12);
      }
    }
  }
}

TEST(ThrowBuilder, FindsThrowsThatEndAsWanted) {
  // Goal: a find satisfies the goals in a fresh simulation and has a finite prior density. The same
  // random numbers give the same find. Method: search for throws of two dice. Search twice for each
  // of three starts.
  const StagedDice world(two_dice());
  const auto guide = world.learn(k_seed);
  const ThrowBuilder builder = world.builder(guide);
  int found = 0;
  for (std::uint64_t start = 0; start < 3; ++start) {
    random::Stream stream = testing::stream_of(k_seed, 100 + start);
    random::Stream same = testing::stream_of(k_seed, 100 + start);
    sampling::SearchEffort effort;
    sampling::SearchEffort again;
    const auto throw_found = sampling::search(builder, builder.limits(), stream, effort);
    const auto found_again = sampling::search(builder, builder.limits(), same, again);
    ASSERT_EQ(throw_found.has_value(), found_again.has_value());
    EXPECT_EQ(effort.guesses, again.guesses);
    EXPECT_GT(effort.guesses, 0U);
    if (!throw_found) continue;
    ++found;
    EXPECT_EQ(throw_found->state, found_again->state);
    EXPECT_TRUE(world.satisfied(world.simulate(throw_found->state)));
    EXPECT_TRUE(std::isfinite(world.log_prior(throw_found->state)));
  }
  EXPECT_GT(found, 0);
}

}  // namespace
}  // namespace sleight::worlds::dice
