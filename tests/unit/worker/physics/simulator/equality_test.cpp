#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "tests/engines/engines.h"
#include "tests/scenes/shared/random_starts.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/simulator/fixed_and_filtered.h"
#include "tests/unit/worker/physics/simulator/noised_scenes.h"
#include "tests/unit/worker/physics/simulator/scenes_under_test.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics {
namespace {

using testing::TestScene;

/// Number of scenes. The long run (SLEIGHT_SOAK=1) tests as many scenes as the project promises.
std::uint64_t scene_count() {
  return property::long_run() ? 10'000 : property::of_tier(33, 300);
}

struct Outcome {
  std::uint64_t digest = 0;
  std::uint64_t collisions = 0;
  std::string error;
  std::vector<Impact> impacts{};
  bool operator==(const Outcome&) const = default;
};

Outcome outcome_of(const TestScene& scene, SimulationOptions options) {
  options.keep_impacts = true;
  auto started = Simulation::start(scene.setting.scene, options);
  if (!started) return {.error = started.error().message};
  Simulation simulation = std::move(started).value();
  const auto error = simulation.run_until(Tick{} + ticks_after(scene.setting.duration_s));
  const Counts& counts = simulation.counts();
  return {.digest = simulation.recording().digest(),
          .collisions = counts.collisions + counts.static_collisions,
          .error = error ? error->message : "",
          .impacts = {simulation.impacts().begin(), simulation.impacts().end()}};
}

struct Way {
  const char* name;
  SimulationOptions options;
};

SimulationOptions way(Algorithm algorithm, BroadPhaseKind broad_phase, QueueKind queue) {
  SimulationOptions options;
  options.algorithm = algorithm;
  options.make_engine = engine_with(broad_phase, queue);
  return options;
}

std::array<Way, 5> ways() {
  using enum BroadPhaseKind;
  using enum QueueKind;
  return {
      {{"asynchronous, grid, tournament",
        way(Algorithm::asynchronous, hierarchical_grid, tournament)},
       {"asynchronous, grid, heap", way(Algorithm::asynchronous, hierarchical_grid, heap)},
       {"asynchronous, sweep, calendar", way(Algorithm::asynchronous, sweep_and_prune, calendar)},
       {"synchronous, sweep, tournament", way(Algorithm::synchronous, sweep_and_prune, tournament)},
       {"synchronous, grid, heap", way(Algorithm::synchronous, hierarchical_grid, heap)}}};
}

/// Simulates a scene in every way and compares with a reference. The reference predicts all pairs
/// and has no bounding volumes. Returns the number of collisions.
std::uint64_t compare_ways(const TestScene& scene) {
  const Outcome expected = outcome_of(
      scene, way(Algorithm::all_pairs, BroadPhaseKind::hierarchical_grid, QueueKind::tournament));
  EXPECT_EQ(expected.error, "");
  EXPECT_EQ(expected.impacts.size(), expected.collisions);
  for (const Way& tried : ways()) {
    const Outcome outcome = outcome_of(scene, tried.options);
    EXPECT_EQ(outcome.error, expected.error) << tried.name;
    EXPECT_EQ(outcome.collisions, expected.collisions) << tried.name;
    EXPECT_EQ(outcome.digest, expected.digest) << tried.name;
    EXPECT_TRUE(outcome.impacts == expected.impacts) << tried.name;
  }
  return expected.collisions;
}

/// Runs a scene in random portions, each with other options, and compares with one run.
void compare_portions(const TestScene& scene, std::uint64_t n) {
  const Outcome expected = outcome_of(scene, {});
  auto started = Simulation::start(scene.setting.scene, {.keep_impacts = true});
  ASSERT_TRUE(started.ok());
  Simulation simulation = std::move(started).value();
  random::Stream stream = scenes::stream_of_scene(n, 2);
  const Tick end = Tick{} + ticks_after(scene.setting.duration_s);
  const auto others = ways();
  for (std::size_t portion = 0; simulation.now() < end; ++portion) {
    const double share = 0.3 * stream.uniform();
    const TickCount span = 1 + static_cast<TickCount>(share * static_cast<double>(end.value));
    ASSERT_FALSE(simulation.run_until(std::min(end, simulation.now() + span)));
    simulation.go_on_with(portion % 6 == 5 ? way(Algorithm::all_pairs,
                                                 BroadPhaseKind::hierarchical_grid, QueueKind::heap)
                                           : others[portion % 6].options);
  }
  const Counts& counts = simulation.counts();
  EXPECT_EQ(counts.collisions + counts.static_collisions, expected.collisions) << scene.name;
  EXPECT_EQ(simulation.recording().digest(), expected.digest) << scene.name;
  EXPECT_TRUE(std::ranges::equal(simulation.impacts(), expected.impacts)) << scene.name;
}

TEST(Equality, EveryWayGivesTheSameRecording) {
  // Goal: the choice of algorithm, broad phase and queue changes no bit of recording and impacts.
  // Method: simulate random scenes of every kind, and compare with a reference.
  std::uint64_t collisions = 0;
  for (const std::uint64_t n : property::cases(scene_count())) {
    const TestScene scene = testing::any_scene(n);
    SCOPED_TRACE("scene " + std::to_string(n) + ": " + scene.name);
    collisions += compare_ways(scene);
    if (HasFailure()) return;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(collisions, 100 * scene_count());
}

TEST(Equality, AlsoWithFixedBodiesAndFilteredGroups) {
  // Goal: the same for scenes in which some bodies are fixed and some groups don't meet. Method: as
  // above. Each scene is also continued by other ways.
  std::uint64_t collisions = 0;
  for (const std::uint64_t n : property::cases(scene_count())) {
    testing::Dice dice(20270311, n);
    TestScene scene = testing::any_scene(n);
    scene.setting.scene = testing::fixed_and_filtered(std::move(scene.setting.scene), dice);
    SCOPED_TRACE("scene " + std::to_string(n) + ": " + scene.name);
    collisions += compare_ways(scene);
    compare_portions(scene, n);
    if (HasFailure()) return;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(collisions, 50 * scene_count());
}

TEST(Equality, AlsoWithContactNoise) {
  // Goal: the same for scenes with contact noise. Method: as above. The pairs' noised impacts are
  // numbered from 1 without gaps, and those below the noise's speed have no number.
  std::uint64_t noised = 0;
  for (const std::uint64_t n : property::cases(property::of_tier(22, scene_count()))) {
    testing::Dice dice(20270312, n);
    TestScene scene = testing::any_scene(n);
    testing::add_noise(scene.setting.scene, dice.between(0.02, 0.5), dice);
    SCOPED_TRACE("scene " + std::to_string(n) + ": " + scene.name);
    compare_ways(scene);
    compare_portions(scene, n);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> numbers;
    for (const Impact& impact : outcome_of(scene, {}).impacts) {
      if (impact.noise_number == 0) continue;
      ++noised;
      EXPECT_GT(impact.approach_mps, scene.setting.scene.noise.above_mps);
      EXPECT_EQ(impact.noise_number, (++numbers[{impact.lower, impact.higher}]));
    }
    if (HasFailure()) return;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(noised, 1000U);
}

TEST(Equality, OneWayMayTakeOverFromAnother) {
  // Goal: a switch to other options (go_on_with) changes no bit of the recording. At the switch,
  // bodies may fly, touch, rest or not have started. Method: run scenes of all kinds in random
  // portions. Each portion has different options.
  for (const std::uint64_t n : property::cases(property::of_tier(22, 90)))
    compare_portions(testing::any_scene(n), n);
}

TEST(Equality, TakingOverRepeatsNothingAndForgetsNoFailure) {
  // Goal: go_on_with() repeats no event of the current tick, not even at tick 0. An error stays
  // after go_on_with(). Method: use a scene that has a control and a sample at tick 0. The scene's
  // only body starts later. Also use a scene that fails when a body starts late.
  Scene scene = scenes::rain(1, 1).scene;
  scene.bodies[0].start_tick = Tick{1000};
  scene.controls.push_back({.tick = Tick{0}, .body = {0}});
  SimulationOptions options;
  options.sample_every = 100;
  int samples = 0;
  options.on_sample = [&](Tick) { ++samples; };
  Simulation simulation = Simulation::start(scene, options).value();
  simulation.go_on_with(options);
  ASSERT_FALSE(simulation.run_until(Tick{1000}));
  EXPECT_EQ(samples, 11);
  EXPECT_EQ(simulation.counts().controls, 1U);
  EXPECT_EQ(simulation.counts().starts, 1U);

  Scene crowded = scenes::boxed_spheres(1, 1).scene;
  crowded.bodies.push_back(crowded.bodies[0]);
  crowded.bodies[1].start_tick = Tick{10};
  Simulation failing = Simulation::start(crowded, {}).value();
  const auto error = failing.run_until(Tick{20});
  ASSERT_TRUE(error);
  failing.go_on_with(way(Algorithm::synchronous, BroadPhaseKind::sweep_and_prune, QueueKind::heap));
  const auto again = failing.run_until(Tick{20});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->message, error->message);
}

TEST(Equality, AnotherSeedIsAnotherRecording) {
  // Goal: different runs have different digests. Method: use another seed, and change one velocity
  // by 2^-52 m/s.
  const SimulationOptions options;
  TestScene scene{"rain", scenes::rain(20, 1)};
  const Outcome first = outcome_of(scene, options);
  EXPECT_EQ(outcome_of(scene, options), first);
  EXPECT_NE(outcome_of({"rain", scenes::rain(20, 2)}, options).digest, first.digest);
  scene.setting.scene.bodies[7].start.twist.velocity_mps.x() += 0x1p-52;
  EXPECT_NE(outcome_of(scene, options).digest, first.digest);
}

TEST(Equality, ShiftedScenesGiveShiftedTicks) {
  // Goal: if all starts and controls of a scene are shifted in time, the recording shifts by the
  // same number of ticks. Nothing else changes (simulation.h, invariant 3).
  for (const std::uint64_t n : property::cases(60)) {
    const TestScene scene = testing::any_scene(n);
    // Bodies that start at rest must start at tick 0.
    if (std::ranges::any_of(scene.setting.scene.bodies, &BodyDescription::rests)) continue;
    TestScene shifted = scene;
    const TickCount shift = 123'456'789 + static_cast<TickCount>(n);
    for (BodyDescription& body : shifted.setting.scene.bodies)
      body.start_tick = body.start_tick + shift;
    for (Control& control : shifted.setting.scene.controls)
      control.tick = control.tick + shift;
    const Tick end = Tick{} + ticks_after(scene.setting.duration_s);
    auto a = Simulation::start(scene.setting.scene, {});
    auto b = Simulation::start(shifted.setting.scene, {});
    ASSERT_TRUE(a.ok() && b.ok());
    Simulation plain = std::move(a).value();
    Simulation later = std::move(b).value();
    ASSERT_FALSE(plain.run_until(end));
    ASSERT_FALSE(later.run_until(end + shift));
    for (std::uint32_t body = 0; body < scene.setting.scene.bodies.size(); ++body) {
      const auto first = plain.recording().segments({body});
      const auto second = later.recording().segments({body});
      ASSERT_EQ(first.size(), second.size()) << scene.name;
      for (std::size_t i = 0; i < first.size(); ++i) {
        const FreeFlight& p = first[i].segment.flight;
        const FreeFlight& q = second[i].segment.flight;
        ASSERT_EQ(p.begin + shift, q.begin) << scene.name;
        ASSERT_EQ(p.position_m, q.position_m) << scene.name;
        ASSERT_EQ(p.velocity_mps, q.velocity_mps) << scene.name;
        ASSERT_EQ(p.angular_velocity_radps, q.angular_velocity_radps) << scene.name;
      }
    }
  }
}

}  // namespace
}  // namespace sleight::physics
