// Tests that a candidate's simulation from a known similar state has the same outcome as a
// simulation from scratch.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/property.h"
#include "tests/unit/worker/worlds/spelling/full_pattern.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {
namespace {

constexpr std::uint64_t k_seed = 20261122;

std::uint64_t proposal_count() {
  return property::long_run() ? 100'000 : property::of_tier(500, 1'500);
}

void expect_same(const Outcome& a, const Outcome& b) {
  EXPECT_EQ(a.filled, b.filled);
  EXPECT_EQ(a.elsewhere, b.elsewhere);
  EXPECT_EQ(a.end, b.end);
  EXPECT_EQ(a.end_s, b.end_s);
  EXPECT_EQ(a.filling, b.filling);
}

/// Runs a chain. The chain accepts a candidate if it fills at least as many bins as the current
/// state. The chain accepts some other candidates by chance. Expects that each candidate's
/// simulation from the current state equals a simulation from scratch.
void run_chain(const Parameters& parameters, std::uint64_t proposals, std::uint64_t seed) {
  const Spelling world(parameters);
  const Spelling fresh(parameters, Replays::no);
  random::Stream stream({.seed = seed, .purpose = random::Purpose::proposal}, 0);
  State state = world.draw_prior(stream);
  Outcome outcome = world.simulate(state);
  expect_same(outcome, fresh.simulate(state));
  std::uint64_t with_history = 0;
  for (const std::uint64_t i : property::in_turn(proposals)) {
    SCOPED_TRACE(fmt::format("seed {}, proposal {}", seed, i));
    const auto proposal = world.propose(state, outcome, {}, stream);
    if (outcome.history) ++with_history;
    const Outcome candidate = world.simulate_from(proposal.candidate, state, outcome);
    expect_same(candidate, fresh.simulate(proposal.candidate));
    EXPECT_EQ(fresh.simulate_from(proposal.candidate, state, outcome).history, nullptr);
    if (::testing::Test::HasFailure()) return;
    if (candidate.filled >= outcome.filled || stream.uniform() < 0.1) {
      state = proposal.candidate;
      outcome = candidate;
    }
  }
  if (property::all_cases()) {
    EXPECT_GT(with_history, proposals / 2);
  }
}

TEST(Replays, MakeNoDifference) {
  // Goal: a candidate's simulation from the current state equals a simulation from scratch, for
  // successive proposals of every kind. Both simulations have the same filled bins, balls
  // elsewhere, end and decision time. Method: run chains in HI's box, in small crowded boxes, and
  // in boxes whose vertices move far.
  const std::uint64_t count = proposal_count();
  run_chain({}, count, k_seed);
  Parameters crowded;
  crowded.pattern = full_pattern(2, 2);
  crowded.proposal.vertex_probability = 0.1;
  run_chain(crowded, count / 2, k_seed + 1);
  crowded.pattern = full_pattern(3, 3);
  crowded.world.drop_interval_s = 0.05;
  run_chain(crowded, count / 4, k_seed + 2);
  Parameters aimed;
  aimed.proposal.change_vertices = 0.1;
  aimed.proposal.aim_ball = 0.22;
  aimed.proposal.vertex_sd_m = 0.0005;
  run_chain(aimed, count / 2, k_seed + 3);
}

}  // namespace
}  // namespace sleight::worlds::spelling
