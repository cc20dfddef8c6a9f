#include "worker/worlds/spelling/spelling.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>

#include "tests/support/property.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::worlds::spelling {
namespace {

State drops_in(const Spelling& world, std::uint32_t balls) {
  State state;
  state.offsets_m.assign(world.bins().vertex_count(), Vec3::Zero());
  state.active.assign(world.balls(), 0);
  state.drops_m.assign(world.balls(), Vec2(0, 0));
  std::uint32_t ball = 0;
  const Pattern& pattern = world.parameters().pattern;
  for (std::uint32_t row = 0; row < pattern.rows; ++row) {
    for (std::uint32_t column = 0; column < pattern.columns && ball < balls; ++column) {
      if (!pattern.at(column, row)) continue;
      const Vec3 middle_m = world.bins().floor_middle_m({column, pattern.rows - 1 - row});
      state.active[ball] = 1;
      state.drops_m[ball++] = {middle_m.x() + 1e-4, middle_m.y() - 2e-4};
    }
  }
  return state;
}

TEST(Spelling, OutcomesCountDesignatedBins) {
  // Goal: `filled` counts the designated bins that contain a ball at rest below the partitions'
  // height. All other balls count as elsewhere. Method: judge given places of balls.
  const Spelling world(Parameters{});
  const Bins& bins = world.bins();
  const Vec3 up(0, 0, 0.009);
  const Vec3 designated = bins.floor_middle_m({1, 3});  // the H's upper left
  const Vec3 other = bins.floor_middle_m({0, 0});
  const auto expect = [&](const std::vector<Vec3>& resting_m, std::uint32_t others,
                          std::uint32_t filled, std::uint32_t elsewhere) {
    std::vector<Spelling::Staying> staying;
    for (const Vec3& centre_m : resting_m)
      staying.push_back({static_cast<std::uint32_t>(staying.size()), centre_m});
    const Outcome outcome = world.judged(staying, others);
    EXPECT_EQ(outcome.filled, filled);
    EXPECT_EQ(outcome.elsewhere, elsewhere);
  };
  expect({designated + up}, 0, 1, 0);
  expect({designated + up, designated + up}, 0, 1, 1);
  expect({other + up}, 0, 0, 1);
  expect({designated + 2 * up}, 0, 0, 1);
  expect({Vec3(1, 0, -5)}, 0, 0, 1);
  expect({designated + up}, 2, 1, 2);
  const Outcome all{.filled = 10};
  EXPECT_TRUE(world.satisfied(all));
  EXPECT_EQ(world.log_constraint(all), 50);
  EXPECT_FALSE(world.satisfied({.filled = 10, .elsewhere = 1}));
  for (const End end : {End::impossible, End::failed}) {
    EXPECT_FALSE(world.satisfied({.filled = 10, .end = end}));
    EXPECT_EQ(world.log_constraint({.filled = 10, .end = end}),
              -std::numeric_limits<double>::infinity());
  }
}

TEST(Spelling, WhatStillMovesFillsNothing) {
  // Goal: a ball fills no bin before it is at rest. Method: drop a lossless ball where other balls
  // would stay. The ball still bounces at the time limit.
  Parameters parameters;
  parameters.world.restitution = 1;
  parameters.world.time_limit_s = 0.5;
  const Spelling world(parameters);
  const Outcome outcome = world.simulate(drops_in(world, 1));
  EXPECT_EQ(outcome.end, End::time_limit);
  EXPECT_EQ(outcome.filled, 0U);
  EXPECT_EQ(outcome.elsewhere, 1U);
}

TEST(Spelling, BallsThatLeaveTheBoxLieOnTheGround) {
  // Goal: a ball outside the box lies on the ground instead of falling forever, and counts as
  // elsewhere. Method: use walls lower than the balls, and balls that bounce well.
  Parameters parameters;
  parameters.world.box_height_m = 0.012;
  parameters.world.restitution = 0.9;
  const Spelling world(parameters);
  std::uint32_t outside = 0;
  for (const std::uint64_t i : property::cases(5)) {
    random::Stream stream({.seed = 6, .purpose = random::Purpose::prior}, i);
    const State state = world.draw_prior(stream);
    const auto scene = world.scene(state);
    ASSERT_TRUE(scene);
    physics::Simulation simulation = physics::Simulation::start(*scene, {}).value();
    ASSERT_FALSE(simulation.run_until(physics::Tick{} + physics::ticks_after(6)));
    for (std::uint32_t body = 0; body < scene->bodies.size(); ++body) {
      const Vec3 place_m = simulation.pose({body}, simulation.now()).position_m;
      if (world.bins().bin_at(place_m)) continue;
      ++outside;
      EXPECT_GT(place_m.z(), -0.02);
    }
    const Outcome outcome = world.simulate(state);
    EXPECT_TRUE(outcome.is_animation());
    EXPECT_EQ(outcome.filled + outcome.elsewhere, scene->bodies.size());
  }
  if (!property::all_cases()) return;
  EXPECT_GT(outside, 0U);
}

TEST(Spelling, BallsThatStartInOnePlaceAreNoAnimation) {
  // Goal: the outcome of a state that cannot be simulated is `impossible`. Method: drop a second
  // ball where the first ball still is. Then let offsets turn the box inside out.
  Parameters parameters;
  parameters.world.drop_interval_s = 0.001;
  const Spelling world(parameters);
  State state = drops_in(world, 2);
  state.drops_m[1] = state.drops_m[0];
  EXPECT_EQ(world.simulate(state).end, End::impossible);
  bool refused = false;
  for (std::uint32_t v = 0; v + 1 < world.bins().vertex_count(); ++v) {
    State inside_out = drops_in(world, 1);
    inside_out.offsets_m[v] = world.bins().vertices_m()[v + 1] - world.bins().vertices_m()[v];
    refused = refused || world.simulate(inside_out).end == End::impossible;
    if (refused) break;
  }
  EXPECT_TRUE(refused);
}

TEST(Spelling, BallsComeToRestInBins) {
  // Goal: balls that are dropped from 72 mm come to rest. Almost all balls rest on the floor of a
  // bin. No ball is lost. Method: check each ball's height at rest in prior draws.
  const Spelling world(Parameters{});
  std::uint32_t balls = 0;
  std::uint32_t low = 0;
  std::uint32_t at_rest = 0;
  constexpr int k_animations = 40;
  for (const std::uint64_t i : property::cases(k_animations)) {
    random::Stream stream({.seed = 5, .purpose = random::Purpose::prior}, i);
    State state = world.draw_prior(stream);
    const auto scene = world.scene(state);
    ASSERT_TRUE(scene);
    physics::Simulation simulation = physics::Simulation::start(*scene, {}).value();
    ASSERT_FALSE(simulation.run_until(physics::Tick{} + physics::ticks_after(12)));
    at_rest += simulation.kinetic_energy_j() == 0 ? 1 : 0;
    for (std::uint32_t body = 0; body < scene->bodies.size(); ++body) {
      const Vec3 place_m = simulation.pose({body}, simulation.now()).position_m;
      const auto bin = world.bins().bin_at(place_m);
      ++balls;
      // Inside the box, the surface holds the balls.
      if (bin) {
        EXPECT_GT(place_m.z(), 0.008);
      }
      if (bin && place_m.z() < 0.0095) ++low;
    }
    const Outcome outcome = world.simulate(state);
    EXPECT_TRUE(outcome.is_animation());
    EXPECT_EQ(outcome.filled + outcome.elsewhere, scene->bodies.size());
  }
  if (!property::all_cases()) return;
  std::printf("%u of %u balls on a floor, %u of %d animations at rest\n", low, balls, at_rest,
              k_animations);
  EXPECT_GT(low, 0.9 * balls);
  EXPECT_GE(at_rest, 0.9 * k_animations);
}

}  // namespace
}  // namespace sleight::worlds::spelling
