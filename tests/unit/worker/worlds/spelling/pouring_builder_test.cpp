#include "worker/worlds/spelling/pouring_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "worker/worlds/spelling/landing_map.h"

namespace sleight::worlds::spelling::pouring_builder_test {

constexpr std::uint64_t k_seed = 31;

Spelling world_of(Pattern pattern) {
  Parameters parameters;
  parameters.pattern = std::move(pattern);
  return Spelling(parameters);
}
random::Stream stream_of(std::uint64_t number) {
  return random::Stream({.seed = k_seed, .purpose = random::Purpose::search}, number);
}

TEST(Landings, AreCountedWithTheirMirrorImages) {
  // Goal: each landing within reach counts eight times, in the cells of its mirror images. A
  // landing out of reach doesn't count.
  Landings landings(0.022);
  landings.add(Vec2(0.0033, -0.0011 * 0.5));
  EXPECT_EQ(landings.total(), 8U);
  landings.add(Vec2(0.2, 0));
  EXPECT_EQ(landings.total(), 8U);
  const LandingMap map(landings);
  const double each = 1 / 8.0 / (0.0022 * 0.0022);
  EXPECT_NEAR(map.density(Vec2(0.0033, -0.0005)), each, 1e-9 * each);
  EXPECT_NEAR(map.density(Vec2(-0.0005, 0.0033)), each, 1e-9 * each);
  EXPECT_EQ(map.density(Vec2(0.0033, 0.0055)), 0);
  EXPECT_EQ(map.density(Vec2(0.2, 0)), 0);
}

TEST(Landings, OfBatchesAddUpInAnyOrder) {
  // Goal: batches of landings add up to the same map in any order, so any number of workers can
  // compute the map. Method: add four batches in another order.
  const Spelling world = world_of(hi());
  const Landings all = landings_of(world, k_seed, 4);
  Landings backwards(all.pitch_m());
  for (const std::uint64_t batch : {3U, 1U, 2U, 0U})
    backwards.add(landings_of_batch(world, k_seed, batch));
  EXPECT_EQ(all.total(), backwards.total());
  for (std::size_t cell = 0; cell < std::size_t{Landings::k_side} * Landings::k_side; ++cell)
    ASSERT_EQ(all.count(cell), backwards.count(cell));
  // About 30% of 400 balls fill a designated bin.
  EXPECT_GT(all.total(), 8 * 60U);
  EXPECT_LT(all.total(), 8 * 200U);
}

TEST(LandingMap, IsADensityAndDrawsByIt) {
  // Goal: the map's density integrates to 1, and its draws follow the density. Method: add up the
  // density over all cells. Make 20,000 draws and count them in rings around the middle. Each
  // ring's share must agree with the density, within 5 standard errors.
  const Spelling world = world_of(hi());
  const Landings landings = landings_of(world, k_seed, 20);
  const LandingMap map(landings);
  const double cell_m = landings.pitch_m() / Landings::k_cells;
  constexpr std::size_t k_rings = 5;
  const auto ring_of = [&](const Vec2& d) {
    return static_cast<std::size_t>(std::max(std::abs(d.x()), std::abs(d.y())) /
                                    landings.pitch_m());
  };
  double sum = 0;
  std::array<double, k_rings> expected{};
  for (std::uint32_t row = 0; row < Landings::k_side; ++row) {
    for (std::uint32_t column = 0; column < Landings::k_side; ++column) {
      const Vec2 middle((column + 0.5 - Landings::k_side / 2) * cell_m,
                        (row + 0.5 - Landings::k_side / 2) * cell_m);
      const double share = map.density(middle) * cell_m * cell_m;
      sum += share;
      expected[ring_of(middle)] += share;
    }
  }
  EXPECT_NEAR(sum, 1, 1e-9);
  std::array<double, k_rings> seen{};
  constexpr int k_draws = 20'000;
  random::Stream stream = stream_of(0);
  for (int draw = 0; draw < k_draws; ++draw) {
    const Vec2 d = map.draw(stream);
    ASSERT_GT(map.density(d), 0);
    seen[ring_of(d)] += 1.0 / k_draws;
  }
  for (std::size_t ring = 0; ring < k_rings; ++ring) {
    const double error = std::sqrt(expected[ring] * (1 - expected[ring]) / k_draws);
    EXPECT_NEAR(seen[ring], expected[ring], 5 * error + 1e-9) << "ring " << ring;
  }
  // Most of the balls that fill a bin are dropped above this bin or a neighbouring bin.
  EXPECT_GT(expected[0] + expected[1], 0.7);
}

TEST(PouringBuilder, FindsPouringsThatSpell) {
  // Goal: in an independent simulation, all balls of a find spell the word. Different streams give
  // different pourings, and equal streams give equal pourings. Method: build 40 pourings of HI and
  // 5 of ACM.
  for (const auto& [pattern, count] :
       {std::pair{hi(), 40}, {pattern_of_word("ACM", Font::rows_5).value(), 5}}) {
    const Spelling world = world_of(pattern);
    const Spelling fresh = world_of(pattern);
    const LandingMap map(landings_of(world, k_seed, 20));
    const PouringBuilder builder(world, map);
    sampling::SearchEffort effort;
    std::set<double> first_drops_m;
    for (int number = 0; number < count; ++number) {
      random::Stream stream = stream_of(static_cast<std::uint64_t>(number));
      const auto found = sampling::search(builder, {}, stream, effort);
      ASSERT_TRUE(found.has_value()) << number;
      EXPECT_EQ(found->state.active_count(), world.balls());
      EXPECT_TRUE(std::isfinite(world.log_prior(found->state)));
      const Outcome outcome = fresh.simulate(found->state);
      EXPECT_TRUE(fresh.satisfied(outcome)) << number;
      EXPECT_EQ(outcome.filling, found->outcome.filling);
      first_drops_m.insert(found->state.drops_m[0].x());
      if (number > 0) continue;
      random::Stream again = stream_of(0);
      sampling::SearchEffort other;
      EXPECT_EQ(sampling::search(builder, {}, again, other)->state, found->state);
    }
    EXPECT_EQ(first_drops_m.size(), static_cast<std::size_t>(count));
    EXPECT_TRUE(effort.failures.empty());
    // The search needs hardly more than one simulation per ball.
    EXPECT_LT(effort.simulations, 1.5 * count * world.balls());
  }
}

TEST(PouringBuilder, PrefixesAreWhatTheyCameTo) {
  // Goal: a prefix's outcome is computed from the previous prefix, and equals the outcome of a
  // simulation from scratch. Method: compare the two outcomes for each prefix of five pourings.
  const Spelling world = world_of(hi());
  const Spelling fresh = world_of(hi());
  const LandingMap map(landings_of(world, k_seed, 20));
  const PouringBuilder builder(world, map);
  sampling::SearchEffort effort;
  for (std::uint64_t number = 100; number < 105; ++number) {
    random::Stream stream = stream_of(number);
    PouringBuilder::Prefix prefix = builder.start(stream);
    std::uint32_t stage = 0;
    for (int tries = 0; tries < 500 && stage < builder.stages(); ++tries) {
      auto longer = builder.attempt(prefix, stage, effort, stream);
      if (!longer) continue;
      prefix = *std::move(longer);
      ++stage;
      const Outcome outcome = fresh.simulate(prefix.state);
      ASSERT_EQ(outcome.filled, stage);
      ASSERT_EQ(outcome.elsewhere, 0U);
      ASSERT_EQ(outcome.filling, prefix.outcome.filling);
    }
    EXPECT_EQ(stage, builder.stages());
  }
}

}  // namespace sleight::worlds::spelling::pouring_builder_test
