// Tests that replay changes no result. Each scene differs from the previous scene in some balls.
// Each scene is simulated twice: with the previous scene's histories, and from scratch.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "tests/scenes/shared/scenes.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/marbles/equal_marbles.h"
#include "tests/unit/worker/physics/simulator/dice.h"
#include "worker/physics/marbles/marbles.h"

namespace sleight::physics::marble_histories_test {

using testing::Dice;

constexpr std::uint64_t k_seed = 20261121;

std::uint64_t scene_count() {
  return property::long_run() ? 20'000 : property::of_tier(40, 300);
}

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

class MovingMesh {
 public:
  explicit MovingMesh(Scene& scene)
      : mesh_(std::make_shared<TriangleMesh>(*scene.meshes[0].mesh)), first_(*mesh_) {
    scene.meshes[0].mesh = mesh_;
  }
  /// Moves some vertices by at most `by_m` from their initial positions.
  void move(Dice& dice, double by_m, StaticGeometry& statics, NearFeatures& near) {
    std::vector<VertexMove> moves;
    places_.clear();
    for (std::uint64_t count = 1 + dice.below(3); count > 0; --count) {
      const auto vertex = static_cast<std::uint32_t>(dice.below(mesh_->vertices_m().size()));
      const Vec3 offset_m(dice.within(by_m), dice.within(by_m), dice.within(by_m));
      moves.push_back({.vertex = vertex, .position_m = first_.vertices_m()[vertex] + offset_m});
    }
    std::vector<Vec3> before_m(mesh_->vertices_m().begin(), mesh_->vertices_m().end());
    if (mesh_->move_vertices(moves)) return;
    statics.refresh(0);
    near.refresh();
    for (const VertexMove& move : moves) {
      const StaticGeometry::About about = statics.about(0, move.vertex);
      Place& place = places_.emplace_back();
      place.features = about.features;
      place.features.insert(place.features.end(), about.beside.begin(), about.beside.end());
      place.box = k_unmeetable;
      for (const std::uint32_t edge : about.edges) {
        for (const std::uint32_t triangle : mesh_->edges()[edge].triangle) {
          if (triangle == k_no_triangle) continue;
          for (const std::uint32_t corner : mesh_->triangles()[triangle]) {
            enlarge(place.box, before_m[corner], 1e-5F);
            enlarge(place.box, mesh_->vertices_m()[corner], 1e-5F);
          }
        }
      }
    }
  }
  std::vector<MarbleChange> changes() const {
    std::vector<MarbleChange> changes;
    for (const Place& place : places_)
      changes.push_back({.features = place.features, .box = place.box});
    return changes;
  }
  void nothing_moved() { places_.clear(); }

 private:
  struct Place {
    std::vector<FeatureId> features;
    TouchBox box;
  };
  std::shared_ptr<TriangleMesh> mesh_;
  TriangleMesh first_;
  std::vector<Place> places_;
};

/// Makes a ball differ from the initial scene: the ball doesn't start, is faster, or starts
/// elsewhere.
void change_ball(Scene& scene, const Scene& at_first, std::uint32_t ball, Dice& dice) {
  const double radius_m = std::get<Sphere>(scene.bodies[0].shape).radius_m;
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
}

enum class Moves : std::uint8_t { balls, balls_and_vertices };

/// Changes a scene a dozen times. Simulates each scene with and without the previous histories.
void run_scenes(std::uint64_t index, Moves moves, Tally& tally) {
  Dice dice(k_seed, index);
  const auto balls = static_cast<std::uint32_t>(1 + dice.below(14));
  const TickCount intervals[] = {0, 20'000'000, 100'000'000, 300'000'000};
  Scene scene = testing::equal_marbles(balls, index, intervals[dice.below(4)]).scene;
  MovingMesh mesh(scene);
  const Scene at_first = scene;
  StaticGeometry statics(scene);
  NearFeatures near(statics, std::get<Sphere>(scene.bodies[0].shape).radius_m);
  const Tick last{scene.bodies.back().start_tick.value};
  MarbleHistories histories(balls);
  for (int step = 0; step < 12; ++step) {
    SCOPED_TRACE(fmt::format("step {}", step));
    const Tick end = last + ticks_after(0.4 * static_cast<double>(1 + dice.below(8)));
    Marbles whole;
    whole.start(scene, near, end);
    Marbles marbles;
    const auto changed = mesh.changes();
    marbles.start(scene, near, end, {}, UINT64_MAX,
                  {.histories = &histories, .changes = changed, .records = true});
    const auto expected = whole.run_until(end);
    const int looks = static_cast<int>(dice.below(3));
    for (int look = 1; look <= looks; ++look) {
      (void)marbles.run_until(Tick{end.value * look / 3});
      if (dice.below(4) == 0) marbles.stop_replay({static_cast<std::uint32_t>(dice.below(balls))});
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
      histories.assign(balls, nullptr);
    } else {
      tally.work += marbles.counts().work();
      tally.work_of_all += whole.counts().work();
      auto next = marbles.histories();
      for (std::uint32_t ball = 0; ball < balls; ++ball) {
        if (marbles.replayed({ball}) == nullptr) continue;
        ++tally.replayed_to_the_end;
        marbles.stop_replay({ball});
      }
      if (!marbles.is_replay_void()) {
        ASSERT_TRUE(same_end(whole, marbles));
      }
      histories = std::move(next);
    }
    for (std::uint64_t changes = dice.below(3); changes > 0; --changes) {
      const auto ball = static_cast<std::uint32_t>(dice.below(balls));
      change_ball(scene, at_first, ball, dice);
      histories[ball] = nullptr;
    }
    mesh.nothing_moved();
    if (moves == Moves::balls_and_vertices && dice.below(2) == 0)
      mesh.move(dice, dice.below(2) == 0 ? 1e-4 : 2e-3, statics, near);
  }
}

void run_all_scenes(Moves moves, std::uint64_t count) {
  Tally tally;
  for (const std::uint64_t index : property::cases(count)) {
    if (::testing::Test::HasFailure()) break;
    run_scenes(index, moves, tally);
  }
  fmt::print("seed {}: {} runs, {} void, {} failed; work {} of {}; {} replayed to the end\n",
             k_seed, tally.runs, tally.voided, tally.failed, tally.work, tally.work_of_all,
             tally.replayed_to_the_end);
  if (!property::all_cases()) return;
  EXPECT_LT(tally.voided, tally.runs / 10);
  EXPECT_GT(tally.replayed_to_the_end, tally.runs / 2);
}

TEST(MarbleHistories, ReplayingMakesNoDifference) {
  // Goal: replay changes no bit of the result (marbles.h, invariant 4). Scenes are heaps of balls
  // that rest and wake, and single falling balls. Method: change some balls' starts in random
  // scenes a dozen times. Simulate each scene from scratch. Simulate each changed scene with the
  // previous scene's histories, in up to three portions.
  run_all_scenes(Moves::balls, scene_count());
}

TEST(MarbleHistories, MovedGeometryMakesNoDifference) {
  // Goal: replay changes no bit of the result even if the static geometry changes. Method: change
  // some balls' starts, and move vertices of the mesh. Some changes move a vertex up to 0.1 mm away
  // from its initial position; the others move it up to 2 mm away.
  run_all_scenes(Moves::balls_and_vertices, scene_count() / 2);
}

/// Two balls side by side above a floor, `apart_m` from each other.
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

TEST(MarbleHistories, AWrongHistoryMakesADifference) {
  // Goal: a replayed ball is not simulated, so a wrong history gives a wrong result, and the tests
  // above can fail. Method: let a ball start elsewhere, in another ball's path, but replay the
  // first ball's old history. The other ball then flies on without a hit.
  const double radius_m = std::get<Sphere>(two_balls(1).bodies[0].shape).radius_m;
  const Scene before = two_balls(10 * radius_m);
  Scene after = before;
  after.bodies[1].start.pose.position_m =
      after.bodies[0].start.pose.position_m + Vec3(0, 0, 3 * radius_m);
  const StaticGeometry statics(before);
  const NearFeatures near(statics, radius_m);
  const Tick end = Tick{} + ticks_after(1);
  Marbles earlier;
  earlier.start(before, near, end, {}, UINT64_MAX,
                {.histories = nullptr, .changes = {}, .records = true});
  ASSERT_FALSE(earlier.run_until(end));
  MarbleHistories histories = earlier.histories();
  ASSERT_NE(histories[0], nullptr);
  ASSERT_NE(histories[1], nullptr);
  Marbles whole;
  whole.start(after, near, end);
  ASSERT_FALSE(whole.run_until(end));
  for (const bool is_right : {true, false}) {
    if (is_right) histories[1] = nullptr;
    Marbles marbles;
    marbles.start(after, near, end, {}, UINT64_MAX,
                  {.histories = &histories, .changes = {}, .records = true});
    ASSERT_FALSE(marbles.run_until(end));
    for (std::uint32_t ball = 0; ball < 2; ++ball)
      marbles.stop_replay({ball});
    EXPECT_FALSE(marbles.is_replay_void());
    EXPECT_EQ(static_cast<bool>(same_end(whole, marbles)), is_right);
    histories = earlier.histories();
  }
}

TEST(MarbleHistories, ABallIsLeftAloneNowIfItWouldBeNow) {
  // Goal: if the confinement changes, a ball's history is valid only until the tick at which the
  // ball was suspended. If the confinement is the same, the whole history is valid. Method: suspend
  // a ball in a box once the ball is slow. Replay the ball three times: in the same box, in a wider
  // box, and without a box.
  Scene scene = two_balls(1);
  scene.bodies.resize(1);
  const StaticGeometry statics(scene);
  const NearFeatures near(statics, std::get<Sphere>(scene.bodies[0].shape).radius_m);
  const Tick end = Tick{} + ticks_after(3);
  const auto within = [](float half_m) {
    return [half_m](BodyId, const Vec3&, const Twist& twist) {
      return math::norm(twist.velocity_mps) > 0.3
                 ? std::nullopt
                 : std::optional(Box{.low_m = {-half_m, -half_m, -half_m},
                                     .high_m = {half_m, half_m, half_m}});
    };
  };
  const auto never = [](BodyId, const Vec3&, const Twist&) { return std::optional<Box>(); };
  Marbles earlier;
  earlier.start(scene, near, end, within(1), UINT64_MAX,
                {.histories = nullptr, .changes = {}, .records = true});
  ASSERT_FALSE(earlier.run_until(end));
  ASSERT_TRUE(earlier.is_suspended({0}));
  const MarbleHistories histories = earlier.histories();
  const auto replay = [&](MarbleConfinement confinement) {
    Marbles marbles;
    marbles.start(
        scene, near, end, std::move(confinement), UINT64_MAX,
        {.histories = &histories, .changes = {}, .confinement_differs = true, .records = true});
    EXPECT_FALSE(marbles.run_until(end));
    EXPECT_FALSE(marbles.is_replay_void());
    return marbles;
  };
  EXPECT_NE(replay(within(1)).replayed({0}), nullptr);
  const Marbles wider = replay(within(2));
  EXPECT_EQ(wider.replayed({0}), nullptr);
  EXPECT_TRUE(wider.is_suspended({0}));
  const Marbles free = replay(never);
  EXPECT_EQ(free.replayed({0}), nullptr);
  EXPECT_FALSE(free.is_suspended({0}));
  Marbles whole;
  whole.start(scene, near, end);
  ASSERT_FALSE(whole.run_until(end));
  EXPECT_NE(whole.position_m({0}), earlier.segment({0}).flight.position_m);
  EXPECT_TRUE(same_end(whole, free));
}

/// Balls without gravity in front of a wall.
Scene weightless(std::uint32_t balls) {
  Scene scene = testing::equal_marbles(balls, 4, 0).scene;
  scene.gravity_mps2 = {0, 0, 0};
  scene.planes.clear();
  scene.convexes.clear();
  const std::vector<Vec3> vertices_m{{0.1, -1, -1}, {0.1, 1, -1}, {0.1, 1, 1}, {0.1, -1, 1}};
  const std::vector<TriangleCorners> triangles{{0, 3, 2}, {0, 2, 1}};
  scene.meshes[0].mesh = std::make_shared<const TriangleMesh>(
      TriangleMesh::make(vertices_m, triangles, MeshClosure::may_be_open).value());
  for (std::uint32_t ball = 0; ball < balls; ++ball)
    scene.bodies[ball].start = {.pose = {.position_m = {0, 0.1 * ball, 0}}, .twist = {}};
  return scene;
}

TEST(MarbleHistories, ABallThatAWallMadeSlowIsntSlowWithoutIt) {
  // Goal: a ball is simulated again if a wall made it slow enough to be suspended and the wall has
  // since moved. Method: let a ball hit a wall and become slow, then move the wall away.
  Scene scene = weightless(1);
  scene.bodies[0].start.twist.velocity_mps = {1, 0, 0};
  auto mesh = std::make_shared<TriangleMesh>(*scene.meshes[0].mesh);
  scene.meshes[0].mesh = mesh;
  StaticGeometry statics(scene);
  NearFeatures near(statics, std::get<Sphere>(scene.bodies[0].shape).radius_m);
  const Tick end = Tick{} + ticks_after(0.2);
  const auto where_slow = [](BodyId, const Vec3&, const Twist& twist) {
    return math::norm(twist.velocity_mps) > 0.9
               ? std::nullopt
               : std::optional(Box{.low_m = {-2, -2, -2}, .high_m = {2, 2, 2}});
  };
  Marbles earlier;
  earlier.start(scene, near, end, where_slow, UINT64_MAX,
                {.histories = nullptr, .changes = {}, .records = true});
  ASSERT_FALSE(earlier.run_until(end));
  ASSERT_TRUE(earlier.is_suspended({0}));
  const MarbleHistories histories = earlier.histories();

  std::vector<FeatureId> features;
  std::vector<VertexMove> moves;
  for (std::uint32_t vertex = 0; vertex < 4; ++vertex) {
    const auto about = statics.about(0, vertex).features;
    features.insert(features.end(), about.begin(), about.end());
    moves.push_back({.vertex = vertex, .position_m = mesh->vertices_m()[vertex] + Vec3(0.5, 0, 0)});
  }
  ASSERT_FALSE(mesh->move_vertices(moves));
  statics.refresh(0);
  near.refresh();
  const MarbleChange change{.features = features,
                            .box = {.low_m = {0.05F, -2, -2, 0}, .high_m = {1, 2, 2, 0}}};
  Marbles whole;
  whole.start(scene, near, end, where_slow);
  ASSERT_FALSE(whole.run_until(end));
  ASSERT_FALSE(whole.is_suspended({0}));
  Marbles marbles;
  marbles.start(scene, near, end, where_slow, UINT64_MAX,
                {.histories = &histories,
                 .changes = {&change, 1},
                 .confinement_differs = true,
                 .records = true});
  ASSERT_FALSE(marbles.run_until(end));
  ASSERT_EQ(marbles.replayed({0}), nullptr);
  EXPECT_TRUE(same_end(whole, marbles));
}

TEST(MarbleHistories, TwoLiveBallsBesideAStartEnd) {
  // Goal: if a ball has a predicted meeting with a replayed partner and another ball makes that
  // partner live, the ball drops the prediction. Method: record a run with three balls. In a second
  // run, let two balls start elsewhere, so that they almost touch the third, replayed ball.
  Scene before = weightless(3);
  before.bodies[2].start_tick = Tick{} + ticks_after(0.1);
  Scene after = before;
  const double radius_m = std::get<Sphere>(before.bodies[0].shape).radius_m;
  for (const std::uint32_t ball : {0U, 1U}) {
    after.bodies[ball].start.pose.position_m = before.bodies[2].start.pose.position_m;
    after.bodies[ball].start.pose.position_m.z() += (ball == 0 ? 1 : -1) * (2 * radius_m + 3e-6);
  }
  const StaticGeometry statics(before);
  const NearFeatures near(statics, radius_m);
  const Tick end = Tick{} + ticks_after(0.2);
  Marbles earlier;
  earlier.start(before, near, end, {}, UINT64_MAX,
                {.histories = nullptr, .changes = {}, .records = true});
  ASSERT_FALSE(earlier.run_until(end));
  MarbleHistories histories = earlier.histories();
  histories[0] = histories[1] = nullptr;
  Marbles whole;
  whole.start(after, near, end);
  ASSERT_FALSE(whole.run_until(end));
  Marbles marbles;
  marbles.start(after, near, end, {}, UINT64_MAX,
                {.histories = &histories, .changes = {}, .records = true});
  ASSERT_FALSE(marbles.run_until(end));
  EXPECT_TRUE(same_end(whole, marbles));
}

TEST(MarbleHistories, ACheckpointDoesntSayWhatFollowedAtItsTick) {
  // Goal: checkpoint_before() reports a gap if a meeting followed the checkpoint at the
  // checkpoint's own tick. Method: build a history with two meetings at one tick and a checkpoint
  // after the first meeting.
  MarbleHistory history;
  history.meetings = {{.tick = Tick{5}, .partner = 1}, {.tick = Tick{5}, .partner = 2}};
  MarbleHistory::Checkpoint checkpoint;
  checkpoint.tick = Tick{5};
  checkpoint.meetings = 1;
  history.checkpoints = {checkpoint};
  history.last.tick = Tick{9};
  bool is_gap = false;
  EXPECT_NE(history.checkpoint_before(Tick{7}, is_gap), nullptr);
  EXPECT_TRUE(is_gap);
  history.checkpoints.push_back(checkpoint);
  history.checkpoints.back().meetings = 2;
  EXPECT_EQ(history.checkpoint_before(Tick{7}, is_gap), &history.checkpoints[1]);
  EXPECT_FALSE(is_gap);
}

}  // namespace sleight::physics::marble_histories_test
