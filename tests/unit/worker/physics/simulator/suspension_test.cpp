// Bodies that are left alone: engine_suspension.h.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "tests/unit/worker/physics/simulator/confined_scenes.h"

namespace sleight::physics {
namespace {

using testing::between_planes;
using testing::in_a_cup;

/// Scenes of the ordinary run, and of the long one (SLEIGHT_SOAK=1).
std::uint64_t scene_count() {
  return std::getenv("SLEIGHT_SOAK") != nullptr ? 6000 : 60;
}

using Holds = std::optional<Box> (*)(const Scene&, BodyId, const Segment&);

struct ConfinedScene {
  Scene scene;
  Holds holds = nullptr;
  Tick end{};
};

/// Marbles between leaning walls, alone or a few, and balls in cups. Some marbles start later. At
/// the end every body is touched, so that all catch up.
ConfinedScene confined_scene(std::uint64_t n) {
  ConfinedScene confined;
  random::Stream stream = scenes::stream_of_scene(n, 4);
  double duration_s = 2;
  if (n % 3 == 0) {
    confined.scene = scenes::marbles(static_cast<std::uint32_t>(1 + n / 3 % 5), n + 1).scene;
    for (std::size_t i = 1; i < confined.scene.bodies.size(); ++i)
      confined.scene.bodies[i].start_tick = Tick{} + ticks_after(stream.uniform());
    confined.holds = between_planes;
  } else {
    confined.scene = testing::cups(n - n / 3);
    confined.holds = in_a_cup;
  }
  duration_s *= 1 + 0.1 * stream.uniform();
  confined.end = Tick{} + ticks_after(duration_s);
  for (std::uint32_t body = 0; body < confined.scene.bodies.size(); ++body)
    confined.scene.controls.push_back({.tick = confined.end, .body = {body}});
  return confined;
}

struct Way {
  BroadPhaseKind broad_phase;
  QueueKind queue;
};
constexpr std::array<Way, 6> k_ways{{{BroadPhaseKind::hierarchical_grid, QueueKind::tournament},
                                     {BroadPhaseKind::hierarchical_grid, QueueKind::heap},
                                     {BroadPhaseKind::hierarchical_grid, QueueKind::calendar},
                                     {BroadPhaseKind::sweep_and_prune, QueueKind::tournament},
                                     {BroadPhaseKind::sweep_and_prune, QueueKind::heap},
                                     {BroadPhaseKind::sweep_and_prune, QueueKind::calendar}}};

/// Where each body was left alone last, and since when.
struct Confined {
  Tick since{};
  Box box;
};

/// A simulation that leaves bodies alone. REQUIRES: scene and `last` stay where they are.
Simulation suspending(const ConfinedScene& confined, Way way, std::vector<Confined>& last) {
  last.assign(confined.scene.bodies.size(), {});
  SimulationOptions options;
  options.broad_phase = way.broad_phase;
  options.queue = way.queue;
  options.record = false;
  options.confinement = [&confined, &last](BodyId body,
                                           const Segment& segment) -> std::optional<Box> {
    // What happens at the end is looked at whole.
    if (segment.flight.begin >= confined.end) return std::nullopt;
    const auto box = confined.holds(confined.scene, body, segment);
    if (box) last[body.value] = {.since = segment.flight.begin, .box = *box};
    return box;
  };
  return Simulation::start(confined.scene, options).value();
}

bool box_holds(const Box& box, const Vec3& centre_m, double reach_m) {
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    if (centre_m[i] - reach_m < double{box.low_m[axis]} ||
        centre_m[i] + reach_m > double{box.high_m[axis]})
      return false;
  }
  return true;
}

/// That a body was in its box ever since it was left alone.
void expect_stayed(const Simulation& whole, const Scene& scene, BodyId body, const Confined& last) {
  const double reach_m = std::get<Sphere>(scene.bodies[body.value].shape).radius_m + k_touch_m;
  const auto entries = whole.recording().segments(body);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const FreeFlight& flight = entries[i].segment.flight;
    const Tick until = i + 1 < entries.size() ? entries[i + 1].segment.flight.begin : whole.now();
    if (flight.begin < last.since) continue;
    const TickCount top = ticks_before(std::max(0.0, flight.velocity_mps.z() / 9.81));
    for (const Tick tick : {flight.begin, std::min(until, flight.begin + top), until})
      EXPECT_TRUE(box_holds(last.box, position_at(flight, tick), reach_m));
  }
}

/// What two simulations of a scene say of the present. How many bodies are left alone.
std::uint32_t expect_same_present(const Simulation& whole, const Simulation& tried,
                                  const Scene& scene, std::span<const Confined> last) {
  std::uint32_t alone = 0;
  EXPECT_EQ(whole.now(), tried.now());
  for (std::uint32_t i = 0; i < scene.bodies.size(); ++i) {
    const BodyId body{i};
    EXPECT_EQ(whole.started(body), tried.started(body));
    EXPECT_FALSE(whole.is_suspended(body));
    if (!whole.started(body)) continue;
    if (tried.is_suspended(body)) {
      ++alone;
      EXPECT_NE(tried.mode(body), MotionMode::resting);
      expect_stayed(whole, scene, body, last[i]);
      continue;
    }
    const Tick now = whole.now();
    EXPECT_EQ(whole.mode(body), tried.mode(body)) << "body " << i;
    EXPECT_EQ(whole.pose(body, now).position_m, tried.pose(body, now).position_m) << "body " << i;
    EXPECT_EQ(whole.pose(body, now).orientation, tried.pose(body, now).orientation);
    EXPECT_EQ(whole.twist(body, now).velocity_mps, tried.twist(body, now).velocity_mps);
    EXPECT_EQ(whole.twist(body, now).angular_velocity_radps,
              tried.twist(body, now).angular_velocity_radps);
  }
  EXPECT_EQ(whole.counts().collisions, tried.counts().collisions);
  EXPECT_EQ(whole.counts().starts, tried.counts().starts);
  EXPECT_EQ(whole.counts().start_draws, tried.counts().start_draws);
  return alone;
}

/// All is made up for by the end.
void expect_same_counts(const Counts& whole, const Counts& tried) {
  EXPECT_EQ(whole.collisions, tried.collisions);
  EXPECT_EQ(whole.static_collisions, tried.static_collisions);
  EXPECT_EQ(whole.modes, tried.modes);
  EXPECT_EQ(whole.rests, tried.rests);
  EXPECT_EQ(whole.controls, tried.controls);
}

TEST(Suspension, ChangesNothingThatIsAskedFor) {
  // Goal: bodies that are left alone were in their boxes all the time, the others move as ever, bit
  // for bit, and when all have caught up all is the same; for every broad phase and queue, and run
  // in one go or in portions. Method: random scenes beside the same ones without suspension, at
  // random ticks; at the end each body gets a push of nothing.
  std::uint64_t suspensions = 0;
  std::uint64_t with_some = 0;
  std::uint64_t alone_seen = 0;
  for (std::uint64_t n = 0; n < scene_count(); ++n) {
    const ConfinedScene confined = confined_scene(n);
    random::Stream stream = scenes::stream_of_scene(n, 5);
    for (std::size_t w = 0; w < k_ways.size(); ++w) {
      SCOPED_TRACE(::testing::Message() << "scene " << n << ", way " << w);
      Simulation whole = Simulation::start(confined.scene, {}).value();
      std::vector<Confined> last;
      Simulation tried = suspending(confined, k_ways[w], last);
      // The first way in one go.
      std::uint32_t alone = 0;
      bool failed = false;
      while (whole.now() < confined.end) {
        const TickCount span =
            w == 0 ? confined.end - Tick{}
                   : 1 + static_cast<TickCount>(0.4 * stream.uniform() *
                                                static_cast<double>(confined.end.value));
        const Tick next = std::min(confined.end, whole.now() + span);
        const auto error = whole.run_until(next);
        const auto same_error = tried.run_until(next);
        ASSERT_EQ(error ? error->message : "", same_error ? same_error->message : "");
        failed = error.has_value();  // a marble starts where another one is
        if (failed) break;
        alone = expect_same_present(whole, tried, confined.scene, last);
        alone_seen += alone;
        if (HasFailure()) return;
      }
      if (failed) continue;
      EXPECT_EQ(alone, 0U);
      expect_same_counts(whole.counts(), tried.counts());
      suspensions += tried.counts().suspensions;
      with_some += tried.counts().suspensions > 0 ? 1 : 0;
      if (HasFailure()) return;
    }
  }
  std::printf("%llu suspensions in %llu of %llu runs, seen %llu times\n",
              static_cast<unsigned long long>(suspensions),
              static_cast<unsigned long long>(with_some),
              static_cast<unsigned long long>(scene_count() * k_ways.size()),
              static_cast<unsigned long long>(alone_seen));
  EXPECT_GT(suspensions, 10 * scene_count());
  EXPECT_GT(with_some, 4 * scene_count());
  EXPECT_GT(alone_seen, 10 * scene_count());
}

// ---- one ball in a cup --------------------------------------------------------------------------

/// A ball that bounces for ever in the first cup, and what else a test adds.
ConfinedScene bouncing_ball() {
  ConfinedScene confined{.scene = testing::empty_cups(), .holds = in_a_cup};
  confined.scene.slow = {};
  confined.scene.contacts = ContactTable(1, {.restitution = 1});
  confined.scene.bodies.push_back(testing::cup_ball(0.008, {-0.049, -0.052, 0.017}));
  confined.scene.bodies[0].start.twist.velocity_mps = {0.1, -0.07, 0};
  confined.end = Tick{} + ticks_after(5.0);
  return confined;
}

struct Beside {
  explicit Beside(const ConfinedScene& scene)
      : confined(scene), whole(Simulation::start(scene.scene, {}).value()) {}
  const ConfinedScene& confined;
  Simulation whole;
  std::vector<Confined> last;
  Simulation tried = suspending(confined, k_ways[0], last);

  void run_to(double s) {
    const Tick end = Tick{} + ticks_after(s);
    for (Simulation* simulation : {&whole, &tried}) {
      const auto error = simulation->run_until(end);
      ASSERT_FALSE(error) << error->message;
    }
    expect_same_present(whole, tried, confined.scene, last);
  }
};

TEST(Suspension, SparesEventsOfABodyThatIsAlone) {
  // Goal: a ball that can't leave its cup takes no more events. Method: the numbers of collisions
  // with the cup after two times.
  const ConfinedScene confined = bouncing_ball();
  Beside run(confined);
  run.run_to(1);
  ASSERT_TRUE(run.tried.is_suspended({0}));
  const std::uint64_t before = run.tried.counts().events();
  run.run_to(4);
  EXPECT_TRUE(run.tried.is_suspended({0}));
  EXPECT_EQ(run.tried.counts().events(), before);
  EXPECT_EQ(run.tried.counts().suspensions, 1U);
  EXPECT_GT(run.whole.counts().static_collisions, before + 50);
}

TEST(Suspension, ABallThatComesNearResumesIt) {
  // Goal: what comes near finds the ball where it should be by then, and not where itself was
  // never before. Method: a second ball starts above the cup after a second, in a later portion of
  // the run, and hits it; with slow contacts and without.
  for (const SlowContacts& slow : {SlowContacts{}, slow_contacts_of(0.01, 9.81)}) {
    ConfinedScene confined = bouncing_ball();
    confined.scene.slow = slow;
    confined.scene.bodies.push_back(testing::cup_ball(0.008, {-0.05, -0.05, 0.1}));
    confined.scene.bodies[1].start_tick = Tick{} + ticks_after(1.0);
    Beside run(confined);
    run.run_to(0.99);
    ASSERT_TRUE(run.tried.is_suspended({0}));
    run.run_to(1.5);
    EXPECT_GT(run.tried.counts().collisions, 0U);
    EXPECT_FALSE(run.tried.is_suspended({0}));
    run.run_to(3);
  }
}

TEST(Suspension, AStartNextToItResumesIt) {
  // Goal: a body that starts in the box has room there, or not, as the ball is by then. Method: a
  // second ball starts in the cup, at one random place after the other until there is room.
  std::uint64_t draws = 0;
  for (std::uint64_t n = 0; n < 100; ++n) {
    SCOPED_TRACE(n);
    ConfinedScene confined = bouncing_ball();
    const auto place = [n](std::uint32_t attempt) {
      random::Stream stream = scenes::stream_of_scene(n, 1000 + attempt);
      StartState start;
      start.pose.position_m =
          Vec3(-0.05, -0.05, 0.016) + scenes::vector_between(stream, -0.0065, 0.0065);
      return start;
    };
    BodyDescription second = testing::cup_ball(0.005, Vec3::Zero());
    second.start = place(0);
    second.start_again = place;
    second.start_tick = Tick{} + ticks_after(1.0);
    confined.scene.bodies.push_back(std::move(second));
    Beside run(confined);
    run.run_to(0.99);
    ASSERT_TRUE(run.tried.is_suspended({0}));
    run.run_to(1.1);
    EXPECT_FALSE(run.tried.is_suspended({0}));
    draws += run.tried.counts().start_draws;
    if (HasFailure()) return;
  }
  EXPECT_GT(draws, 10U);
}

TEST(Suspension, APushResumesIt) {
  // Goal: a control finds the ball where it should be. Method: pushes that leave it in its cup, and
  // one that throws it out; pushes of another ball, far away, leave it alone.
  ConfinedScene confined = bouncing_ball();
  confined.scene.bodies.push_back(testing::cup_ball(0.006, {0.05, 0.05, 0.0101}));
  const auto push = [&](double s, std::uint32_t body, const Vec3& change_mps) {
    confined.scene.controls.push_back(
        {.tick = Tick{} + ticks_after(s), .body = {body}, .velocity_change_mps = change_mps});
  };
  push(1.0, 1, {0.01, 0.02, 0});
  push(2.0, 0, {0.01, 0, 0});
  push(3.0, 0, {0, 0, 1.5});
  Beside run(confined);
  run.run_to(0.9);
  EXPECT_TRUE(run.tried.is_suspended({0}));
  EXPECT_TRUE(run.tried.is_suspended({1}));
  const std::uint64_t before = run.tried.counts().suspensions;
  run.run_to(1.5);
  EXPECT_TRUE(run.tried.is_suspended({0}));
  EXPECT_EQ(run.tried.counts().suspensions, before + 1);
  run.run_to(2.5);
  EXPECT_TRUE(run.tried.is_suspended({0}));
  EXPECT_EQ(run.tried.counts().suspensions, before + 2);
  run.run_to(3.1);
  EXPECT_FALSE(run.tried.is_suspended({0}));
  EXPECT_GT(run.tried.pose({0}, run.tried.now()).position_m.z(), 0.05);
  run.run_to(5);
}

TEST(Suspension, TwoInACupAreNotLeftAlone) {
  // Goal: nothing is left alone that another body is near. Method: two balls in one cup.
  ConfinedScene confined = bouncing_ball();
  confined.scene.bodies.push_back(testing::cup_ball(0.005, {-0.038, -0.037, 0.0101}));
  Beside run(confined);
  for (int i = 1; i <= 20; ++i) {
    run.run_to(0.1 * i);
    EXPECT_FALSE(run.tried.is_suspended({0}) && run.tried.is_suspended({1}));
  }
  EXPECT_GT(run.tried.counts().collisions, 0U);
}

}  // namespace
}  // namespace sleight::physics
