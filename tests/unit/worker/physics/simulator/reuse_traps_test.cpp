// Cases in which reuse could go wrong: kicks, places, starts, sleeping bodies and decisions about
// rest.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <vector>

#include "tests/scenes/shared/scenes.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/simulator/reuse_runs.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics {
namespace {

using testing::balls_apart;
using testing::run;
using testing::RunResult;

TEST(ReuseTraps, AKickTowardsWhatDiffersComesOnce) {
  // Goal: if a replayed kick sends a body towards a changed place, the body goes live, and the kick
  // isn't applied a second time. Method: kick a ball towards a wall that has moved.
  Scene before = balls_apart(2);
  before.planes.push_back({.name = "wall", .outside = {.normal = {0, -1, 0}, .offset_m = -0.2}});
  before.controls.push_back(
      {.tick = Tick{} + ticks_after(0.5), .body = {0}, .velocity_change_mps = {0, 2, 0.1}});
  const RunResult earlier = run(before, 1);
  Scene after = before;
  after.planes[1].outside.offset_m = -0.15;
  for (const Algorithm algorithm :
       {Algorithm::asynchronous, Algorithm::synchronous, Algorithm::all_pairs}) {
    SimulationOptions options;
    options.algorithm = algorithm;
    options.sample_every = 1 << 20;  // nothing is skipped
    EXPECT_EQ(run(after, 1, earlier.history, options).digest, run(after, 1).digest);
  }
}

TEST(ReuseTraps, KicksAtOneTickComeInTheirOrder) {
  // Goal: kicks at one tick happen in the order of the scene's list of controls. The order of the
  // bodies may differ. Method: kick the body with the highest id first. The kicked body starts
  // differently in the second scene, or never starts in either scene.
  Scene before = balls_apart(6);
  before.planes.push_back({.name = "wall", .outside = {.normal = {0, -1, 0}, .offset_m = -0.2}});
  for (const std::uint32_t body : {5U, 2U, 4U, 1U}) {
    before.controls.push_back({.tick = Tick{} + ticks_after(0.5),
                               .body = {body},
                               .velocity_change_mps = {0, 2, 0.1 * body}});
  }
  for (const bool never : {false, true}) {
    if (never) before.bodies[5].start_tick = k_tick_max;
    const RunResult earlier = run(before, 1);
    Scene after = before;
    after.bodies[never ? 0 : 5].start.pose.position_m.z() += 0.001;
    EXPECT_EQ(run(after, 1, earlier.history).digest, run(after, 1).digest);
    after.planes[1].outside.offset_m = -0.15;
    EXPECT_EQ(run(after, 1, earlier.history).digest, run(after, 1).digest);
    after.controls.pop_back();
    EXPECT_EQ(run(after, 1, earlier.history).digest, run(after, 1).digest);
    std::swap(after.controls[0], after.controls[1]);
    EXPECT_EQ(run(after, 1, earlier.history).digest, run(after, 1).digest);
  }
}

/// A cube with half side `half_m` about a centre.
std::shared_ptr<const ConvexPolyhedron> block(const Vec3& centre_m, double half_m) {
  std::vector<Vec3> corners_m;
  for (int corner = 0; corner < 8; ++corner) {
    corners_m.push_back(centre_m + half_m * Vec3((corner & 1) != 0 ? 1 : -1,
                                                 (corner & 2) != 0 ? 1 : -1,
                                                 (corner & 4) != 0 ? 1 : -1));
  }
  return std::make_shared<const ConvexPolyhedron>(convex_hull(corners_m).value());
}

/// Balls or cubes above a floor, and a distant block.
Scene beside_a_block(bool balls) {
  Scene scene = balls_apart(4);
  const Scene cubes = scenes::cube_drop(4, 1).scene;
  if (!balls) scene.bodies = cubes.bodies;
  scene.convexes.push_back({.name = "block", .polyhedron = block({1, 1, 1}, 0.01)});
  return scene;
}

TEST(ReuseTraps, PlacesCountAsTheyWereAndAsTheyAre) {
  // Goal: if a replayed body met something that has been removed, or meets something new, the body
  // goes live. Method: simulate two scenes of balls and cubes. In one scene, a block is under a
  // body; in the other scene, the block is far away. Use the history of each scene to simulate the
  // other scene.
  for (const bool balls : {true, false}) {
    const Scene away = beside_a_block(balls);
    for (std::uint32_t i = 0; i < away.bodies.size(); ++i) {
      Scene below = away;
      const Vec3 start_m = away.bodies[i].start.pose.position_m;
      below.convexes[0].polyhedron = block({start_m.x() + 0.003, start_m.y(), 0.003}, 0.005);
      const RunResult far = run(away, 1);
      const RunResult near = run(below, 1);
      EXPECT_NE(far.digest, near.digest);
      EXPECT_EQ(run(below, 1, far.history).digest, near.digest);
      const RunResult back = run(away, 1, near.history);
      EXPECT_EQ(back.digest, far.digest);
      EXPECT_GT(back.counts.replayed, 3U);
    }
  }
}

TEST(ReuseTraps, StartsSeeWhatDiffers) {
  // Goal: a start isn't replayed if its surroundings have changed. Method: start a body late inside
  // a new block. The start must give an error. Also simulate a body that must draw its place again
  // because of a block. Simulate the same body without the block. Use the history of each scene to
  // simulate the other scene.
  Scene away = beside_a_block(true);
  BodyDescription& late = away.bodies[1];
  late.start_tick = Tick{} + ticks_after(0.7);
  late.start.pose.position_m = {0.3, 0.3, 0.2};
  Scene around = away;
  around.convexes[0].polyhedron = block({0.3, 0.3, 0.2}, 0.1);
  const RunResult far = run(away, 1);
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
  const RunResult free = run(away, 1);
  const RunResult drawn = run(around, 1);
  EXPECT_GT(drawn.counts.start_draws, 0U);
  EXPECT_EQ(run(around, 1, free.history).digest, drawn.digest);
  EXPECT_EQ(run(away, 1, drawn.history).digest, free.digest);

  // Another body is in the way of the start.
  Scene alone = away;
  Scene two = away;
  two.bodies[0].start_tick = Tick{} + ticks_after(0.69);
  two.bodies[0].start.pose.position_m = {0.3, 0.3, 0.205};
  alone.bodies[0].start_tick = k_tick_max;
  const RunResult with = run(two, 1);
  const RunResult without = run(alone, 1);
  EXPECT_GT(with.counts.start_draws, 0U);
  EXPECT_EQ(run(two, 1, without.history).digest, with.digest);
  EXPECT_EQ(run(alone, 1, with.history).digest, without.digest);
}

TEST(ReuseTraps, SleepersAreWokenByTheirOwnKind) {
  // Goal: waking never spreads to replayed bodies (replay.h, invariant 3). Method: let a pyramid of
  // balls come to rest in a tray of planes. In the changed scenes, kick a ball, start a ball late
  // or never, or lower the floor.
  Scene before = balls_apart(0);
  // With friction below 0.53 the pyramid spreads for a long time.
  before.contacts =
      ContactTable(1, {.restitution = 0.5, .friction = 0.7, .rolling_friction = 0.05});
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
  const RunResult earlier = run(before, 4);
  std::uint64_t rests = earlier.counts.rests;
  EXPECT_GE(rests, 9U);
  const auto compare = [&](const Scene& after) {
    const RunResult whole = run(after, 4);
    EXPECT_EQ(run(after, 4, earlier.history).digest, whole.digest);
    SimulationOptions options;
    options.sample_every = 1 << 22;
    EXPECT_EQ(run(after, 4, earlier.history, options).digest, whole.digest);
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
  // The history also stores which bodies woke without a blow, and whether they left their places.
  for (std::uint32_t i = 0; i < 9; ++i) {
    Scene kicked = before;
    kicked.controls.push_back(
        {.tick = Tick{} + ticks_after(2), .body = {i}, .velocity_change_mps = {0.1, 0, 0.5}});
    const RunResult woken = run(kicked, 4);
    for (const double later_s : {0.0, 1e-6, 1e-4, 5e-4, 2e-3}) {
      const RunResult up_to_then = run(kicked, 2 + later_s);
      EXPECT_EQ(run(kicked, 4, up_to_then.history).digest, woken.digest);
    }
    for (const double later_s : {0.001, 0.004, 0.02, 0.1}) {
      Scene twice = kicked;
      twice.controls.push_back({.tick = Tick{} + ticks_after(2 + later_s),
                                .body = {(i + 4) % 9},
                                .velocity_change_mps = {0, 0.02, 0.05}});
      EXPECT_EQ(run(twice, 4, woken.history).digest, run(twice, 4).digest);
    }
    // In the history, a kick hits a replayed body on which a live body rests.
    Scene otherwise = kicked;
    otherwise.bodies[8].start.twist.velocity_mps.x() = 0.05;
    EXPECT_EQ(run(otherwise, 4, woken.history).digest, run(otherwise, 4).digest);
  }
  Scene lower = before;
  lower.planes[0].outside.offset_m = -0.001;
  compare(lower);
}

/// Drops a body on another. When both rest, shoots a ball at the lower body.
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

Tick first_rest(const Recording& recording, BodyId body) {
  for (const auto& [segment, cause] : recording.segments(body)) {
    if (segment.mode == MotionMode::resting) return cause.tick;
  }
  return k_never;
}

TEST(ReuseTraps, DecisionsAboutRestSeeWhoDiffers) {
  // Goal: replay is right even if a body changes just before or after another body comes to rest on
  // it (replay.h, invariants 2 to 4). Method: in one of two scenes, kick either of two stacked
  // cubes shortly before or after the upper cube comes to rest. The other cube must go live too.
  // Later, a hit on the lower cube wakes the upper cube.
  int compared = 0;
  const std::uint64_t seeds = property::long_run() ? 40 : 2;
  for (const std::uint64_t seed : property::seeds(seeds)) {
    for (const double later_s : {0.0, 0.5}) {
      const double end_s = later_s + 0.6;
      const Scene plain = dropped_on(seed, later_s, later_s + 0.4);
      Simulation settled = Simulation::start(plain, {}).value();
      ASSERT_FALSE(settled.run_until(Tick{} + ticks_after(later_s + 0.4)));
      const Tick rest = first_rest(settled.recording(), {1});
      if (rest == k_never) continue;
      const RunResult without = run(plain, end_s);
      // After a slow kick, the body only waits again until it may rest. The history ends right at
      // the kick.
      for (const double before_ms : {0.5, 1.5, 2.5, 3.5}) {
        Scene nudged = plain;
        const Tick tick = rest - ticks_after(1e-3 * before_ms);
        nudged.controls.push_back(
            {.tick = tick, .body = {1}, .velocity_change_mps = {0, 0.003, 0.003}});
        const RunResult up_to_then = run(nudged, seconds(tick - Tick{}));
        EXPECT_EQ(run(nudged, end_s, up_to_then.history).digest, run(nudged, end_s).digest);
      }
      for (const double before_ms : {0.02, 0.1, 0.3, 0.7, 1.1, 1.7, 2.4, 3.1, 4.0, -1.0, -30.0}) {
        for (const std::uint32_t body : {0U, 1U}) {
          for (const Vec3& kick : {Vec3(0, 3, 1), Vec3(0, 0.5, 0)}) {
            Scene kicked = plain;
            kicked.controls.push_back({.tick = rest - ticks_after(1e-3 * before_ms),
                                       .body = {body},
                                       .velocity_change_mps = kick});
            const RunResult with = run(kicked, end_s);
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
  if (!property::all_cases()) return;
  EXPECT_GT(compared, 60);
}

TEST(ReuseTraps, AKickIsForWhoIsThereNow) {
  // Goal: if a kick in the history woke a body that is no longer at rest, the kick is simulated,
  // not replayed. Method: kick a cube on which another cube rests. In the other scene, a ball has
  // just hit the overhanging part of the upper cube from below.
  Scene after = scenes::cube_stack(2, 1).scene;
  after.bodies[0].start.pose.position_m = {0, 0, 0.0105};
  after.bodies[1].start.pose.position_m = {0.0085, 0, 0.031};
  BodyDescription ball = balls_apart(1).bodies[0];
  ball.shape = Sphere{.radius_m = 0.003};
  ball.inertia = solid_ball_inertia(0.01, 0.003);
  ball.start_tick = Tick{} + ticks_after(0.5);
  ball.start = {.pose = {.position_m = {0.0135, 0, 0.004}}, .twist = {.velocity_mps = {0, 0, 3}}};
  after.bodies.push_back(ball);
  Simulation hit = Simulation::start(after, {}).value();
  ASSERT_FALSE(hit.run_until(Tick{} + ticks_after(0.51)));
  const auto segments = hit.recording().segments({1});
  const auto woken = std::ranges::find_if(segments, [](const Recording::Entry& entry) {
    return entry.cause.lower == 1 && entry.cause.higher == 2;
  });
  ASSERT_NE(woken, segments.end());
  ASSERT_EQ((woken - 1)->segment.mode, MotionMode::resting);
  after.controls.push_back(
      {.tick = woken->cause.tick + 10'000, .body = {0}, .velocity_change_mps = {0, 1, 0}});
  Scene before = after;
  before.bodies[2].start_tick = k_tick_max;
  const RunResult earlier = run(before, 1);
  const RunResult pushed = run(after, 1);
  EXPECT_EQ(run(after, 1, earlier.history).digest, pushed.digest);
  EXPECT_EQ(run(before, 1, pushed.history).digest, earlier.digest);
}

}  // namespace
}  // namespace sleight::physics
