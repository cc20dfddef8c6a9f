#include "worker/worlds/readers/readers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <set>
#include <thread>
#include <vector>

#include "common/scene/surface.h"
#include "tests/unit/worker/worlds/dice/support.h"
#include "tests/unit/worker/worlds/readers/played.h"
#include "worker/physics/surface/spline_surface.h"

namespace sleight::worlds::dice {
namespace {

/// A prior draw with up to three overrides.
State state_of(const Dice& world, std::uint64_t number) {
  random::Stream stream = testing::stream_of(12, number);
  State state = world.draw_prior(stream);
  for (std::uint64_t i = 0; i < number % 4; ++i) {
    set_override(state.overrides,
                 {.index = {static_cast<std::int32_t>(i) - 2, 3},
                  .control = {.height_m = 1e-3, .restitution = 0.4, .friction = 0.5}});
  }
  return state;
}

TEST(DiceReader, StatesComeBackFromTheirBytes) {
  // Goal: decode(encode(state)) returns the state, and decode() refuses bytes that are not an
  // encoded state. Method: cut, lengthen and damage the bytes of draws.
  const Dice world(testing::all_random(2));
  for (std::uint64_t number = 0; number < 20; ++number) {
    const State state = state_of(world, number);
    const base::Bytes bytes = world.encode(state);
    const auto decoded = world.decode(bytes);
    ASSERT_TRUE(decoded.has_value());
    EXPECT_EQ(*decoded, state);
    base::Bytes longer = bytes;
    longer.push_back(std::byte{0});
    EXPECT_FALSE(world.decode(longer));
    for (std::size_t size = 0; size < bytes.size(); size += 7)
      EXPECT_FALSE(world.decode(base::BytesView(bytes).subspan(0, size)));
    EXPECT_FALSE(Dice(testing::all_random(1)).decode(bytes));
  }
  const auto refused = [&](const auto& damage) {
    State bad = state_of(world, 3);
    damage(bad);
    return !world.decode(world.encode(bad)).has_value();
  };
  EXPECT_FALSE(refused([](State&) {}));
  EXPECT_TRUE(refused([](State& s) { s.dice[1].spin_radps.y() = std::nan(""); }));
  EXPECT_TRUE(refused([](State& s) { s.dice[0].orientation.w() += 0.1; }));
  EXPECT_TRUE(refused([](State& s) { std::swap(s.overrides[0], s.overrides[1]); }));
  EXPECT_TRUE(refused([](State& s) { s.overrides[1] = s.overrides[0]; }));
  EXPECT_TRUE(refused([](State& s) { s.overrides[0].index.i = -33; }));
  EXPECT_TRUE(refused([](State& s) { s.overrides[0].control.restitution = 0.8; }));
  EXPECT_TRUE(refused(
      [](State& s) { s.overrides[0].control.height_m = std::numeric_limits<double>::infinity(); }));
  // The count would need more bytes than are available.
  base::Bytes many = world.encode(state_of(world, 0));
  many[15] = std::byte{0x7f};
  EXPECT_FALSE(world.decode(many));
}

TEST(DiceReader, NamesFitValues) {
  // Goal: the numbers of values and outcomes match the layout, and outcomes have unique names. A
  // die's first recorded segment is its start. In its last segment, the die rests on the right
  // face.
  Parameters parameters = testing::all_random(2);
  for (const std::uint32_t die : {0U, 1U}) {
    parameters.goals.push_back(
        {.die = die, .wanted = FaceDirection{.face = 2}, .sigma = 0.2, .tolerance = 0.4});
    parameters.goals.push_back({.die = die, .wanted = Place{}, .sigma = 1, .tolerance = 1});
  }
  const Dice world(parameters);
  const auto reader = make_state_reader(parameters);
  const archive::WorldLayout& layout = reader->layout();
  std::size_t named = 0;
  for (const archive::Variable& variable : layout.variables)
    named += variable.size();
  std::set<std::string> names;
  for (const archive::Variable& outcome : layout.outcomes)
    names.insert(outcome.name);
  EXPECT_EQ(names.size(), layout.outcomes.size());
  std::size_t outcomes = 0;
  for (const archive::Variable& outcome : layout.outcomes)
    outcomes += outcome.size();
  EXPECT_EQ(layout.proposal_kinds.size(), k_kinds);
  const State state = state_of(world, 2);
  const base::Bytes bytes = world.encode(state);
  const std::vector<double> values = reader->variables(bytes);
  ASSERT_EQ(values.size(), named);
  EXPECT_EQ(static_cast<std::uint64_t>(values[0]) << 32U | static_cast<std::uint64_t>(values[1]),
            state.table_key);
  EXPECT_EQ(values[2], 2);
  EXPECT_EQ(world.outcome_values(world.simulate(state)).size(), outcomes);

  worlds::testing::check_prior_draws(*reader);
  const motion::Animation motion = worlds::testing::played(*reader, bytes);
  ASSERT_EQ(motion.bodies(), 2U);
  for (const motion::Path& path : motion.paths()) {
    ASSERT_TRUE(path.enters());
    EXPECT_EQ(path.start_s(), 0);
    EXPECT_EQ(path.segments().front().position_m, state.dice[path.body()].position_m);
    const motion::Segment& last = path.segments().back();
    EXPECT_EQ(last.mode, motion::Mode::resting);
    EXPECT_GT(math::rotated(last.orientation, testing::vector_of(direction_of_face(2, 0))).z(),
              0.9);
  }
}

TEST(DiceReader, TheTableIsTheSimulators) {
  // Goal: heights from an archive's control points equal the simulator's heights wherever a die
  // touches the table. Method: simulate throws with overrides. At each contact, compare the heights
  // at random places near the die's centre, up to half a diagonal away.
  const Parameters parameters = testing::all_random(2);
  const Dice world(parameters);
  const auto reader = make_state_reader(parameters);
  const scene::Scene& scene = reader->scene();
  const std::uint32_t table = scene.find("table").value();
  const auto part = std::ranges::find(scene.parts, table, &scene::Part::feature);
  ASSERT_NE(part, scene.parts.end());
  random::Stream stream = testing::stream_of(14, 0);
  int contacts = 0;
  for (std::uint64_t number = 0; number < 6; ++number) {
    const State state = state_of(world, number);
    const base::Bytes bytes = world.encode(state);
    const archive::Motion motion = reader->play(bytes);
    if (motion.ends == archive::PlaysOut::failed) continue;
    const scene::Surface drawn(reader->variation(bytes, motion.segments).points, part->size_m.z());
    physics::SplineSurface simulated(world.scene(state).surfaces.at(0));
    for (const motion::Segment& segment : motion.segments) {
      if (segment.partner != static_cast<std::int32_t>(table)) continue;
      ++contacts;
      for (int i = 0; i < 8; ++i) {
        const double reach_m = 0.5 * std::sqrt(3.0) * parameters.world.side_m;
        const double x_m = segment.position_m.x() + (2 * stream.uniform() - 1) * reach_m;
        const double y_m = segment.position_m.y() + (2 * stream.uniform() - 1) * reach_m;
        const auto height_m = drawn.height_m(x_m, y_m);
        ASSERT_TRUE(height_m.has_value());
        EXPECT_NEAR(*height_m, simulated.at(x_m, y_m).height_m, 1e-9);
      }
    }
  }
  EXPECT_GT(contacts, 20);
}

TEST(DiceReader, DiceOfWhichTheSameIsWantedAreTwins) {
  // Goal: dice with the same goals are interchangeable. Method: give two of three dice equal goals.
  Parameters parameters = testing::all_random(3);
  for (const std::uint32_t die : {0U, 1U, 2U}) {
    const std::uint32_t face = die == 1 ? 5 : 6;
    parameters.goals.push_back(
        {.die = die, .wanted = FaceDirection{.face = face}, .sigma = 0.2, .tolerance = 0.4});
  }
  const auto reader = make_state_reader(parameters);
  const scene::Scene& scene = reader->scene();
  EXPECT_EQ(scene.features[0].twin_of, 0U);
  EXPECT_EQ(scene.features[1].twin_of, 1U);
  EXPECT_EQ(scene.features[2].twin_of, 0U);
  EXPECT_EQ(scene.features[4].body, 0);
  EXPECT_EQ(scene::fault_of(scene), "");
}

TEST(DiceReader, SaysHowManyNumberingsMeetTheGoals) {
  // Goal: log_natural_throw is the sum of log(24 / n) over all dice. Here, n is the number of
  // numberings that meet the die's goals. With fixed numbering, it is 0. Method: test dice with
  // goals for no face, for one face, and for a face and a yaw.
  Parameters parameters = testing::all_random(2);
  const auto log_throw = [&] { return make_state_reader(parameters)->layout().log_natural_throw; };
  EXPECT_EQ(log_throw(), 0);
  parameters.goals.push_back({.wanted = FaceDirection{.face = 2}});
  EXPECT_NEAR(log_throw(), std::log(6.0), 1e-15);
  parameters.goals.push_back({.die = 1, .wanted = FaceDirection{.face = 2}});
  parameters.goals.push_back(
      {.die = 1, .wanted = FaceDirection{.face = 1, .direction = {1, 0, 0}}});
  EXPECT_NEAR(log_throw(), std::log(6.0 * 24), 1e-14);
  parameters.numbering = Numbering::fixed;
  EXPECT_EQ(log_throw(), 0);
}

TEST(DiceReader, LikenessIsADistance) {
  // Goal: the distance of two animations is symmetric. The distance is 0 if the animations are
  // equal, and positive otherwise.
  const Parameters parameters = testing::all_random();
  const Dice world(parameters);
  const auto reader = make_state_reader(parameters);
  for (std::uint64_t number = 0; number < 5; ++number) {
    const base::Bytes a = world.encode(state_of(world, number));
    const base::Bytes b = world.encode(state_of(world, number + 100));
    EXPECT_EQ(worlds::testing::distance_by(*reader, a, a), 0);
    EXPECT_EQ(worlds::testing::distance_by(*reader, a, b),
              worlds::testing::distance_by(*reader, b, a));
    EXPECT_GT(worlds::testing::distance_by(*reader, a, b), 0.1);
  }
}

TEST(DiceReader, WhatWasAskedBeforeMakesNoDifference) {
  // Goal: a reader's cache never returns the animation of another state. The threads and the order
  // of requests don't matter. Method: in two threads, request more states than the cache holds.
  // Compare with fresh readers.
  constexpr std::uint64_t k_states = 40;
  const Parameters parameters = testing::all_random();
  const Dice world(parameters);
  const auto reader = make_state_reader(parameters);
  std::vector<base::Bytes> states;
  std::vector<std::size_t> rows;
  std::vector<double> distances;  // from state 0
  for (std::uint64_t number = 0; number < k_states; ++number) {
    states.push_back(world.encode(state_of(world, number)));
    rows.push_back(make_state_reader(parameters)->play(states.back()).segments.size());
    distances.push_back(
        worlds::testing::distance_by(*make_state_reader(parameters), states[0], states.back()));
  }
  std::atomic<int> wrong = 0;
  const auto ask = [&](std::uint64_t seed) {
    random::Stream stream = testing::stream_of(seed, 0);
    for (int i = 0; i < 300; ++i) {
      const auto n = static_cast<std::size_t>(stream.uniform() * k_states);
      wrong += reader->play(states[n]).segments.size() != rows[n] ? 1 : 0;
      wrong += worlds::testing::distance_by(*reader, states[0], states[n]) != distances[n] ? 1 : 0;
    }
  };
  {
    const std::jthread other(ask, 1);
    ask(2);
  }
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace sleight::worlds::dice
