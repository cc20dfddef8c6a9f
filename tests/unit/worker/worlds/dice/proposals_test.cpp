// Tests what proposals change, and their ratios. The tests in tests/statistical check that
// proposals leave the target distribution invariant.
#include "worker/worlds/dice/proposals.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "tests/support/property.h"
#include "tests/unit/worker/worlds/dice/support.h"

namespace sleight::worlds::dice {
namespace {

Parameters only(Kind kind, Parameters parameters) {
  ProposalParameters& p = parameters.proposal;
  p.change_all = kind == Kind::change_all ? 1 : 0;
  p.change_die = kind == Kind::change_die ? 1 : 0;
  p.change_start = kind == Kind::change_start ? 1 : 0;
  p.change_control = kind == Kind::change_control ? 1 : 0;
  p.change_contact = kind == Kind::change_contact ? 1 : 0;
  return parameters;
}

State state_of(const Parameters& parameters, std::uint64_t number) {
  random::Stream stream = testing::stream_of(3, number);
  return draw_state(parameters.world, stream);
}

/// Number of values that differ in velocity, spin and place. A different orientation counts as one
/// more.
int differing(const DieThrow& a, const DieThrow& b) {
  int count = a.orientation.coeffs() == b.orientation.coeffs() ? 0 : 1;
  for (int axis = 0; axis < 3; ++axis) {
    count += a.position_m[axis] != b.position_m[axis] ? 1 : 0;
    count += a.velocity_mps[axis] != b.velocity_mps[axis] ? 1 : 0;
    count += a.spin_radps[axis] != b.spin_radps[axis] ? 1 : 0;
  }
  return count;
}

TEST(DiceProposals, ReflectAtTheEnds) {
  // Goal: if a value is beyond an end of the range, reflected() reflects it into the range, however
  // far away it is.
  const Range range{0.25, 0.75};
  EXPECT_EQ(reflected(0.5, range), 0.5);
  EXPECT_EQ(reflected(0.875, range), 0.625);
  EXPECT_EQ(reflected(0.125, range), 0.375);
  EXPECT_EQ(reflected(1.5, range), 0.5);
  EXPECT_EQ(reflected(-10.0, range), 0.5);
  EXPECT_EQ(reflected(0.75, range), 0.75);
}

TEST(DiceProposals, ChangeAllAndDieAreDraws) {
  // Goal: for an independence draw, the q ratio is the ratio of the two states' densities. Method:
  // draw all three dice of a state with overrides. Then draw only one of its dice.
  const Parameters parameters = only(Kind::change_all, testing::all_random(3));
  State state = state_of(parameters, 0);
  set_override(state.overrides, {{1, 1}, {.height_m = 1e-3, .restitution = 0.4, .friction = 0.5}});
  random::Stream stream = testing::stream_of(4, 0);
  const auto all = propose(parameters, state, {}, {}, stream);
  EXPECT_NE(all.candidate.table_key, state.table_key);
  EXPECT_TRUE(all.candidate.overrides.empty());
  EXPECT_EQ(all.log_q_ratio, log_density_of(parameters.world, state) -
                                 log_density_of(parameters.world, all.candidate));
  EXPECT_FALSE(all.ratio_waits);

  const auto one = propose(only(Kind::change_die, parameters), state, {}, {}, stream);
  EXPECT_EQ(one.candidate.overrides, state.overrides);
  int changed = 0;
  for (std::size_t die = 0; die < 3; ++die)
    changed += one.candidate.dice[die] == state.dice[die] ? 0 : 1;
  EXPECT_EQ(changed, 1);
  EXPECT_NEAR(
      one.log_q_ratio,
      log_density_of(parameters.world, state) - log_density_of(parameters.world, one.candidate),
      1e-9);
}

TEST(DiceProposals, ChangeStartChangesOneRandomComponent) {
  // Goal: each proposal changes one random component of a die's start. Every random component
  // changes sometimes, and fixed components never change. Step sizes are proportional to the scale.
  // Method: make many proposals from a state in which heights and vertical velocities are fixed.
  const Parameters parameters = only(Kind::change_start, testing::all_random(2));
  const State state = state_of(parameters, 1);
  std::array<int, 10> turns{};
  for (const std::uint64_t draw : property::cases(2000)) {
    random::Stream stream = testing::stream_of(5, draw);
    const auto proposal = propose(parameters, state, {}, {}, stream);
    EXPECT_EQ(differing(proposal.candidate.dice[0], state.dice[0]) +
                  differing(proposal.candidate.dice[1], state.dice[1]),
              1);
    EXPECT_EQ(proposal.log_q_ratio, 0);
    EXPECT_TRUE(std::isfinite(log_density_of(parameters.world, proposal.candidate)));
    const DieThrow& before = state.dice[0];
    const DieThrow& after = proposal.candidate.dice[0];
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<std::size_t>(axis);
      turns[k] += before.position_m[axis] != after.position_m[axis] ? 1 : 0;
      turns[3 + k] += before.velocity_mps[axis] != after.velocity_mps[axis] ? 1 : 0;
      turns[6 + k] += before.spin_radps[axis] != after.spin_radps[axis] ? 1 : 0;
    }
    turns[9] += before.orientation.coeffs() != after.orientation.coeffs() ? 1 : 0;
    // With a thousandth of the scale, the same draw gives a thousandth of the step.
    random::Stream again = testing::stream_of(5, draw);
    const std::array<double, k_kinds> scales{1, 1, 1e-3, 1, 1};
    const auto small = propose(parameters, state, {}, scales, again);
    EXPECT_NEAR(small.candidate.dice[0].velocity_mps.x() - before.velocity_mps.x(),
                1e-3 * (after.velocity_mps.x() - before.velocity_mps.x()), 1e-12);
  }
  if (!property::all_cases()) return;
  for (const std::size_t component : {0U, 1U, 3U, 4U, 6U, 7U, 8U, 9U})
    EXPECT_NEAR(turns[component], 125, 50) << component;
  EXPECT_EQ(turns[2] + turns[5], 0);
}

TEST(DiceProposals, ChangeControlChangesOneFieldOfOnePoint) {
  // Goal: each proposal changes one field of one of the table's control points. The field stays in
  // its range. Every point and every field changes sometimes. Method: make many successive
  // proposals on a table of four by three points.
  Parameters parameters = only(Kind::change_control, testing::all_random());
  parameters.world.table.columns = 4;
  parameters.world.table.rows = 3;
  parameters.proposal.halvings = 1;
  State state = state_of(parameters, 2);
  std::array<int, 3> fields{};
  for (const std::uint64_t draw : property::cases(600)) {
    random::Stream stream = testing::stream_of(6, draw);
    const auto proposal = propose(parameters, state, {}, {}, stream);
    const auto changed = differences(state.overrides, proposal.candidate.overrides);
    ASSERT_EQ(changed.size(), 1U);
    const SurfaceControl before = control_at(parameters.world, state, changed[0]);
    const SurfaceControl after = control_at(parameters.world, proposal.candidate, changed[0]);
    const std::array<bool, 3> differ{before.height_m != after.height_m,
                                     before.restitution != after.restitution,
                                     before.friction != after.friction};
    EXPECT_EQ(differ[0] + differ[1] + differ[2], 1);
    for (std::size_t field = 0; field < 3; ++field)
      fields[field] += differ[field] ? 1 : 0;
    EXPECT_TRUE(std::isfinite(log_density_of(parameters.world, proposal.candidate)));
    state = proposal.candidate;
  }
  if (!property::all_cases()) return;
  EXPECT_EQ(state.overrides.size(), 12U);
  for (const int count : fields)
    EXPECT_NEAR(count, 200, 60);
}

TEST(DiceProposals, ChangeContactFollowsTheShares) {
  // Goal: a proposal chooses each control point with the probability of its share, and changes
  // nothing with the apron's share. The ratio never exceeds its bound, and is 0 if the step cannot
  // be reversed. Method: use three control points. Their shares add up to 3/4.
  const Parameters parameters = only(Kind::change_contact, testing::all_random());
  const State state = state_of(parameters, 3);
  const ContactShares contacts{{{-3, 0}, 0.125}, {{0, 2}, 0.375}, {{5, 5}, 0.25}};
  std::array<int, 4> counts{};
  for (const std::uint64_t draw : property::cases(4000)) {
    random::Stream stream = testing::stream_of(7, draw);
    const auto proposal = propose(parameters, state, contacts, {}, stream);
    if (proposal.candidate == state) {
      ++counts[3];
      EXPECT_FALSE(proposal.ratio_waits);
      EXPECT_EQ(proposal.log_q_ratio, 0);
      continue;
    }
    EXPECT_TRUE(proposal.ratio_waits);
    const GridIndex index = proposal.candidate.overrides.at(0).index;
    for (std::size_t k = 0; k < 3; ++k)
      counts[k] += contacts[k].index == index ? 1 : 0;
    for (const double back : {1e-9, 0.1, 4.0 / 9.0}) {
      const double ratio =
          contact_log_q_ratio(state, contacts, proposal.candidate, {{index, back}});
      EXPECT_DOUBLE_EQ(ratio, std::log(back / share_of(contacts, index)));
      EXPECT_LE(ratio, proposal.log_q_ratio);
    }
    EXPECT_EQ(contact_log_q_ratio(state, contacts, proposal.candidate, {{{-30, 0}, 0.4}}),
              -std::numeric_limits<double>::infinity());
  }
  if (!property::all_cases()) return;
  EXPECT_NEAR(counts[0], 500, 100);
  EXPECT_NEAR(counts[1], 1500, 150);
  EXPECT_NEAR(counts[2], 1000, 130);
  EXPECT_NEAR(counts[3], 1000, 130);
}

TEST(DiceState, DensityIsThatOfTheStartsAndOfWhatIsOverridden) {
  // Goal: log p_w follows the formula in state.h. Method: test a fresh draw, overrides that equal
  // the key's own points, other overrides, and fixed components with wrong values.
  Parameters parameters = testing::all_random();
  const State state = state_of(parameters, 4);
  const double fresh = log_density_of(parameters.world, state);
  EXPECT_EQ(fresh, log_density_of(parameters.world.dice[0], state.dice[0]));
  State same = state;
  const SurfaceControl own = control_of_key(parameters.world.table, state.table_key, {2, -2});
  set_override(same.overrides, {.index = {2, -2}, .control = own});
  EXPECT_EQ(log_density_of(parameters.world, same), fresh);
  SurfaceControl flat = own;
  flat.height_m = 0;
  set_override(same.overrides, {.index = {2, -2}, .control = flat});
  const double z = own.height_m / parameters.world.table.height_sd_m;
  EXPECT_NEAR(log_density_of(parameters.world, same), fresh + 0.5 * z * z, 1e-9);
  State moved = state;
  moved.dice[0].position_m.z() += 1e-9;
  EXPECT_EQ(log_density_of(parameters.world, moved), -std::numeric_limits<double>::infinity());
  parameters.world.dice[0].orientation = StartOrientation::fixed;
  EXPECT_EQ(log_density_of(parameters.world, state), -std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace sleight::worlds::dice
