// What is replayed makes no difference: simulations of scenes that differ in something, with the
// history of the one before, against simulations of everything.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

#include "tests/unit/worker/physics/simulator/proposals.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics {
namespace {

using testing::Dice;
using testing::Subject;

constexpr std::uint64_t k_seed = 20261121;
constexpr int k_steps = 20;

/// Chains of proposals, each of k_steps.
std::uint64_t chain_count() {
  return std::getenv("SLEIGHT_SOAK") != nullptr ? 100'000 / k_steps : 64;
}

SimulationOptions random_way(Dice& dice) {
  SimulationOptions options;
  options.tell = true;
  switch (dice.below(8)) {
    case 0:
      options.algorithm = Algorithm::synchronous;
      break;
    case 1:
      options.algorithm = Algorithm::all_pairs;
      break;
    default:
      break;
  }
  if (dice.one_in(6)) options.broad_phase = BroadPhaseKind::sweep_and_prune;
  const auto queue = dice.below(6);
  if (queue == 0) options.queue = QueueKind::heap;
  if (queue == 1) options.queue = QueueKind::calendar;
  return options;
}

::testing::AssertionResult same_state(const Simulation& a, const Simulation& b,
                                      std::size_t bodies) {
  for (std::uint32_t i = 0; i < bodies; ++i) {
    const BodyId body{i};
    if (a.started(body) != b.started(body))
      return ::testing::AssertionFailure() << "body " << i << " has started in one only";
    if (!a.started(body)) continue;
    const Tick now = a.now();
    const Pose p = a.pose(body, now);
    const Pose q = b.pose(body, now);
    const Twist v = a.twist(body, now);
    const Twist w = b.twist(body, now);
    if (p.position_m != q.position_m || p.orientation.coeffs() != q.orientation.coeffs() ||
        v.velocity_mps != w.velocity_mps || v.angular_velocity_radps != w.angular_velocity_radps ||
        a.mode(body) != b.mode(body))
      return ::testing::AssertionFailure() << "body " << i << " differs";
  }
  return ::testing::AssertionSuccess();
}

/// Where two recordings part.
std::string first_difference(const Recording& a, const Recording& b) {
  std::string found = "nowhere but at their ends";
  Tick first = k_never;
  for (std::uint32_t i = 0; i < a.bodies(); ++i) {
    const auto p = a.segments({i});
    const auto q = b.segments({i});
    for (std::size_t k = 0; k < std::max(p.size(), q.size()); ++k) {
      const bool same = k < p.size() && k < q.size() && p[k].cause == q[k].cause &&
                        same_bits(p[k].segment, q[k].segment);
      if (same) continue;
      const EventKey cause = k < p.size() ? p[k].cause : q[k].cause;
      if (cause.tick >= first) break;
      first = cause.tick;
      found = fmt::format("body {}, segment {} of {} and {}, tick {}, kind {}, {}, {}", i, k,
                          p.size(), q.size(), cause.tick.value, static_cast<int>(cause.kind),
                          cause.lower, cause.higher);
      break;
    }
  }
  return found;
}

struct Tally {
  std::uint64_t runs = 0;
  std::uint64_t failed = 0;
  std::uint64_t replayed = 0;   ///< events
  std::uint64_t simulated = 0;  ///< the same of those with a past
  std::uint64_t all = 0;        ///< of simulations of everything
};

std::uint64_t changes_of(const Counts& counts) {
  return counts.collisions + counts.static_collisions + counts.controls + counts.starts +
         counts.modes + counts.rest_decisions;
}

/// Proposals one after the other, each from the last one that was accepted.
void run_chain(const Subject& subject, Dice& dice, Tally& tally) {
  Scene accepted = subject.scene;
  std::shared_ptr<const History> past;
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
    auto whole = Simulation::start(scene, {});
    auto reused = Simulation::start(scene, way, past);
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
    if (past) {
      tally.replayed += simulation.counts().replayed;
      tally.simulated += changes_of(simulation.counts());
      tally.all += changes_of(expected.counts());
    }
    // A proposal that is rejected leaves the past as it is.
    if (!past || dice.one_in(2)) {
      past = simulation.history();
      ASSERT_NE(past, nullptr);
      accepted = std::move(scene);
    }
  }
}

TEST(Reuse, ReplayingMakesNoDifference) {
  // Goal: DESIGN section 3, reuse: the result equals a fresh simulation bit for bit. Method: random
  // scenes of every kind; in each, proposals one after the other (bodies that start elsewhere,
  // faster, later, not at all or again, static geometry that moves, kicks, other laws), some
  // accepted; each is simulated with the history of the last accepted one, in all ways, and whole.
  std::map<std::string, Tally> by_kind;
  const char* const one = std::getenv("SLEIGHT_REUSE_CHAIN");
  const std::uint64_t first = one != nullptr ? std::strtoull(one, nullptr, 10) : 0;
  const std::uint64_t last = one != nullptr ? first + 1 : chain_count();
  for (std::uint64_t n = first; n < last && !HasFatalFailure(); ++n) {
    const Subject subject = testing::subject_of(n);
    SCOPED_TRACE(fmt::format("seed {}, {}; to see it again: SLEIGHT_REUSE_CHAIN={}", k_seed,
                             subject.name, n));
    Dice dice(k_seed, n);
    run_chain(subject, dice, by_kind[subject.name.substr(0, subject.name.find(' '))]);
  }
  for (const auto& [kind, tally] : by_kind) {
    fmt::print("seed {}: {}: {} runs, {} failed; events: {} replayed, {} simulated, {} without\n",
               k_seed, kind, tally.runs, tally.failed, tally.replayed, tally.simulated, tally.all);
    if (one != nullptr) continue;
    EXPECT_GT(tally.replayed, tally.simulated / 50) << kind;
    EXPECT_LT(tally.failed, tally.runs / 2) << kind;
  }
}

/// Balls side by side on a floor, each at rest soon.
Scene balls_apart(std::uint32_t count) {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.contacts = ContactTable(1, {.restitution = 0.5, .friction = 0.3, .rolling_friction = 0.05});
  scene.slow = scenes::slow_contacts_of(0.02);
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  for (std::uint32_t i = 0; i < count; ++i) {
    scene.bodies.push_back({.name = {},
                            .shape = Sphere{.radius_m = 0.01},
                            .inertia = solid_ball_inertia(0.01, 0.01),
                            .start = {.pose = {.position_m = {0.05 * i, 0, 0.03}}, .twist = {}}});
  }
  return scene;
}

struct Told {
  std::uint64_t digest = 0;
  Counts counts;
  std::shared_ptr<const History> history;
};

Told run(const Scene& scene, double duration_s, std::shared_ptr<const History> past = nullptr,
         SimulationOptions options = {}) {
  options.tell = true;
  Simulation simulation = Simulation::start(scene, options, std::move(past)).value();
  const auto error = simulation.run_until(Tick{} + ticks_after(duration_s));
  EXPECT_FALSE(error) << error->message;
  return {simulation.recording().digest(), simulation.counts(), simulation.history()};
}

TEST(Reuse, AWrongHistoryMakesADifference) {
  // Goal: what is replayed is not simulated, so the property above can fail. Method: a history that
  // claims to be of a scene of which it isn't.
  const Scene before = balls_apart(3);
  Scene after = before;
  after.bodies[1].start.twist.velocity_mps.x() = 0.1;
  const Told told = run(before, 1);
  History wrong = *told.history;
  EXPECT_EQ(run(after, 1, told.history).digest, run(after, 1).digest);
  wrong.scene = after;
  EXPECT_EQ(run(after, 1, std::make_shared<const History>(wrong)).digest, told.digest);
  EXPECT_NE(told.digest, run(after, 1).digest);
}

TEST(Reuse, OnlyWhatDiffersIsSimulated) {
  // Goal: the point of it. Method: of balls apart one starts otherwise; the others are replayed
  // to the last event; of the same scene nothing at all is simulated.
  const Scene before = balls_apart(8);
  const Told told = run(before, 2);
  Scene after = before;
  after.bodies[5].start.pose.position_m.z() += 0.01;
  const Told reused = run(after, 2, told.history);
  EXPECT_EQ(reused.digest, run(after, 2).digest);
  EXPECT_GT(reused.counts.replayed, 7U);
  EXPECT_EQ(reused.counts.starts, 8U);
  const Counts alone = run(after, 2).counts;
  EXPECT_LT(reused.counts.static_collisions, alone.static_collisions / 4);
  EXPECT_EQ(run(before, 2, told.history).counts.events(), 0U);
}

TEST(Reuse, AKickTowardsWhatDiffersComesOnce) {
  // Goal: a kick that is replayed isn't done again by a body that goes live from it, as its way now
  // leads to a place that differs. Method: a ball is kicked to a wall that has moved.
  Scene before = balls_apart(2);
  before.planes.push_back({.name = "wall", .outside = {.normal = {0, -1, 0}, .offset_m = -0.2}});
  before.controls.push_back(
      {.tick = Tick{} + ticks_after(0.5), .body = {0}, .velocity_change_mps = {0, 2, 0.1}});
  const Told told = run(before, 1);
  Scene after = before;
  after.planes[1].outside.offset_m = -0.15;
  for (const Algorithm algorithm :
       {Algorithm::asynchronous, Algorithm::synchronous, Algorithm::all_pairs}) {
    SimulationOptions options;
    options.algorithm = algorithm;
    options.sample_every = 1 << 20;  // nothing is skipped
    EXPECT_EQ(run(after, 1, told.history, options).digest, run(after, 1).digest);
  }
}

/// A box of a half width about a place.
std::shared_ptr<const ConvexPolyhedron> block(const Vec3& centre_m, double half_m) {
  std::vector<Vec3> corners_m;
  for (int corner = 0; corner < 8; ++corner) {
    corners_m.push_back(centre_m + half_m * Vec3((corner & 1) != 0 ? 1 : -1,
                                                 (corner & 2) != 0 ? 1 : -1,
                                                 (corner & 4) != 0 ? 1 : -1));
  }
  return std::make_shared<const ConvexPolyhedron>(convex_hull(corners_m).value());
}

/// Balls and cubes above a floor, and a block far away from them.
Scene beside_a_block() {
  Scene scene = balls_apart(4);
  const Scene cubes = scenes::cube_drop(2, 1).scene;
  for (std::uint32_t i = 0; i < 2; ++i) {
    scene.bodies.push_back(cubes.bodies[i]);
    scene.bodies.back().start.pose.position_m = {0.05 * i, 0.1, 0.1};
  }
  scene.convexes.push_back({.name = "block", .polyhedron = block({1, 1, 1}, 0.01)});
  return scene;
}

TEST(Reuse, PlacesCountAsTheyWereAndAsTheyAre) {
  // Goal: who met something that is gone goes live, as well as who meets something that has come.
  // Method: a block under one body, and far away, in either order; balls and cubes.
  const Scene away = beside_a_block();
  for (std::uint32_t i = 0; i < away.bodies.size(); ++i) {
    Scene below = away;
    const Vec3 start_m = away.bodies[i].start.pose.position_m;
    below.convexes[0].polyhedron = block({start_m.x() + 0.003, start_m.y(), 0.003}, 0.005);
    const Told far = run(away, 1);
    const Told near = run(below, 1);
    EXPECT_NE(far.digest, near.digest);
    EXPECT_EQ(run(below, 1, far.history).digest, near.digest);
    const Told back = run(away, 1, near.history);
    EXPECT_EQ(back.digest, far.digest);
    EXPECT_GT(back.counts.replayed, 3U);
  }
}

TEST(Reuse, StartsSeeWhatDiffers) {
  // Goal: a start is no event of a past in which there was room, or none. Method: a body starts
  // late, deep inside of a block that wasn't there: it is an error. One that drew its place again
  // as a block was in its way takes its first one when that has gone, and the other way round.
  Scene away = beside_a_block();
  BodyDescription& late = away.bodies[1];
  late.start_tick = Tick{} + ticks_after(0.7);
  late.start.pose.position_m = {0.3, 0.3, 0.2};
  Scene around = away;
  around.convexes[0].polyhedron = block({0.3, 0.3, 0.2}, 0.1);
  const Told far = run(away, 1);
  Simulation fails = Simulation::start(around, {}, far.history).value();
  const auto error = fails.run_until(Tick{} + ticks_after(1));
  ASSERT_TRUE(error);
  EXPECT_NE(error->message.find("overlaps"), std::string::npos) << error->message;
  EXPECT_EQ(fails.now(), late.start_tick);

  for (Scene* scene : {&away, &around}) {
    scene->bodies[1].start_again = [](std::uint32_t attempt) -> StartState {
      return {.pose = {.position_m = {0.3, 0.3 + 0.05 * attempt, 0.2}}, .twist = {}};
    };
  }
  const Told free = run(away, 1);
  const Told drawn = run(around, 1);
  EXPECT_GT(drawn.counts.start_draws, 0U);
  EXPECT_EQ(run(around, 1, free.history).digest, drawn.digest);
  EXPECT_EQ(run(away, 1, drawn.history).digest, free.digest);

  // The same when another body is in the way.
  Scene alone = away;
  Scene two = away;
  two.bodies[0].start_tick = Tick{} + ticks_after(0.69);
  two.bodies[0].start.pose.position_m = {0.3, 0.3, 0.205};
  alone.bodies[0].start_tick = k_tick_max;
  const Told with = run(two, 1);
  const Told without = run(alone, 1);
  EXPECT_GT(with.counts.start_draws, 0U);
  EXPECT_EQ(run(two, 1, without.history).digest, with.digest);
  EXPECT_EQ(run(alone, 1, with.history).digest, without.digest);
}

TEST(Reuse, SleepersAreWokenByTheirOwnKind) {
  // Goal: replay.h, invariant 3. Method: a pyramid of balls in a tray of planes comes to rest; then
  // one after the other is kicked, late, or isn't there from the start; and the floor is lowered.
  Scene before = balls_apart(0);
  for (const double side : {-1.0, 1.0}) {
    for (const bool x : {true, false}) {
      const Vec3 normal = x ? Vec3(-side, 0, 0.5) : Vec3(0, -side, 0.5);
      const double size = std::sqrt(1.25);
      before.planes.push_back(
          {.name = "wall", .outside = {.normal = normal / size, .offset_m = -0.0212 / size}});
    }
  }
  const BodyDescription ball = balls_apart(1).bodies[0];
  for (std::uint32_t i = 0; i < 9; ++i) {
    BodyDescription body = ball;
    body.start.pose.position_m =
        i < 4   ? Vec3(0.022 * (i % 2) - 0.011, 0.022 * (i / 2) - 0.011, 0.03)
        : i < 8 ? Vec3(0.024 * (i % 2) - 0.012, 0.024 * (i / 2) - 0.06, 0.06)
                : Vec3(0.001, 0.002, 0.09);
    before.bodies.push_back(body);
  }
  const Told told = run(before, 4);
  std::uint64_t rests = told.counts.rests;
  EXPECT_GE(rests, 9U);
  const auto compare = [&](const Scene& after) {
    const Told whole = run(after, 4);
    EXPECT_EQ(run(after, 4, told.history).digest, whole.digest);
    SimulationOptions options;
    options.sample_every = 1 << 22;
    EXPECT_EQ(run(after, 4, told.history, options).digest, whole.digest);
  };
  for (std::uint32_t i = 0; i < 9; ++i) {
    for (const double when_s : {0.5, 1.0, 2.0, 3.9}) {
      for (const double speed_mps : {0.02, 0.2, 2.0}) {
        Scene kicked = before;
        kicked.controls.push_back({.tick = Tick{} + ticks_after(when_s),
                                   .body = {i},
                                   .velocity_change_mps = {0.1 * speed_mps, 0, speed_mps}});
        compare(kicked);
      }
    }
    Scene without = before;
    without.bodies[i].start_tick = k_tick_max;
    compare(without);
    without.bodies[i].start_tick = Tick{} + ticks_after(3);
    without.bodies[i].start.pose.position_m.z() = 0.2;
    compare(without);
  }
  // Who has woken without a blow, and left his place or not, is told of as well.
  for (std::uint32_t i = 0; i < 9; ++i) {
    Scene kicked = before;
    kicked.controls.push_back(
        {.tick = Tick{} + ticks_after(2), .body = {i}, .velocity_change_mps = {0.1, 0, 0.5}});
    const Told woken = run(kicked, 4);
    for (const double later_s : {0.001, 0.004, 0.02, 0.1}) {
      Scene twice = kicked;
      twice.controls.push_back({.tick = Tick{} + ticks_after(2 + later_s),
                                .body = {(i + 4) % 9},
                                .velocity_change_mps = {0, 0.02, 0.05}});
      EXPECT_EQ(run(twice, 4, woken.history).digest, run(twice, 4).digest);
    }
  }
  Scene lower = before;
  lower.planes[0].outside.offset_m = -0.001;
  compare(lower);
}

/// A body is dropped on another one, and when both are at rest a ball is shot at the lower one.
Scene dropped_on(std::uint64_t seed, double later_s, double shot_s) {
  Scene scene = scenes::cube_stack(2, seed).scene;
  scene.bodies[1].start_tick = Tick{} + ticks_after(later_s);
  constexpr double k_speed_mps = 4;
  constexpr double k_way_m = 0.2;
  BodyDescription shot = balls_apart(1).bodies[0];
  shot.inertia.mass_kg *= 5;
  shot.inertia.principal_kgm2 *= 5;
  shot.start_tick = Tick{} + ticks_after(shot_s);
  shot.start = {.pose = {.position_m = {-k_way_m, 0, 0.022}},
                .twist = {.velocity_mps = {k_speed_mps, 0, 0}}};
  scene.bodies.push_back(std::move(shot));
  return scene;
}

/// When a body first comes to rest.
Tick first_rest(const Recording& recording, BodyId body) {
  for (const auto& [segment, cause] : recording.segments(body)) {
    if (segment.mode == MotionMode::resting) return cause.tick;
  }
  return k_never;
}

TEST(Reuse, DecisionsAboutRestSeeWhoDiffers) {
  // Goal: replay.h, invariants 2 to 4, where two bodies have met shortly before only one of them
  // differs: one decides about rest and looks at the other, or rests on him. Method: a kick to
  // either of two cubes on one another, in one scene alone, some time before or after the upper
  // one's rest; whom it doesn't come to is simulated by what he was told, and must not be. Later
  // the lower one is hit, and wakes who rests on him.
  int compared = 0;
  const std::uint64_t seeds = std::getenv("SLEIGHT_SOAK") != nullptr ? 40 : 2;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    for (const double later_s : {0.0, 0.5}) {
      const double end_s = later_s + 0.6;
      const Scene plain = dropped_on(seed, later_s, later_s + 0.4);
      Simulation settled = Simulation::start(plain, {}).value();
      ASSERT_FALSE(settled.run_until(Tick{} + ticks_after(later_s + 0.4)));
      const Tick rest = first_rest(settled.recording(), {1});
      if (rest == k_never) continue;
      const Told without = run(plain, end_s);
      for (const double before_ms : {0.02, 0.1, 0.3, 0.7, 1.1, 1.7, 2.4, 3.1, 4.0, -1.0, -30.0}) {
        for (const std::uint32_t body : {0U, 1U}) {
          for (const Vec3& kick : {Vec3(0, 3, 1), Vec3(0, 0.5, 0)}) {
            Scene kicked = plain;
            kicked.controls.push_back({.tick = rest - ticks_after(1e-3 * before_ms),
                                       .body = {body},
                                       .velocity_change_mps = kick});
            const Told with = run(kicked, end_s);
            EXPECT_EQ(run(plain, end_s, with.history).digest, without.digest) << fmt::format(
                "seed {}, {}, body {} kicked {} ms before", seed, later_s, body, before_ms);
            EXPECT_EQ(run(kicked, end_s, without.history).digest, with.digest) << fmt::format(
                "seed {}, {}, body {} kicked {} ms before", seed, later_s, body, before_ms);
            ++compared;
          }
        }
      }
    }
  }
  EXPECT_GT(compared, 60);
}

TEST(Reuse, WhatIsTheSameIsShared) {
  // Goal: memory. Method: a kick late in a long fall; the histories have the same chunks before it.
  // A proposal that is not accepted leaves its past as it was.
  Scene scene = balls_apart(120);
  const Told told = run(scene, 2);
  const std::size_t chunks = told.history->chunks.size();
  ASSERT_GT(chunks, 3U);
  const auto second =
      told.history->chunks[1];  // the first one holds tick 0, which start() looks at
  scene.controls.push_back(
      {.tick = Tick{} + ticks_after(1.5), .body = {7}, .velocity_change_mps = {0, 0, 0.3}});
  const Told reused = run(scene, 2, told.history);
  EXPECT_EQ(reused.digest, run(scene, 2).digest);
  EXPECT_EQ(reused.history->chunks[1], second);
  EXPECT_EQ(told.history->chunks.size(), chunks);
}

TEST(Reuse, MemoryIsBounded) {
  // Goal: a simulation whose history would take too much goes on without. Method: a small limit;
  // the recording is whole, and there is no history.
  const Scene scene = balls_apart(20);
  SimulationOptions options;
  options.tell = true;
  options.history_bytes_max = 20'000;
  Simulation simulation = Simulation::start(scene, options).value();
  ASSERT_FALSE(simulation.run_until(Tick{} + ticks_after(1)));
  EXPECT_EQ(simulation.history(), nullptr);
  EXPECT_EQ(simulation.recording().digest(), run(scene, 1).digest);
}

TEST(Reuse, ItGoesOnBeyondThePast) {
  // Goal: at every event a history has all that goes on from there. Method: scenes of every kind,
  // with kicks, most of them slow; pasts that end right at an event, or somewhere; all bodies go
  // live there.
  const std::uint64_t scenes = std::getenv("SLEIGHT_SOAK") != nullptr ? 2000 : 32;
  for (std::uint64_t n = 0; n < scenes; ++n) {
    Subject subject = testing::subject_of(n);
    SCOPED_TRACE(fmt::format("seed {}, scene {}: {}", k_seed, n, subject.name));
    Dice dice(k_seed + 1, n);
    subject.speed_mps *= dice.one_in(2) ? 0.02 : 0.3;
    for (int kicks = 0; kicks < 6; ++kicks)
      testing::change_controls(subject.scene, subject, dice);
    const Tick end = Tick{} + ticks_after(0.8 * subject.duration_s);
    SimulationOptions options;
    options.tell = true;
    Simulation whole = Simulation::start(subject.scene, options).value();
    if (whole.run_until(end)) continue;
    const auto all = whole.history();
    for (int cut = 0; cut < 12; ++cut) {
      const auto& chunk = *all->chunks[dice.below(all->chunks.size())];
      Tick last = chunk.event(dice.below(chunk.size())).key.tick;
      if (dice.one_in(4)) last = last + static_cast<TickCount>(dice.below(5'000'000));
      if (last > end) continue;
      Simulation told = Simulation::start(subject.scene, options).value();
      ASSERT_FALSE(told.run_until(last));
      Simulation goes_on =
          Simulation::start(subject.scene, random_way(dice), told.history()).value();
      ASSERT_FALSE(goes_on.run_until(end));
      ASSERT_EQ(goes_on.recording().digest(), whole.recording().digest())
          << "past up to " << last.value << ", "
          << first_difference(whole.recording(), goes_on.recording());
    }
  }
}

}  // namespace
}  // namespace sleight::physics
