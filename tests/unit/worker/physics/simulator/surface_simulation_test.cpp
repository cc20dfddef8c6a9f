#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <map>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/collision/surface_tables.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "tests/unit/worker/physics/simulator/reuse_runs.h"
#include "tests/unit/worker/physics/surface/reference_surface.h"

namespace sleight::physics::surface_simulation_test {

using testing::Dice;
using testing::RecordedRun;
using testing::Relief;

constexpr std::uint64_t k_seed = 20261122;
constexpr double k_side_m = 0.016;

/// The n-th throw of an endless list. A throw has 1 to 5 dice.
Scene throw_of(std::uint64_t n) {
  Dice dice(k_seed, n);
  const auto relief = static_cast<Relief>(n % testing::k_reliefs);
  const double height_m = 1e-4 + std::abs(dice.within(3e-3));
  const double spacing_m = 0.005 + std::abs(dice.within(0.03));
  const auto count = static_cast<std::uint32_t>(n % 3 == 0 ? 2 + dice.below(4) : 1);
  return testing::thrown_dice(
      n, count, testing::table_surface(testing::random_table(n, relief, height_m), spacing_m));
}

/// Points all over a cube, much denser than the cube's own lattice.
std::vector<Vec3> dense_points(double side_m) {
  constexpr int k_steps = 24;
  std::vector<Vec3> points_m;
  for (int i = 0; i <= k_steps; ++i) {
    for (int j = 0; j <= k_steps; ++j) {
      for (int face = 0; face < 6; ++face) {
        Vec3 point_m;
        point_m[face % 3] = (face < 3 ? -0.5 : 0.5) * side_m;
        point_m[(face + 1) % 3] = (static_cast<double>(i) / k_steps - 0.5) * side_m;
        point_m[(face + 2) % 3] = (static_cast<double>(j) / k_steps - 0.5) * side_m;
        points_m.push_back(point_m);
      }
    }
  }
  return points_m;
}

double least_gap_m(const RecordedRun& run, std::uint32_t body, SplineSurface& surface, Tick tick,
                   std::span<const Vec3> points_m, Vec3* where_m = nullptr) {
  const Segment& segment = *run.recording.segment_at({body}, tick);
  const Mat3 turn =
      math::matrix_of(testing::turn_at(segment, run.scene.bodies[body].inertia, tick));
  const Vec3 centre_m = testing::place_at(segment, tick);
  double least_m = 1;
  for (const Vec3& point_m : points_m) {
    const Vec3 place_m = math::product(turn, point_m) + centre_m;
    const double gap_m = place_m.z() - surface.at(place_m.x(), place_m.y()).height_m;
    if (gap_m >= least_m) continue;
    least_m = gap_m;
    if (where_m != nullptr) *where_m = place_m;
  }
  return least_m;
}

/// Returns the surface's greatest downward curvature near a place, up to 5 mm away in x and in y.
/// Uses the reference.
double bump_near(const StaticSurface& surface, const Vec3& place_m) {
  double most = 0;
  for (int i = -5; i <= 5; ++i) {
    for (int j = -5; j <= 5; ++j) {
      const auto at =
          testing::reference_at(surface, place_m.x() + 1e-3 * i, place_m.y() + 1e-3 * j);
      most = std::max(most, -static_cast<double>(at.second_least()));
    }
  }
  return most;
}

TEST(SurfaceSimulation, DiceStayOnTheTable) {
  // Goal: a bump pierces a die by at most the height that fits between the die's lattice points
  // (surface_controls.h). Method: throw one die or several dice. Test points that are six times as
  // dense as the lattice. Test them at ticks of events, soon after events and at random ticks.
  const std::vector<Vec3> points_m = dense_points(k_side_m);
  double least_m = 1;
  for (const std::uint64_t n :
       property::cases(property::long_run() ? 1000 : property::of_tier(10, 50))) {
    const RecordedRun run = testing::recorded(throw_of(n), 1);
    ASSERT_EQ(run.error, "") << n;
    Dice dice(k_seed + 1, n);
    SplineSurface surface(run.scene.surfaces[0]);
    for (std::uint32_t body = 0; body < run.scene.bodies.size(); ++body) {
      const auto segments = run.recording.segments({body});
      double deepest_m = 1;
      Vec3 where_m = Vec3::Zero();
      const auto look = [&](Tick tick) {
        Vec3 place_m = Vec3::Zero();
        const double gap_m = least_gap_m(run, body, surface, tick, points_m, &place_m);
        if (gap_m < deepest_m) where_m = place_m;
        deepest_m = std::min(deepest_m, gap_m);
      };
      for (int i = 0; i < 30; ++i) {
        const auto end = static_cast<std::uint64_t>(run.recording.end().value);
        const Tick begin = segments[dice.below(segments.size())].segment.flight.begin;
        look(begin);
        look(std::min(run.recording.end(), begin + static_cast<TickCount>(dice.below(10'000'000))));
        look(Tick{static_cast<TickCount>(dice.below(end))});
      }
      const double spacing_m = run.scene.surfaces[0].point_spacing_m;
      const double allowed_m =
          0.25 * bump_near(run.scene.surfaces[0], where_m) * spacing_m * spacing_m + 1e-6;
      EXPECT_GT(deepest_m, -allowed_m) << "throw " << n << ", die " << body;
      // One of several dice may stand on another.
      if (run.scene.bodies.size() == 1) {
        EXPECT_LT(deepest_m, 1e-5) << "never came close";
      }
      least_m = std::min(least_m, deepest_m);
    }
  }
  fmt::print("deepest: {:.3g} m\n", -least_m);
}

struct Outcome {
  std::uint64_t digest = 0;
  std::vector<SurfaceTouch> touches;
};

::testing::AssertionResult same_touches(std::span<const SurfaceTouch> a,
                                        std::span<const SurfaceTouch> b) {
  for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
    if (i < a.size() && i < b.size() && a[i].tick == b[i].tick && a[i].body == b[i].body &&
        a[i].surface == b[i].surface && a[i].point_m == b[i].point_m)
      continue;
    const auto tick = [i](std::span<const SurfaceTouch> touches) {
      return i < touches.size() ? touches[i].tick.value : -1;
    };
    return ::testing::AssertionFailure()
           << fmt::format("they part at touch {} of {} and {}, at ticks {} and {}", i, a.size(),
                          b.size(), tick(a), tick(b));
  }
  return ::testing::AssertionSuccess();
}

Outcome outcome_of(const Scene& scene, const SimulationOptions& options, int portions) {
  Simulation simulation = Simulation::start(scene, options).value();
  for (int i = 1; i <= portions; ++i)
    EXPECT_FALSE(simulation.run_until(Tick{} + ticks_after(0.8) * i / portions));
  const auto touches = simulation.surface_touches();
  return {simulation.recording().digest(), {touches.begin(), touches.end()}};
}

TEST(SurfaceSimulation, EveryWayGivesTheSame) {
  // Goal: algorithm, broad phase, queue and portions change no bit of the recording or of the
  // surface touches. Method: simulate random throws in several ways, and compare the results with
  // the results of the all-pairs algorithm.
  SimulationOptions reference;
  reference.algorithm = Algorithm::all_pairs;
  for (const std::uint64_t n :
       property::cases(property::long_run() ? 3000 : property::of_tier(12, 60))) {
    const Scene scene = throw_of(n);
    const Outcome expected = outcome_of(scene, reference, 1);
    EXPECT_GT(expected.touches.size(), 2U);
    int way = 0;
    for (const Algorithm algorithm : {Algorithm::asynchronous, Algorithm::synchronous}) {
      for (const BroadPhaseKind boxes :
           {BroadPhaseKind::hierarchical_grid, BroadPhaseKind::sweep_and_prune}) {
        SimulationOptions options;
        options.algorithm = algorithm;
        options.make_engine = engine_with(boxes, static_cast<QueueKind>(way % 3));
        ++way;
        const Outcome outcome = outcome_of(scene, options, way % 2 == 0 ? 37 : 1);
        ASSERT_EQ(outcome.digest, expected.digest) << "throw " << n << ", way " << way;
        ASSERT_TRUE(same_touches(outcome.touches, expected.touches)) << n;
      }
    }
  }
}

/// Returns whether a die's points near the surface surround the die's centre, seen from above. The
/// error may be up to `tolerance_m`.
bool is_balanced(const RecordedRun& run, SplineSurface& surface, std::span<const Vec3> points_m,
                 double near_m, double tolerance_m) {
  const Segment& segment = run.recording.segments({0}).back().segment;
  const Mat3 turn = math::matrix_of(segment.flight.orientation);
  std::vector<Vec3> arms_m;
  for (const Vec3& point_m : points_m) {
    const Vec3 arm_m = math::product(turn, point_m);
    const Vec3 place_m = arm_m + segment.flight.position_m;
    if (place_m.z() - surface.at(place_m.x(), place_m.y()).height_m <= near_m)
      arms_m.push_back(arm_m);
  }
  for (int k = 0; k < 64; ++k) {
    const Vec3 way(std::cos(0.0981747704 * k), std::sin(0.0981747704 * k), 0);
    double furthest_m = -1;
    for (const Vec3& arm_m : arms_m)
      furthest_m = std::max(furthest_m, math::dot(way, arm_m));
    if (furthest_m < -tolerance_m) return false;
  }
  return true;
}

TEST(SurfaceSimulation, DiceLoseEnergyAndComeToRestBalanced) {
  // Goal: no collision gains energy. All dice come to rest on the table, and a single die rests in
  // balance. Method: throw dice onto tables with restitution and friction from 0 to 1. Compare the
  // dice's energy before and after each event, and test their last poses.
  const std::vector<Vec3> points_m = dense_points(k_side_m);
  double gain = 0;
  double highest_m = 0;
  for (const std::uint64_t n :
       property::cases(property::long_run() ? 2000 : property::of_tier(15, 60))) {
    const RecordedRun run = testing::recorded(throw_of(n), 4);
    ASSERT_EQ(run.error, "") << n;
    SplineSurface surface(run.scene.surfaces[0]);
    std::map<EventKey, std::array<double, 3>> energies_j;  // before, after, size
    for (std::uint32_t body = 0; body < run.scene.bodies.size(); ++body) {
      const auto entries = run.recording.segments({body});
      for (std::size_t i = 1; i < entries.size(); ++i) {
        const Tick tick = entries[i].segment.flight.begin;
        const double before_j = testing::energy_j(run.scene, body, entries[i - 1].segment, tick);
        auto& sum = energies_j[entries[i].cause];
        sum[0] += before_j;
        sum[1] += testing::energy_j(run.scene, body, entries[i].segment, tick);
        sum[2] += std::fabs(before_j) + 1e-6;
      }
      ASSERT_EQ(entries.back().segment.mode, MotionMode::resting) << "throw " << n;
      const double above_m = least_gap_m(run, body, surface, run.recording.end(), points_m);
      if (run.scene.bodies.size() > 1) continue;
      highest_m = std::max(highest_m, above_m);
      EXPECT_LT(above_m, 5e-6) << n;
      EXPECT_TRUE(is_balanced(run, surface, points_m, 1e-4, 3e-4)) << n;
    }
    for (const auto& [key, sum] : energies_j)
      gain = std::max(gain, (sum[1] - sum[0]) / sum[2]);
  }
  fmt::print("largest gain {:.2g}, highest resting die {:.3g} m\n", gain, highest_m);
  EXPECT_LT(gain, 1e-12);
}

/// Makes a control point near a place higher, lower or bouncier.
void change_control(Scene& scene, const Vec3& place_m, Dice& dice) {
  StaticSurface& surface = scene.surfaces[0];
  const auto& table = dynamic_cast<const testing::TableControls&>(*surface.controls);
  const auto index = [&](double at_m) {
    return static_cast<std::int32_t>(std::lround(at_m / surface.spacing_m)) +
           static_cast<std::int32_t>(dice.below(5)) - 2;
  };
  const GridIndex point{index(place_m.x()), index(place_m.y())};
  SurfaceControl control = table.at(point);
  const auto kind = dice.below(4);
  if (kind != 0) control.height_m += dice.within(kind == 1 ? 1e-5 : 1e-3);
  if (kind == 0) control.restitution = 0.5 + dice.within(0.5);
  if (kind == 3) control.friction = 0.5 + dice.within(0.5);
  surface.controls = table.with(point, control);
}

/// Makes a proposal as a sampler of throws does. Changes some control points, a body's start, or
/// both. Each control point is at one of the first three touches, at the last touch, or at a random
/// place.
void change_throw(Scene& scene, std::span<const SurfaceTouch> touches, Dice& dice) {
  const auto kind = dice.below(8);
  if (kind < 6) {
    for (auto changes = 1 + dice.below(3); changes > 0; --changes) {
      Vec3 place_m = dice.vector_within(dice.one_in(2) ? 0.1 : 1);
      if (!touches.empty() && dice.below(3) != 0)
        place_m = touches[dice.one_in(2) ? dice.below(std::min<std::size_t>(3, touches.size()))
                                         : touches.size() - 1]
                      .point_m;
      change_control(scene, place_m, dice);
    }
  }
  if (kind < 5) return;
  StartState& start = scene.bodies[dice.below(scene.bodies.size())].start;
  if (dice.one_in(2)) start.pose.position_m += dice.vector_within(1e-3);
  start.twist.velocity_mps += dice.vector_within(0.05);
  start.twist.angular_velocity_radps += dice.vector_within(1);
}

TEST(SurfaceSimulation, AHistoryMakesNoDifference) {
  // Goal: after any change of control points and starts, a simulation with the previous history
  // equals a simulation from scratch, bit for bit. It simulates fewer events. Method: make
  // successive proposals and accept some. Simulate each proposal from scratch. Then simulate it in
  // two portions, with the history and random options.
  constexpr int k_steps = 20;
  std::uint64_t replayed = 0;
  std::uint64_t simulated = 0;
  std::uint64_t failed = 0;
  const std::uint64_t count = property::long_run() ? 5'000 : property::of_tier(15, 110);
  for (const std::uint64_t n : property::cases(count)) {
    if (HasFailure()) break;
    Dice dice(k_seed + 2, n);
    Scene accepted = throw_of(n);
    std::shared_ptr<const History> history;
    std::vector<SurfaceTouch> touches;
    for (int step = 0; step < k_steps && !HasFailure(); ++step) {
      SCOPED_TRACE(fmt::format("step {}", step));
      Scene scene = accepted;
      if (step > 0 && !dice.one_in(10)) change_throw(scene, touches, dice);
      const SimulationOptions way = testing::random_way(dice);
      auto whole = Simulation::start(scene, {.keep_impacts = way.keep_impacts});
      auto reused = Simulation::start(scene, way, history);
      ASSERT_EQ(whole.ok(), reused.ok());
      if (!whole) {
        EXPECT_EQ(whole.error().message, reused.error().message);
        ++failed;
        continue;
      }
      Simulation expected = std::move(whole).value();
      Simulation simulation = std::move(reused).value();
      const Tick end = Tick{} + ticks_after(0.2 + 0.2 * static_cast<double>(dice.below(4)));
      for (const Tick tick : {Tick{end.value / 3}, end}) {
        const auto error = expected.run_until(tick);
        const auto other = simulation.run_until(tick);
        ASSERT_EQ(error ? error->message : "", other ? other->message : "");
        ASSERT_FALSE(error);
        ASSERT_TRUE(testing::same_state(expected, simulation, scene.bodies.size()));
        ASSERT_TRUE(same_touches(expected.surface_touches(), simulation.surface_touches()));
        ASSERT_TRUE(std::ranges::equal(expected.impacts(), simulation.impacts()));
      }
      ASSERT_EQ(simulation.recording().digest(), expected.recording().digest())
          << testing::first_difference(expected.recording(), simulation.recording());
      if (history != nullptr) {
        replayed += simulation.counts().replayed;
        simulated += testing::changes_of(simulation.counts());
      }
      if (step > 0 && dice.one_in(2)) continue;
      accepted = scene;
      history = simulation.history();
      touches.assign(expected.surface_touches().begin(), expected.surface_touches().end());
    }
  }
  fmt::print("{} proposals, {} of which failed; events: {} replayed, {} simulated\n",
             count * k_steps, failed, replayed, simulated);
  if (property::all_cases()) {
    EXPECT_GT(replayed, simulated / 10);
  }
}

TEST(SurfaceSimulation, FarChangesAreReplayed) {
  // Goal: a change far from the dice is replayed without any simulated event, but a change under a
  // touch changes the result. Method: change a control point far away, and then a control point
  // under the last touch.
  Scene scene = throw_of(1);
  const testing::RunResult earlier = testing::run(scene, 2);
  Simulation simulation = Simulation::start(scene, {}).value();
  ASSERT_FALSE(simulation.run_until(Tick{} + ticks_after(2)));
  const Vec3 last_m = simulation.surface_touches().back().point_m;
  Dice dice(k_seed, 4);
  change_control(scene, {1, 1, 0}, dice);
  const testing::RunResult far = testing::run(scene, 2, earlier.history);
  EXPECT_EQ(far.digest, earlier.digest);
  EXPECT_EQ(testing::changes_of(far.counts), 0U);
  StaticSurface& surface = scene.surfaces[0];
  const GridIndex under = SplineSurface(surface).patch_at(last_m.x(), last_m.y());
  const auto& table = dynamic_cast<const testing::TableControls&>(*surface.controls);
  surface.controls = table.with(under, {.height_m = table.at(under).height_m - 1e-5});
  const testing::RunResult near = testing::run(scene, 2, earlier.history);
  EXPECT_NE(near.digest, earlier.digest);
  EXPECT_EQ(near.digest, testing::run(scene, 2).digest);
}

/// A die falls flat onto a flat table. The table's restitution and friction change from left to
/// right.
Scene falls_flat(double x_m, double speed_mps) {
  auto table = testing::table_of([](GridIndex index) {
    return SurfaceControl{
        .height_m = 0, .restitution = index.i < 0 ? 0.0 : 0.9, .friction = index.i < 0 ? 0.0 : 1.0};
  });
  Scene scene = testing::thrown_dice(1, 1, testing::table_surface(table, 0.02));
  scene.bodies[0].start.pose = {{x_m, 0.003, 0.1},
                                math::quaternion_of_rotation_vector({0.3, 0, 0})};
  scene.bodies[0].start.twist = {{0, speed_mps, 0}, Vec3::Zero()};
  return scene;
}

TEST(SurfaceSimulation, FieldsAreThoseOfThePlace) {
  // Goal: a die bounces and slides with the restitution and friction of the place where it lands.
  // Method: use a table with two sides. The left side has friction and restitution 0, and the right
  // side has friction 1 and restitution 0.9. Compare the contact point's normal speed before and
  // after the first collision, and the change of the die's velocity along the table.
  for (const double x_m : {-0.2, 0.2}) {
    const RecordedRun run = testing::recorded(falls_flat(x_m, 0.3), 0.2);
    ASSERT_EQ(run.error, "");
    Simulation simulation = Simulation::start(run.scene, {}).value();
    ASSERT_FALSE(simulation.run_until(run.recording.end()));
    const SurfaceTouch touch = simulation.surface_touches().front();
    const auto entries = run.recording.segments({0});
    ASSERT_EQ(entries[1].segment.flight.begin, touch.tick);
    const auto point_mps = [&](const Segment& segment) -> Vec3 {
      const Twist twist = testing::twist_in(segment, run.scene.bodies[0].inertia, touch.tick);
      const Vec3 arm_m = touch.point_m - testing::place_at(segment, touch.tick);
      return twist.velocity_mps + math::cross(twist.angular_velocity_radps, arm_m);
    };
    const Vec3 before = point_mps(entries[0].segment);
    const Vec3 after = point_mps(entries[1].segment);
    // Along a flat table, only friction acts.
    const Vec3 push_mps =
        entries[1].segment.flight.velocity_mps - velocity_at(entries[0].segment.flight, touch.tick);
    if (x_m < 0) {
      EXPECT_LT(after.z(), -0.05 * before.z());
      EXPECT_NEAR(push_mps.y(), 0, 1e-12);
    } else {
      EXPECT_GT(after.z(), -0.6 * before.z());
      EXPECT_GT(std::abs(push_mps.y()), 1e-2);
    }
  }
}

TEST(SurfaceSimulation, WrongScenesAreRefused) {
  // Goal: invalid surfaces and bodies give typed errors. Method: make one change at a time to a
  // valid scene.
  struct Wrong {
    SceneError::Kind kind;
    const char* says;
    void (*spoil)(Scene& scene);
  };
  using Kind = SceneError::Kind;
  const Wrong faults[]{
      {Kind::bad_shape, "no control points", [](Scene& s) { s.surfaces[0].controls = nullptr; }},
      {Kind::bad_number, "spacing is nan m", [](Scene& s) { s.surfaces[0].spacing_m = NAN; }},
      {Kind::bad_number, "spacing is 0 m", [](Scene& s) { s.surfaces[0].spacing_m = 0; }},
      {Kind::bad_number, "point spacing is nan m",
       [](Scene& s) { s.surfaces[0].point_spacing_m = NAN; }},
      {Kind::bad_shape, "at most 1024 points",
       [](Scene& s) { s.surfaces[0].point_spacing_m = 1e-5; }},
      {Kind::bad_shape, "boxes",
       [](Scene& s) {
         s.bodies[0].shape = Sphere{.radius_m = 0.01};
         s.bodies[0].inertia = solid_ball_inertia(0.01, 0.01);
       }},
      {Kind::overlap, "table", [](Scene& s) { s.bodies[0].start.pose.position_m.z() = -0.5; }},
      {Kind::overlap, "table", [](Scene& s) { s.bodies[0].start.pose.position_m.z() = 0.007; }},
  };
  for (const Wrong& fault : faults) {
    Scene scene = falls_flat(0, 0);
    ASSERT_TRUE(Simulation::start(scene, {}).ok());
    fault.spoil(scene);
    const auto started = Simulation::start(scene, {});
    ASSERT_FALSE(started.ok()) << fault.says;
    EXPECT_EQ(started.error().kind, fault.kind) << started.error().message;
    EXPECT_NE(started.error().message.find(fault.says), std::string::npos)
        << started.error().message;
  }
}

}  // namespace sleight::physics::surface_simulation_test
