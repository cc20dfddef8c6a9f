// States as bytes, and what archives say of them.
#include "worker/worlds/readers/spelling_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {
namespace {

State state_of(const Spelling& world, std::uint64_t number) {
  random::Stream stream({.seed = 12, .purpose = random::Purpose::prior}, number);
  return world.draw_prior(stream);
}

TEST(SpellingReader, StatesComeBackFromTheirBytes) {
  // Goal: decode(encode(state)) is the state, and nothing else is taken. Method: prior draws; cut,
  // lengthened and damaged bytes.
  const Spelling world(Parameters{});
  for (std::uint64_t number = 0; number < 50; ++number) {
    const State state = state_of(world, number);
    base::Bytes bytes = encode(state);
    const auto decoded = decode(world.prior(), bytes);
    ASSERT_TRUE(decoded.has_value());
    EXPECT_EQ(*decoded, state);
    base::Bytes longer = bytes;
    longer.push_back(std::byte{0});
    EXPECT_FALSE(decode(world.prior(), longer));
    base::Bytes shorter(bytes.begin(), bytes.end() - 1);
    EXPECT_FALSE(decode(world.prior(), shorter));
    State bad = state;
    bad.offsets_m[3].y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(decode(world.prior(), encode(bad)));
    bad = state;
    bad.active[2] = 2;
    EXPECT_FALSE(decode(world.prior(), encode(bad)));
  }
}

TEST(SpellingReader, NamesFitValues) {
  // Goal: as many values and outcomes as the layout names, and recordings whose rows are segments
  // in order. Method: count, of the first draw that spells; each ball's first row is its drop, the
  // last row is at rest.
  Parameters parameters;
  parameters.pattern = pattern_of_rows("#.#").value();
  const Spelling world(parameters);
  const auto reader = make_state_reader(parameters);
  std::size_t named = 0;
  for (const archive::Variable& variable : reader->layout().variables)
    named += variable.size();
  std::size_t columns = 0;
  for (const archive::Variable& column : reader->layout().segment_columns)
    columns += column.size();
  State state = state_of(world, 0);
  for (std::uint64_t number = 1; !world.satisfied(world.simulate(state)); ++number)
    state = state_of(world, number);
  const base::Bytes bytes = encode(state);
  EXPECT_EQ(reader->variables(bytes).size(), named);
  EXPECT_EQ(reader->layout().proposal_kinds.size(), k_kinds);
  const archive::Recording recording = reader->play(bytes).recording;
  ASSERT_EQ(recording.columns, columns);
  double ball = -1;
  std::uint32_t balls = 0;
  for (std::size_t row = 0; row < recording.rows(); ++row) {
    const double* values = &recording.values[row * columns];
    if (values[0] != ball) {
      ball = values[0];
      ++balls;
      EXPECT_EQ(state.active[static_cast<std::size_t>(ball)], 1);
      EXPECT_NEAR(values[1], 0.15 * ball, 1e-8);
      EXPECT_NEAR(values[5], 0.080, 1e-12);
    } else {
      EXPECT_GE(values[1], values[1 - static_cast<std::ptrdiff_t>(columns)]);
    }
    const double* q = values + 12;
    EXPECT_NEAR(std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])), 1, 1e-12);
  }
  EXPECT_EQ(balls, state.active_count());
  EXPECT_EQ(recording.values[recording.values.size() - columns + 2], 3);
  EXPECT_EQ(world.outcome_values(world.simulate(state)).size(), reader->layout().outcomes.size());
}

TEST(SpellingReader, BiasedSamplesSaySo) {
  // Goal: archives of the thesis's kernel carry a warning, others none. Method: both layouts.
  Parameters parameters;
  EXPECT_EQ(make_state_reader(parameters)->layout().warning, "");
  parameters.proposal.kernel = Kernel::thesis;
  EXPECT_EQ(make_state_reader(parameters)->layout().warning,
            "biased kernel: thesis (A.2.2 as printed)");
}

TEST(SpellingReader, LikenessIsADistance) {
  // Goal: 0 for the same animation, more for others, symmetric, at most 1. Method: prior draws.
  const Parameters parameters;
  const Spelling world(parameters);
  const auto reader = make_state_reader(parameters);
  double most = 0;
  for (std::uint64_t number = 0; number < 5; ++number) {
    const base::Bytes a = encode(state_of(world, number));
    const base::Bytes b = encode(state_of(world, number + 100));
    EXPECT_EQ(reader->likeness_distance(a, a), 0);
    EXPECT_EQ(reader->likeness_distance(a, b), reader->likeness_distance(b, a));
    EXPECT_LE(reader->likeness_distance(a, b), 1);
    most = std::max(most, reader->likeness_distance(a, b));
  }
  EXPECT_GT(most, 0);
}

TEST(SpellingReader, WedgedBallsDontPlayOut) {
  // Goal: a state that was decided early, but whose balls the simulator can't bring to rest, is not
  // kept, and asking does no harm. Method: balls that nearly fill their bins; of the satisfying
  // states both sorts come up, and those that play out can be recorded.
  Parameters parameters;
  parameters.pattern = pattern_of_rows("#.").value();
  parameters.world.ball_diameter_m = 0.01998;
  parameters.world.partition_height_m = 0.025;
  const Spelling world(parameters);
  const auto reader = make_state_reader(parameters);
  int plays = 0;
  int fails = 0;
  for (std::uint64_t draw = 0; draw < 4000 && (plays == 0 || fails == 0); ++draw) {
    random::Stream stream({.seed = 7, .purpose = random::Purpose::prior}, draw);
    const State state = world.draw_prior(stream);
    if (!world.satisfied(world.simulate(state))) continue;
    if (reader->play(world.encode(state)).ends == archive::PlaysOut::yes) {
      ++plays;
      EXPECT_GT(reader->play(world.encode(state)).recording.rows(), 1U);
    } else {
      ++fails;
    }
  }
  EXPECT_GT(plays, 0);
  EXPECT_GT(fails, 0);
}

}  // namespace
}  // namespace sleight::worlds::spelling
