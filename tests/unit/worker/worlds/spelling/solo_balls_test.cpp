#include "worker/worlds/spelling/solo_balls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "common/random/stream.h"
#include "tests/support/property.h"
#include "worker/sampling/surrogate_transition.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {
namespace {

Parameters parameters_with_aims() {
  Parameters parameters;
  parameters.proposal.change_all = 0.05;
  parameters.proposal.change_vertices = 0.05;
  parameters.proposal.change_ball = 0.1;
  parameters.proposal.disable_balls = parameters.proposal.enable_balls = 0.1;
  parameters.proposal.aim_ball = parameters.proposal.scatter_ball = 0.3;
  parameters.proposal.solo_steps = 4;
  return parameters;
}

random::Stream stream_of(std::uint64_t number) {
  return random::Stream({.seed = 6174, .purpose = random::Purpose::scene}, number);
}

void expect_equal(const SoloBalls::Outcome& a, const SoloBalls::Outcome& b) {
  EXPECT_EQ(a.possible, b.possible);
  EXPECT_EQ(a.alone, b.alone);
  EXPECT_EQ(a.filling, b.filling);
  EXPECT_EQ(a.filled, b.filled);
}

TEST(SoloBalls, AreWhatEachBallDoesAlone) {
  // Goal: the surrogate assigns a bin to each ball: the bin that the ball fills if no other ball is
  // active. Method: simulate each ball as the only active ball.
  const Spelling world(parameters_with_aims());
  for (const std::uint64_t i : property::cases(30)) {
    random::Stream stream = stream_of(i);
    const State state = world.draw_prior(stream);
    const SoloBalls::Outcome outcome = world.surrogate({}).simulate(state);
    ASSERT_TRUE(outcome.possible);
    for (std::size_t ball = 0; ball < state.active.size(); ++ball) {
      State alone = state;
      std::ranges::fill(alone.active, 0);
      std::ranges::fill(alone.drops_m, Vec2(0, 0));
      alone.active[ball] = state.active[ball];
      alone.drops_m[ball] = state.drops_m[ball];
      EXPECT_EQ(outcome.alone[ball], world.simulate(alone).filling[ball]);
    }
  }
}

TEST(SoloBalls, FromChangesAreTheSame) {
  // Goal: the surrogate computes the same outcome if it simulates only the changed balls. Method:
  // walk with proposals of all kinds. Where possible, balls are anchored. Compare each outcome with
  // a simulation of all balls.
  const Spelling world(parameters_with_aims());
  std::uint64_t changed = 0;
  for (const std::uint64_t i : property::cases(20)) {
    random::Stream stream = stream_of(i);
    State state = world.draw_prior(stream);
    const Outcome known = world.simulate(state);
    SoloBalls::Outcome outcome = world.surrogate({}).simulate(state);
    const SoloBalls surrogate =
        world.surrogate(world.draw_anchor(state, known, outcome, 1, stream));
    outcome = surrogate.simulate_from(state, state, outcome);
    expect_equal(outcome, surrogate.simulate(state));
    for (int step = 0; step < 40; ++step) {
      const auto proposal = surrogate.propose(state, outcome, {}, stream);
      const auto next = surrogate.simulate_from(proposal.candidate, state, outcome);
      if (!next.possible) continue;
      expect_equal(next, surrogate.simulate(proposal.candidate));
      state = proposal.candidate;
      outcome = next;
      ++changed;
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(changed, 100U);
}

TEST(SoloBalls, TakeAnchoredBallsForGranted) {
  // Goal: an anchored ball fills its bin, even if it would not fill the bin alone. So no other ball
  // fills that bin. If a state changes an anchored ball, the state is impossible. Method: anchor
  // balls of prior draws. Then move and disable each anchored ball.
  const Spelling world(parameters_with_aims());
  std::uint64_t anchored = 0;
  for (const std::uint64_t i : property::cases(200)) {
    random::Stream stream = stream_of(i);
    const State state = world.draw_prior(stream);
    const Outcome known = world.simulate(state);
    const SoloBalls::Outcome alone = world.surrogate({}).simulate(state);
    const Anchor anchor = world.draw_anchor(state, known, alone, 1, stream);
    const SoloBalls surrogate = world.surrogate(anchor);
    const SoloBalls::Outcome outcome = surrogate.simulate_from(state, state, alone);
    EXPECT_EQ(outcome.alone, alone.alone);
    for (std::size_t ball = 0; ball < anchor.bins.size(); ++ball) {
      if (anchor.bins[ball] == k_fills_none) continue;
      ++anchored;
      EXPECT_EQ(anchor.bins[ball], known.filling[ball]);
      EXPECT_NE(anchor.bins[ball], alone.alone[ball]);
      EXPECT_EQ(outcome.filling[ball], anchor.bins[ball]);
      EXPECT_EQ(std::ranges::count(outcome.filling, anchor.bins[ball]), 1);
      State other = state;
      other.drops_m[ball].x() += 1e-6;
      EXPECT_FALSE(surrogate.simulate(other).possible);
      EXPECT_FALSE(surrogate.simulate_from(other, state, outcome).possible);
      other.active[ball] = 0;
      other.drops_m[ball] = {0, 0};
      EXPECT_FALSE(surrogate.simulate(other).possible);
      // Simulate `state` from an outcome of `other` that a surrogate without anchors computed.
      expect_equal(surrogate.simulate_from(state, other, world.surrogate({}).simulate(other)),
                   outcome);
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(anchored, 20U);
}

TEST(SoloBalls, AnchorsHaveTheirProbabilities) {
  // Goal: log_anchor_probability() returns the log probability with which draw_anchor() draws an
  // anchor. The anchor of another state has probability zero. Method: use five animations with
  // helped balls. Draw 20,000 anchors, and compare each anchor's share with its probability. Allow
  // six standard deviations.
  const Spelling world(parameters_with_aims());
  int animations = 0;
  for (std::uint64_t i = 0; animations < 5 && i < 1000; ++i) {
    random::Stream stream = stream_of(i);
    const State state = world.draw_prior(stream);
    const Outcome known = world.simulate(state);
    const SoloBalls::Outcome alone = world.surrogate({}).simulate(state);
    const Anchor all = world.draw_anchor(state, known, alone, 1, stream);
    if (std::ranges::all_of(all.bins, [](std::int16_t bin) { return bin == k_fills_none; }))
      continue;
    ++animations;
    EXPECT_EQ(world.log_anchor_probability(all, known, alone, 1), 0);
    const Anchor none{.bins = Filling(all.bins.size(), k_fills_none), .drops_m = all.drops_m};
    EXPECT_EQ(world.log_anchor_probability(none, known, alone, 1),
              -std::numeric_limits<double>::infinity());
    EXPECT_EQ(world.log_anchor_probability(all, {.end = End::impossible}, alone, 0.3),
              -std::numeric_limits<double>::infinity());
    EXPECT_EQ(world.log_anchor_probability({}, known, alone, 0), 0);
    std::map<Filling, double> counts;
    constexpr double k_draws = 20'000;
    for (int draw = 0; draw < static_cast<int>(k_draws); ++draw)
      ++counts[world.draw_anchor(state, known, alone, 0.3, stream).bins];
    double sum = 0;
    for (const auto& [bins, count] : counts) {
      const Anchor anchor{.bins = bins, .drops_m = state.drops_m};
      const double p = std::exp(world.log_anchor_probability(anchor, known, alone, 0.3));
      EXPECT_NEAR(count, k_draws * p, 6 * std::sqrt(k_draws * p));
      sum += p;
    }
    EXPECT_NEAR(sum, 1, 1e-2);
    Anchor wrong = all;
    const auto ball = std::ranges::find(wrong.bins, k_fills_none);
    if (ball == wrong.bins.end()) continue;
    *ball = 0;
    EXPECT_EQ(world.log_anchor_probability(wrong, known, alone, 0.3),
              -std::numeric_limits<double>::infinity());
  }
}

TEST(SoloBalls, HeldOutcomesAreThoseOfTheState) {
  // Goal: the surrogate's outcome that a sample holds always belongs to the sample's state. Method:
  // after each iteration at two inverse temperatures, compare the held outcome with a new
  // simulation.
  const Spelling world(parameters_with_aims());
  const sampling::ChainStreams streams{.seed = 28, .chain = {}, .replica = {}};
  for (const double beta : {0.3, 1.0}) {
    auto sample = sampling::draw_afresh(world, streams, 0);
    std::uint64_t held = 0;
    for (std::uint64_t i = 1; i <= 200; ++i) {
      sampling::iterate(world, beta, streams, i, sample, {}, [](const sampling::StepReport&) {});
      EXPECT_EQ(sample.outcome.filling, world.simulate(sample.state).filling);
      if (!sample.surrogate) continue;
      ++held;
      EXPECT_EQ(sample.surrogate->alone, world.surrogate({}).simulate(sample.state).alone);
    }
    EXPECT_EQ(held, 200U);
  }
}

}  // namespace
}  // namespace sleight::worlds::spelling
