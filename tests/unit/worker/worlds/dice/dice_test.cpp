#include "worker/worlds/dice/dice.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "tests/support/property.h"
#include "tests/unit/worker/worlds/dice/support.h"

namespace sleight::worlds::dice::dice_test {

constexpr std::uint64_t k_seed = 20261122;

State state_of(const Dice& world, std::uint64_t number) {
  random::Stream stream = testing::stream_of(k_seed, number);
  return world.draw_prior(stream);
}

Goal goal_of(std::variant<Place, Region, FaceDirection, Turn, Velocity, RestBefore> wanted,
             double sigma, double tolerance) {
  return {.wanted = wanted, .sigma = sigma, .tolerance = tolerance};
}

TEST(Dice, ComeToRestOnTheTable) {
  // Goal: a thrown die comes to rest with a face up. The die's centre is then about half a side
  // above the table. Method: simulate prior draws with a goal for one face. Dice are numbered after
  // the throw, so the distance to this goal is the die's tilt.
  Parameters parameters;
  parameters.goals = {goal_of(FaceDirection{.face = 6}, 0.2, 0.3)};
  const Dice world(parameters);
  for (std::uint64_t number = 0; number < 50; ++number) {
    const Outcome outcome = world.simulate(state_of(world, number));
    ASSERT_EQ(outcome.end, End::settled) << number;
    EXPECT_GT(outcome.end_s, 0.1);
    EXPECT_LT(outcome.end_s, 6);
    EXPECT_GT(outcome.collisions, 1U);
    EXPECT_NEAR(outcome.at_end[0].position_m.z(), 0.008, 0.004);
    EXPECT_LT(outcome.judgement.distances[0], 0.3);
    EXPECT_TRUE(world.satisfied(outcome));
    EXPECT_EQ(world.log_constraint(outcome), outcome.judgement.log_constraint);
  }
}

TEST(Dice, ContactsShareTheirWeights) {
  // Goal: the outcome lists control points in ascending order. Each point's share is positive and
  // at most 4/9, and the shares add up to 1. The log plausibility is the sum of the points' log
  // densities.
  const Dice world(testing::all_random(2));
  for (std::uint64_t number = 0; number < 10; ++number) {
    const State state = state_of(world, number);
    const Outcome outcome = world.simulate(state);
    ASSERT_FALSE(outcome.contacts.empty());
    double sum = 0;
    double log_density = 0;
    for (std::size_t i = 0; i < outcome.contacts.size(); ++i) {
      const ContactShare& one = outcome.contacts[i];
      EXPECT_GT(one.share, 0);
      EXPECT_LE(one.share, k_share_max);
      EXPECT_TRUE(i == 0 || outcome.contacts[i - 1].index < one.index);
      sum += one.share;
      log_density += log_density_of(world.parameters().world.table,
                                    control_at(world.parameters().world, state, one.index));
    }
    EXPECT_NEAR(sum, 1, 1e-9);
    EXPECT_EQ(outcome.log_plausibility, log_density);
  }
}

TEST(Dice, HeightsThatTheyMetAreCounted) {
  // Goal: if a control point affects collisions, `offsets` counts it once, by its height.
  // `offset_squares` sums the squares of these heights. If the table's height is constant, both are
  // 0. Method: move one control point of a prior draw far up or down, and compare with a direct
  // count. Then use a flat table.
  Parameters parameters;
  const Dice world(parameters);
  const double sd_m = parameters.world.table.height_sd_m;
  std::uint64_t outermost = 0;
  for (std::uint64_t number = 0; number < 20; ++number) {
    State state = state_of(world, number);
    const GridIndex met = world.simulate(state).contacts.back().index;
    SurfaceControl control = control_at(parameters.world, state, met);
    control.height_m = (number % 2 == 0 ? 3.2 : -3.2) * sd_m;
    set_override(state.overrides, {met, control});
    const Outcome outcome = world.simulate(state);
    std::array<std::uint32_t, k_offset_bins> counts{};
    double squares = 0;
    for (const ContactShare& one : outcome.contacts) {
      const double sds = control_at(parameters.world, state, one.index).height_m / sd_m;
      std::size_t bin = 0;
      while (bin + 1 < k_offset_bins &&
             sds >= k_offset_first_sd + static_cast<double>(bin) * k_offset_step_sd)
        ++bin;
      ++counts.at(bin);
      squares += sds * sds;
    }
    EXPECT_EQ(outcome.offsets, counts);
    EXPECT_DOUBLE_EQ(outcome.offset_squares, squares);
    outermost += counts.front() + counts.back();
  }
  EXPECT_GT(outermost, 5U);

  parameters.world.table.height_sd_m = 0;
  const Dice flat(parameters);
  const Outcome outcome = flat.simulate(state_of(flat, 1));
  EXPECT_FALSE(outcome.contacts.empty());
  EXPECT_EQ(outcome.offsets, (std::array<std::uint32_t, k_offset_bins>{}));
  EXPECT_EQ(outcome.offset_squares, 0);
}

TEST(Dice, WithoutRoomHaveNoAnimation) {
  // Goal: dice that start in the same place have zero density and meet no goal.
  Parameters parameters;
  DieStart start;
  start.position_sd_m = {0, 0, 0};
  parameters.world.dice = {start, start};
  parameters.goals = {goal_of(Place{}, 10, 10)};
  const Dice world(parameters);
  const Outcome outcome = world.simulate(state_of(world, 0));
  EXPECT_EQ(outcome.end, End::impossible);
  EXPECT_TRUE(world.starts_overlap(outcome));
  EXPECT_EQ(world.failure(outcome), nullptr);
  EXPECT_FALSE(world.satisfied(outcome));
  EXPECT_EQ(world.log_constraint(outcome), -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(world.outcome_values(outcome).back()));
  EXPECT_TRUE(outcome.contacts.empty());
}

TEST(Dice, ThatStillMoveSatisfyNothing) {
  // Goal: if a die still moves at the time limit, its goals are measured, but the outcome doesn't
  // satisfy the request. Method: set the time limit to a moment of the die's flight.
  Parameters parameters;
  parameters.world.time_max_s = 0.05;
  parameters.goals = {goal_of(Place{}, 10, 10)};
  const Dice world(parameters);
  const Outcome outcome = world.simulate(state_of(world, 0));
  EXPECT_EQ(outcome.end, End::time_limit);
  EXPECT_EQ(outcome.end_s, 0.05);
  EXPECT_TRUE(outcome.judgement.all_met);
  EXPECT_FALSE(world.satisfied(outcome));
  EXPECT_GT(world.log_constraint(outcome), -1);
}

TEST(Dice, AreSeenAtTheTimesOfGoals) {
  // Goal: a goal can be measured before a die's start, in flight and long after the die comes to
  // rest. Method: before the start, compare with the start position. In flight, compare with the
  // parabola. At rest, compare with the end.
  Parameters parameters;
  parameters.world.dice.assign(2, DieStart{});
  parameters.world.dice[1].position_m.y() = 0.1;
  parameters.world.dice[1].start_s = 0.2;
  for (const double at_s : {0.0, 0.03, 5.9}) {
    for (const std::uint32_t die : {0U, 1U}) {
      Goal goal = goal_of(Place{}, 1, 1);
      goal.die = die;
      goal.at_s = at_s;
      parameters.goals.push_back(goal);
    }
  }
  parameters.goals.push_back(goal_of(Place{}, 1, 1));
  const Dice world(parameters);
  const State state = state_of(world, 7);
  const auto from_origin = [](const Vec3& p) { return std::hypot(p.x(), p.y()); };
  const Outcome outcome = world.simulate(state);
  const std::vector<double>& d = outcome.judgement.distances;
  const Vec3 start = state.dice[0].position_m;
  EXPECT_NEAR(d[0], from_origin(start), 1e-12);
  EXPECT_NEAR(d[1], from_origin(state.dice[1].position_m), 1e-12);
  EXPECT_NEAR(d[2], from_origin(start + 0.03 * state.dice[0].velocity_mps), 1e-9);
  EXPECT_NEAR(d[3], from_origin(state.dice[1].position_m), 1e-12);
  EXPECT_EQ(d[4], d[6]);
}

void expect_same(const Outcome& a, const Outcome& b) {
  EXPECT_EQ(a.end, b.end);
  EXPECT_EQ(a.end_s, b.end_s);
  EXPECT_EQ(a.judgement.log_constraint, b.judgement.log_constraint);
  EXPECT_EQ(a.judgement.distances, b.judgement.distances);
  EXPECT_EQ(a.judgement.numberings, b.judgement.numberings);
  EXPECT_EQ(a.contacts, b.contacts);
  EXPECT_EQ(a.collisions, b.collisions);
  EXPECT_EQ(a.log_plausibility, b.log_plausibility);
  EXPECT_EQ(a.offsets, b.offsets);
  EXPECT_EQ(a.offset_squares, b.offset_squares);
}

TEST(Dice, ReplaysMakeNoDifference) {
  // Goal: for proposals of every kind, a candidate's simulation from a similar state gives the same
  // outcome as a simulation from scratch. Method: run chains of one die and chains of four dice.
  // The chains accept half of the candidates. With SLEIGHT_SOAK=1, the chains are 40 times longer.
  const std::uint64_t longer = property::long_run() ? 40 : 1;
  for (const std::uint32_t dice : {1U, 4U}) {
    Parameters parameters = testing::all_random(dice);
    parameters.goals = {goal_of(Place{}, 0.1, 0.01), goal_of(FaceDirection{.face = 1}, 0.2, 0.3)};
    parameters.proposal.change_start = 0.15;
    parameters.proposal.change_contact = 0.75;
    const Dice world(parameters);
    random::Stream stream = testing::stream_of(k_seed, 1000 + dice);
    State state = world.draw_prior(stream);
    Outcome outcome = world.simulate(state);
    std::uint64_t with_history = 0;
    for (std::uint64_t i = 0; i < longer * 400 / dice; ++i) {
      SCOPED_TRACE(fmt::format("{} dice, proposal {}", dice, i));
      const auto proposal = world.propose(state, outcome, {}, stream);
      if (outcome.history) ++with_history;
      const Outcome candidate = world.simulate_from(proposal.candidate, state, outcome);
      expect_same(candidate, world.simulate(proposal.candidate));
      if (HasFailure()) return;
      if (stream.uniform() < 0.5) {
        state = proposal.candidate;
        outcome = candidate;
      }
    }
    EXPECT_GT(with_history, 0U);
    EXPECT_GT(world.owned_bytes(state, outcome), 0U);
  }
}

}  // namespace sleight::worlds::dice::dice_test
