// Tests that replaying the history of a slightly different scene changes no result.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/simulator/proposals.h"
#include "tests/unit/worker/physics/simulator/reuse_runs.h"
#include "worker/physics/scene/static_geometries.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics {
namespace {

using testing::balls_apart;
using testing::changes_of;
using testing::Dice;
using testing::first_difference;
using testing::random_way;
using testing::run;
using testing::RunResult;
using testing::same_state;
using testing::Subject;

constexpr std::uint64_t k_seed = 20261121;
constexpr int k_steps = 20;

/// Number of chains. Each chain has k_steps proposals.
std::uint64_t chain_count() {
  return property::long_run() ? 100'000 / k_steps : property::of_tier(36, 64);
}

struct Tally {
  std::uint64_t runs = 0;
  std::uint64_t failed = 0;
  std::uint64_t replayed = 0;   ///< replayed events
  std::uint64_t simulated = 0;  ///< simulated events, in runs with a history
  std::uint64_t all = 0;        ///< events of simulations from scratch
};

/// Makes proposals. Each proposal changes the last accepted proposal, at first `accepted`.
void run_chain(const Subject& subject, Scene accepted, Dice& dice, Tally& tally) {
  std::shared_ptr<const History> history;
  const auto geometries = std::make_shared<const StaticGeometries>();
  for (int step = 0; step < k_steps; ++step) {
    SCOPED_TRACE(fmt::format("step {}", step));
    Scene scene = accepted;
    const bool is_same = step == 0 || dice.one_in(12);
    for (auto changes = is_same ? 0 : 1 + dice.below(2); changes > 0; --changes)
      testing::change(scene, subject, dice);
    const Tick end =
        Tick{} + ticks_after(subject.duration_s * (0.4 + 0.1 * static_cast<double>(dice.below(7))));
    const SimulationOptions way = random_way(dice);
    ++tally.runs;
    scene.geometries = nullptr;
    auto whole = Simulation::start(scene, {.keep_impacts = way.keep_impacts});
    if (step % 4 != 3) scene.geometries = geometries;
    auto reused = Simulation::start(scene, way, history);
    ASSERT_EQ(whole.ok(), reused.ok());
    if (!whole) {
      ASSERT_EQ(whole.error().message, reused.error().message);
      ++tally.failed;
      continue;
    }
    Simulation expected = std::move(whole).value();
    Simulation simulation = std::move(reused).value();
    std::optional<SceneError> error;
    const auto looks = 1 + dice.below(3);
    for (std::uint64_t look = 1; look <= looks && !error; ++look) {
      const Tick tick{end.value * static_cast<TickCount>(look) / static_cast<TickCount>(looks)};
      error = expected.run_until(tick);
      const auto other = simulation.run_until(tick);
      ASSERT_EQ(error ? error->message : "", other ? other->message : "");
      if (error) break;
      ASSERT_TRUE(same_state(expected, simulation, scene.bodies.size()))
          << first_difference(expected.recording(), simulation.recording());
      ASSERT_TRUE(std::ranges::equal(expected.impacts(), simulation.impacts()));
      if (dice.one_in(4)) simulation.go_on_with(random_way(dice));
      if (dice.one_in(8)) {
        ASSERT_EQ(simulation.recording().digest(), expected.recording().digest());
      }
    }
    ASSERT_EQ(simulation.now(), expected.now());
    ASSERT_EQ(simulation.recording().digest(), expected.recording().digest())
        << first_difference(expected.recording(), simulation.recording());
    if (error) {
      ++tally.failed;
      ASSERT_EQ(simulation.history(), nullptr);
      continue;
    }
    if (history) {
      tally.replayed += simulation.counts().replayed;
      tally.simulated += changes_of(simulation.counts());
      tally.all += changes_of(expected.counts());
    }
    // A rejected proposal leaves the history unchanged.
    if (!history || dice.one_in(2)) {
      history = simulation.history();
      ASSERT_NE(history, nullptr);
      accepted = std::move(scene);
    }
  }
}

TEST(Reuse, ReplayingMakesNoDifference) {
  // Goal: a simulation with a history equals a simulation from scratch, bit for bit. Method: in
  // random scenes of every kind, make successive proposals and accept some. Proposals change
  // starts, move static geometry, kick bodies, or change laws. Simulate each proposal twice. The
  // first simulation is from scratch; the second uses random options and the history of the last
  // accepted proposal.
  std::map<std::string, Tally> by_kind;
  const std::uint64_t count = chain_count();
  for (const std::uint64_t n : property::cases(count)) {
    if (HasFatalFailure()) break;
    const Subject subject = testing::subject_of(n);
    SCOPED_TRACE(subject.name);
    Dice dice(k_seed, n);
    run_chain(subject, subject.scene, dice,
              by_kind[subject.name.substr(0, subject.name.find(' '))]);
  }
  for (const auto& [kind, tally] : by_kind) {
    fmt::print("seed {}: {}: {} runs, {} failed; events: {} replayed, {} simulated, {} without\n",
               k_seed, kind, tally.runs, tally.failed, tally.replayed, tally.simulated, tally.all);
    if (!property::all_cases()) continue;
    // While unbalanced stacks of cubes topple, all cubes are live, and only 1.96% of the events are
    // replayed.
    EXPECT_GT(tally.replayed, tally.simulated / (kind == "cube_stack" ? 60 : 50)) << kind;
    EXPECT_LT(tally.failed, tally.runs / 2) << kind;
  }
}

TEST(Reuse, AlsoWithFixedBodiesAndFilteredGroups) {
  // Goal: the same for scenes in which some bodies are fixed and some groups don't meet. Method: as
  // above. Proposals also fix, release and move bodies, and change groups and their filter.
  Tally tally;
  for (const std::uint64_t n : property::cases(property::of_tier(18, chain_count()))) {
    if (HasFatalFailure()) break;
    Subject subject = testing::subject_of(n);
    SCOPED_TRACE(subject.name);
    Dice dice(k_seed + 2, n);
    subject.fixes = true;
    run_chain(subject, testing::fixed_and_filtered(subject.scene, dice), dice, tally);
  }
  if (!property::all_cases()) return;
  EXPECT_GT(tally.replayed, tally.simulated / 5);
  EXPECT_LT(tally.failed, tally.runs / 5);
}

TEST(Reuse, AlsoWithContactNoise) {
  // Goal: the same with contact noise, and with bodies that start at rest and move or turn.
  // Proposals also change the noise of one impact or of all. The lists of impacts, with the
  // numbers of the noised ones, must be equal too.
  Tally tally;
  Tally standing;
  for (const std::uint64_t n : property::cases(property::of_tier(12, chain_count()))) {
    if (HasFatalFailure()) break;
    Dice dice(k_seed + 3, n);
    const bool stands = n % 4 == 3;
    Subject subject = testing::subject_of(n);
    if (stands) {
      subject = {"slabs", testing::standing_slabs(static_cast<std::uint32_t>(3 + n % 3)), 0.2};
      subject.standing = true;
    }
    SCOPED_TRACE(subject.name);
    subject.noised = true;
    testing::add_noise(subject.scene, dice.between(0.02, 0.5), dice);
    run_chain(subject, subject.scene, dice, stands ? standing : tally);
  }
  fmt::print("seed {}: {} runs, {} failed; standing {}, {}; events replayed {} and {} of {}\n",
             k_seed, tally.runs, tally.failed, standing.runs, standing.failed, tally.replayed,
             standing.replayed, standing.all);
  if (!property::all_cases()) return;
  EXPECT_GT(tally.replayed, tally.simulated / 10);
  EXPECT_GT(standing.replayed, standing.simulated / 10);
  EXPECT_LT(tally.failed, tally.runs / 3);
  EXPECT_LT(standing.failed, standing.runs / 5);
}

TEST(Reuse, OneOtherImpactLeavesAllBeforeItAsItWas) {
  // Goal: if the noise of one impact differs, all events before it are replayed, and the body's
  // motion differs from there on. Method: change the second impact of one of eight balls.
  Scene scene = balls_apart(8);
  scene.bodies[5].start.pose.position_m.z() = 0.5;
  Dice dice(k_seed, 0);
  testing::add_noise(scene, 0.05, dice);
  SimulationOptions options;
  options.keep_impacts = options.keep_history = true;
  Simulation earlier = Simulation::start(scene, options).value();
  ASSERT_FALSE(earlier.run_until(Tick{} + ticks_after(1.5)));
  auto other = std::make_shared<testing::RandomNoise>(
      static_cast<const testing::RandomNoise&>(*scene.noise.values));
  other->overrides[{5, k_static, 2}] = {1, 0, 0};
  Scene after = scene;
  after.noise.values = other;
  Simulation reused = Simulation::start(after, options, earlier.history()).value();
  ASSERT_FALSE(reused.run_until(Tick{} + ticks_after(1.5)));
  EXPECT_EQ(reused.recording().digest(), run(after, 1.5).digest);
  EXPECT_LT(changes_of(reused.counts()), changes_of(run(after, 1.5).counts) / 4);
  const auto is_changed = [](const Impact& impact) {
    return impact.lower == 5 && impact.noise_number == 2;
  };
  const auto changed = std::ranges::find_if(reused.impacts(), is_changed);
  ASSERT_NE(changed, reused.impacts().end());
  const auto was = earlier.recording().segments({5});
  const auto is = reused.recording().segments({5});
  ASSERT_GT(is.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(same_bits(was[i].segment, is[i].segment), was[i].cause.tick < changed->tick);
}

TEST(Reuse, AWrongHistoryMakesADifference) {
  // Goal: a replayed body is not simulated, so a wrong history gives a wrong result, and the test
  // above can fail. Method: change the scene that a history stores, then replay the history.
  const Scene before = balls_apart(3);
  Scene after = before;
  after.bodies[1].start.twist.velocity_mps.x() = 0.1;
  const RunResult earlier = run(before, 1);
  History wrong = *earlier.history;
  EXPECT_EQ(run(after, 1, earlier.history).digest, run(after, 1).digest);
  wrong.scene = after;
  EXPECT_EQ(run(after, 1, std::make_shared<const History>(wrong)).digest, earlier.digest);
  EXPECT_NE(earlier.digest, run(after, 1).digest);
}

TEST(Reuse, OnlyWhatDiffersIsSimulated) {
  // Goal: a simulation with a history simulates only the bodies that differ. Method: change the
  // start of one of eight separate balls, and count the simulated events. A replay of the same
  // scene must simulate no event.
  const Scene before = balls_apart(8);
  const RunResult earlier = run(before, 2);
  Scene after = before;
  after.bodies[5].start.pose.position_m.z() += 0.01;
  const RunResult reused = run(after, 2, earlier.history);
  EXPECT_EQ(reused.digest, run(after, 2).digest);
  EXPECT_GT(reused.counts.replayed, 7U);
  EXPECT_EQ(reused.counts.starts, 8U);
  const Counts alone = run(after, 2).counts;
  EXPECT_LT(reused.counts.static_collisions, alone.static_collisions / 4);
  EXPECT_EQ(run(before, 2, earlier.history).counts.events(), 0U);
}

TEST(Reuse, AFailureComesAsItWould) {
  // Goal: a simulation that uses a history gives the same error as a simulation from scratch,
  // because replayed collisions count too. Method: let a ball bounce lower and lower in a scene
  // without a rule for slow contacts, until the simulation gives up. Replay histories that end
  // slightly before the error.
  Scene scene = balls_apart(1);
  scene.slow = {};
  Simulation whole = Simulation::start(scene, {}).value();
  const auto error = whole.run_until(Tick{} + ticks_after(5));
  ASSERT_TRUE(error);
  for (const TickCount before : {TickCount{1} << 10U, TickCount{1} << 16U, TickCount{1} << 19U}) {
    SimulationOptions options;
    options.keep_history = true;
    Simulation earlier = Simulation::start(scene, options).value();
    ASSERT_FALSE(earlier.run_until(whole.now() - before));
    Simulation goes_on = Simulation::start(scene, options, earlier.history()).value();
    const auto same = goes_on.run_until(Tick{} + ticks_after(5));
    ASSERT_TRUE(same);
    EXPECT_EQ(same->message, error->message);
    EXPECT_EQ(goes_on.history(), nullptr);
  }
}

TEST(Reuse, WhatIsTheSameIsShared) {
  // Goal: a new history shares memory with the previous history and leaves the previous history
  // unchanged. Method: kick a ball late in a run of 120 balls. Both histories must have the same
  // chunks before the kick.
  Scene scene = balls_apart(120);
  const RunResult earlier = run(scene, 2);
  const std::size_t chunks = earlier.history->chunks.size();
  ASSERT_GT(chunks, 3U);
  const auto second =
      earlier.history->chunks[1];  // the first chunk contains tick 0, which start() reads
  scene.controls.push_back(
      {.tick = Tick{} + ticks_after(1.5), .body = {7}, .velocity_change_mps = {0, 0, 0.3}});
  const RunResult reused = run(scene, 2, earlier.history);
  EXPECT_EQ(reused.digest, run(scene, 2).digest);
  EXPECT_EQ(reused.history->chunks[1], second);
  EXPECT_EQ(earlier.history->chunks.size(), chunks);
}

TEST(Reuse, MemoryIsBounded) {
  // Goal: if a simulation's history would exceed its limit, the simulation continues without a
  // history. Method: set a small limit. Let simulated events exceed the limit, and let replayed
  // events exceed it. The simulation must return no history. If a recording was requested, it must
  // be complete.
  const Scene scene = balls_apart(20);
  SimulationOptions options;
  options.keep_history = true;
  options.history_bytes_max = 20'000;
  Simulation simulation = Simulation::start(scene, options).value();
  ASSERT_FALSE(simulation.run_until(Tick{} + ticks_after(1)));
  EXPECT_EQ(simulation.history(), nullptr);
  const RunResult whole = run(scene, 1);
  EXPECT_EQ(simulation.recording().digest(), whole.digest);

  Simulation replays = Simulation::start(scene, options, whole.history).value();
  ASSERT_FALSE(replays.run_until(Tick{} + ticks_after(1)));
  EXPECT_EQ(replays.history(), nullptr);
  EXPECT_EQ(replays.recording().digest(), whole.digest);
  Scene otherwise = scene;
  otherwise.bodies[3].start.pose.position_m.z() += 0.001;
  Simulation differs = Simulation::start(otherwise, options, whole.history).value();
  ASSERT_FALSE(differs.run_until(Tick{} + ticks_after(1)));
  EXPECT_EQ(differs.history(), nullptr);
  EXPECT_EQ(differs.recording().digest(), run(otherwise, 1).digest);

  options.record = false;
  Simulation forgets = Simulation::start(scene, options).value();
  ASSERT_FALSE(forgets.run_until(Tick{} + ticks_after(1)));
  EXPECT_EQ(forgets.history(), nullptr);
  EXPECT_EQ(forgets.recording().segment_count(), 0U);
}

/// Tick at which to cut a history: at an event, at a pair of events within a microsecond, at a
/// kick, or slightly later.
Tick cut_in(const History& history, Dice& dice) {
  Tick tick{};
  if (dice.one_in(3) && !history.scene.controls.empty()) {
    tick = history.scene.controls[dice.below(history.scene.controls.size())].tick;
  } else {
    const bool in_burst = dice.one_in(2);
    for (int attempt = 0; attempt < 64; ++attempt) {
      const HistoryChunk& chunk = *history.chunks[dice.below(history.chunks.size())];
      const auto index = dice.below(chunk.size());
      tick = chunk.event(index).key.tick;
      if (!in_burst) break;
      if (index + 1 < chunk.size() && chunk.event(index + 1).key.tick - tick < k_refractory) break;
    }
  }
  return dice.one_in(3) ? tick + static_cast<TickCount>(dice.below(2'000'000)) : tick;
}

TEST(Reuse, ItGoesOnBeyondTheHistory) {
  // Goal: a history that ends at any tick contains all state that a simulation needs to continue
  // from there. Method: cut histories of all kinds of scenes at an event or slightly later, and
  // continue each run. All bodies go live at the cut. Compare the recording with an uninterrupted
  // run.
  const std::uint64_t scenes = property::long_run() ? 2000 : property::of_tier(9, 32);
  for (const std::uint64_t n : property::cases(scenes)) {
    Subject subject = testing::subject_of(n);
    SCOPED_TRACE(subject.name);
    Dice dice(k_seed + 1, n);
    subject.speed_mps *= dice.one_in(2) ? 0.02 : 0.3;
    for (int kicks = 0; kicks < 6; ++kicks)
      testing::change_controls(subject.scene, subject, dice);
    const Tick end = Tick{} + ticks_after(0.8 * subject.duration_s);
    SimulationOptions options;
    options.keep_history = true;
    Simulation whole = Simulation::start(subject.scene, options).value();
    if (whole.run_until(end)) continue;
    const auto all = whole.history();
    for (int cut = 0; cut < 16; ++cut) {
      Tick last = cut_in(*all, dice);
      if (last > end) continue;
      Simulation earlier = Simulation::start(subject.scene, options).value();
      ASSERT_FALSE(earlier.run_until(last));
      Simulation goes_on =
          Simulation::start(subject.scene, random_way(dice), earlier.history()).value();
      ASSERT_FALSE(goes_on.run_until(end));
      ASSERT_EQ(goes_on.recording().digest(), whole.recording().digest())
          << "history up to " << last.value << ", "
          << first_difference(whole.recording(), goes_on.recording());
    }
  }
}

}  // namespace
}  // namespace sleight::physics
