// What is replayed makes no difference: simulations of scenes that differ in some balls, with the
// stories of the one before, against simulations of everything.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "common/random/distributions.h"
#include "common/random/stream.h"
#include "tests/unit/worker/physics/marbles/equal_marbles.h"
#include "worker/physics/marbles/marbles.h"
#include "worker/physics/scenes/scenes.h"

namespace sleight::physics {
namespace {

constexpr std::uint64_t k_seed = 20261121;

std::uint64_t scene_count() {
  return std::getenv("SLEIGHT_SOAK") != nullptr ? 20'000 : 300;
}

struct Dice {
  explicit Dice(std::uint64_t index)
      : stream({.seed = k_seed, .purpose = random::Purpose::prior}, index) {}
  std::uint64_t below(std::uint64_t count) {
    return random::UniformInteger{.count = count}.draw(stream);
  }
  double within(double half) { return random::Uniform{.low = -half, .high = half}.draw(stream); }
  random::Stream stream;
};

::testing::AssertionResult same_end(const Marbles& a, const Marbles& b) {
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    const BodyId ball{i};
    if (a.started(ball) != b.started(ball))
      return ::testing::AssertionFailure() << "ball " << i << " has started in one only";
    if (!a.started(ball)) continue;
    const bool same = a.mode(ball) == b.mode(ball) && a.position_m(ball) == b.position_m(ball) &&
                      a.twist(ball).velocity_mps == b.twist(ball).velocity_mps &&
                      a.twist(ball).angular_velocity_radps == b.twist(ball).angular_velocity_radps;
    if (!same) return ::testing::AssertionFailure() << "ball " << i << " differs";
  }
  return ::testing::AssertionSuccess();
}

struct Tally {
  std::uint64_t runs = 0;
  std::uint64_t voided = 0;
  std::uint64_t failed = 0;
  std::uint64_t work = 0;
  std::uint64_t work_of_all = 0;
  std::uint64_t replayed_to_the_end = 0;
};

TEST(Stories, ReplayingMakesNoDifference) {
  // Goal: invariant 4, bit for bit, in heaps that rest and wake as in sparse falls. Method: random
  // scenes; in each a dozen changes one after the other (balls that start elsewhere, faster, or not
  // at all), looked at in between; each is simulated with the stories of the one before, and whole.
  Tally tally;
  for (std::uint64_t index = 0; index < scene_count(); ++index) {
    Dice dice(index);
    const auto balls = static_cast<std::uint32_t>(1 + dice.below(14));
    const TickCount intervals[] = {0, 20'000'000, 100'000'000, 300'000'000};
    scenes::Setting setting = testing::equal_marbles(balls, index, intervals[dice.below(4)]);
    Scene scene = setting.scene;
    const Scene at_first = scene;
    const StaticGeometry statics(scene);
    const double radius_m = std::get<Sphere>(scene.bodies[0].shape).radius_m;
    const NearFeatures near(statics, radius_m);
    const Tick last{scene.bodies.back().start_tick.value};
    MarbleStories stories(balls);
    for (int step = 0; step < 12; ++step) {
      SCOPED_TRACE(fmt::format("seed {}, scene {}, step {}", k_seed, index, step));
      const Tick end = last + ticks_after(0.4 * static_cast<double>(1 + dice.below(8)));
      Marbles whole;
      whole.start(scene, near, end);
      Marbles marbles;
      marbles.start(scene, near, end, {}, UINT64_MAX,
                    {.stories = &stories, .changes = {}, .records = true});
      const auto expected = whole.run_until(end);
      const int looks = static_cast<int>(dice.below(3));
      for (int look = 1; look <= looks; ++look) {
        (void)marbles.run_until(Tick{end.value * look / 3});
        if (dice.below(4) == 0)
          marbles.stop_replay({static_cast<std::uint32_t>(dice.below(balls))});
      }
      const auto error = marbles.run_until(end);
      ++tally.runs;
      if (expected) {
        ++tally.failed;
        EXPECT_TRUE(error || marbles.is_replay_void());
      }
      if (marbles.is_replay_void() || error) {
        if (!expected) ++tally.voided;
        ASSERT_TRUE(expected || marbles.is_replay_void());
        stories.assign(balls, nullptr);
      } else {
        tally.work += marbles.counts().work();
        tally.work_of_all += whole.counts().work();
        auto next = marbles.stories();
        for (std::uint32_t ball = 0; ball < balls; ++ball) {
          if (marbles.replayed({ball}) == nullptr) continue;
          ++tally.replayed_to_the_end;
          marbles.stop_replay({ball});
        }
        if (!marbles.is_replay_void()) {
          ASSERT_TRUE(same_end(whole, marbles));
        }
        stories = std::move(next);
      }
      // The next scene.
      const std::uint64_t changes = dice.below(3);
      for (std::uint64_t change = 0; change < changes; ++change) {
        const auto ball = static_cast<std::uint32_t>(dice.below(balls));
        BodyDescription& body = scene.bodies[ball];
        body.start = at_first.bodies[ball].start;
        body.start_tick = at_first.bodies[ball].start_tick;
        switch (dice.below(3)) {
          case 0:
            body.start_tick = k_never;
            break;
          case 1:
            body.start.twist.velocity_mps.x() += dice.within(0.5);
            break;
          default:
            body.start.pose.position_m.x() += dice.within(0.2 * radius_m);
            body.start.pose.position_m.z() += std::abs(dice.within(0.2 * radius_m));
        }
        stories[ball] = nullptr;
      }
    }
  }
  fmt::print("seed {}: {} runs, {} void, {} failed; work {} of {}; {} replayed to the end\n",
             k_seed, tally.runs, tally.voided, tally.failed, tally.work, tally.work_of_all,
             tally.replayed_to_the_end);
  EXPECT_LT(tally.voided, tally.runs / 10);
  EXPECT_GT(tally.replayed_to_the_end, tally.runs / 2);
}

/// Two balls side by side, far enough from each other, above a floor.
Scene two_balls(double apart_m) {
  scenes::Setting setting = testing::equal_marbles(2, 4, 0);
  Scene scene = setting.scene;
  for (std::size_t ball = 0; ball < 2; ++ball) {
    scene.bodies[ball].start.pose.position_m =
        scene.bodies[0].start.pose.position_m + Vec3(ball == 0 ? 0 : apart_m, 0, 0);
    scene.bodies[ball].start.twist = {};
  }
  return scene;
}

TEST(Stories, AWrongStoryMakesADifference) {
  // Goal: what is replayed is not simulated, so the property above can fail. Method: a ball that
  // starts elsewhere is given its old story; it is where that says, and a ball that it would have
  // met flies on.
  const double radius_m = std::get<Sphere>(two_balls(1).bodies[0].shape).radius_m;
  const Scene before = two_balls(10 * radius_m);
  Scene after = before;
  after.bodies[1].start.pose.position_m =
      after.bodies[0].start.pose.position_m + Vec3(0, 0, 3 * radius_m);
  const StaticGeometry statics(before);
  const NearFeatures near(statics, radius_m);
  const Tick end = Tick{} + ticks_after(1);
  Marbles told;
  told.start(before, near, end, {}, UINT64_MAX,
             {.stories = nullptr, .changes = {}, .records = true});
  ASSERT_FALSE(told.run_until(end));
  MarbleStories stories = told.stories();
  ASSERT_NE(stories[0], nullptr);
  ASSERT_NE(stories[1], nullptr);
  Marbles whole;
  whole.start(after, near, end);
  ASSERT_FALSE(whole.run_until(end));
  for (const bool is_right : {true, false}) {
    if (is_right) stories[1] = nullptr;
    Marbles marbles;
    marbles.start(after, near, end, {}, UINT64_MAX,
                  {.stories = &stories, .changes = {}, .records = true});
    ASSERT_FALSE(marbles.run_until(end));
    for (std::uint32_t ball = 0; ball < 2; ++ball)
      marbles.stop_replay({ball});
    EXPECT_FALSE(marbles.is_replay_void());
    EXPECT_EQ(static_cast<bool>(same_end(whole, marbles)), is_right);
    stories = told.stories();
  }
}

}  // namespace
}  // namespace sleight::physics
