#include <gtest/gtest.h>

#include <numbers>

#include "tests/scenes/shared/scenes.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/simulator/plain_geometry.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"

namespace sleight::physics::modes_test {

using testing::RecordedRun;

constexpr double k_g_mps2 = 9.81;
constexpr double k_radius_m = 0.01;

BodyDescription marble(const Vec3& place_m, const Vec3& velocity_mps = Vec3::Zero(),
                       const Vec3& spin_radps = Vec3::Zero()) {
  return {.name = {},
          .shape = Sphere{.radius_m = k_radius_m},
          .inertia = solid_ball_inertia(0.01, k_radius_m),
          .start = {.pose = {.position_m = place_m},
                    .twist = {.velocity_mps = velocity_mps, .angular_velocity_radps = spin_radps}}};
}

Scene scene_with(const SurfaceLaw& law) {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -k_g_mps2};
  scene.contacts = ContactTable(1, law);
  scene.slow = scenes::slow_contacts_of(2 * k_radius_m);
  return scene;
}

StaticPlane plane(const Vec3& normal, const Vec3& through_m = Vec3::Zero()) {
  const Vec3 unit = math::normalized(normal);
  return {.name = {}, .outside = {.normal = unit, .offset_m = math::dot(unit, through_m)}};
}

/// Almost in touch: the ball falls by less than a micrometre.
constexpr double k_close_m = k_touch_m + 1e-7;

MotionMode last_mode(const RecordedRun& run) {
  return run.recording.segments({0}).back().segment.mode;
}

Vec3 last_place(const RecordedRun& run) {
  return testing::place_at(run.recording.segments({0}).back().segment, run.recording.end());
}

/// Kinetic plus potential energy of a solid ball, per mass.
double energy_jpkg(const Scene& scene, std::uint32_t body, const Segment& segment, Tick tick) {
  const double radius_m = std::get<Sphere>(scene.bodies[body].shape).radius_m;
  const Twist twist = testing::twist_in(segment, scene.bodies[body].inertia, tick);
  const Vec3 w = radius_m * twist.angular_velocity_radps;
  return 0.5 * math::dot(twist.velocity_mps, twist.velocity_mps) + 0.2 * math::dot(w, w) -
         math::dot(scene.gravity_mps2, testing::place_at(segment, tick));
}

TEST(Modes, AMarbleRollsDownASlope) {
  // Goal: a ball on a slope doesn't bounce, but rolls with the acceleration 5/7 g sin(slope), in
  // fewer than 5 segments. Method: use slopes in two directions. Compare the acceleration and the
  // distance with closed forms.
  for (const Vec3& normal : {Vec3(0.3, 0, 1), Vec3(-0.1, 0.2, 1)}) {
    Scene scene = scene_with({.restitution = 0.5, .friction = 0.5});
    scene.planes.push_back(plane(normal));
    const Vec3 n = math::normalized(normal);
    scene.bodies.push_back(marble((k_radius_m + k_close_m) * n));
    const RecordedRun run = testing::recorded(scene, 1);
    ASSERT_EQ(run.error, "");
    EXPECT_EQ(last_mode(run), MotionMode::rolling);
    EXPECT_LT(run.recording.segments({0}).size(), 5U);
    const Segment& rolling = run.recording.segments({0}).back().segment;
    const Vec3 along = scene.gravity_mps2 - math::dot(scene.gravity_mps2, n) * n;
    const Vec3 off = rolling.flight.acceleration_mps2 - 5.0 / 7 * along;
    EXPECT_LT(math::norm(off), 1e-14);
    // Rolling began at once, from rest, and the ball stays at its height above the slope.
    EXPECT_LT(seconds(rolling.flight.begin - Tick{}), 2e-3);
    const double height_m = math::dot(n, last_place(run)) - k_radius_m;
    EXPECT_GT(height_m, 0);
    EXPECT_LT(height_m, 2 * k_touch_m);
    EXPECT_NEAR(math::norm(last_place(run)), 2.5 / 7 * math::norm(along), 2e-3);
  }
}

TEST(Modes, RollingFrictionStopsAMarble) {
  // Goal: rolling friction stops a ball after the distance v^2 / (2 c g). The ball then rests
  // without events.
  constexpr double k_c = 0.02;
  Scene scene = scene_with({.restitution = 0, .friction = 0.4, .rolling_friction = k_c});
  scene.planes.push_back(plane({0, 0, 1}));
  scene.bodies.push_back(
      marble({0, 0, k_radius_m + k_close_m}, {0.3, 0, 0}, {0, 0.3 / k_radius_m, 5}));
  const RecordedRun run = testing::recorded(scene, 4);
  ASSERT_EQ(run.error, "");
  EXPECT_EQ(last_mode(run), MotionMode::resting);
  EXPECT_NEAR(last_place(run).x(), 0.09 / (2 * k_c * k_g_mps2), 1e-3);
  EXPECT_LT(run.counts.events(), 20U);
}

TEST(Modes, SeamsOfAFlatMeshAreNotFelt) {
  // Goal: a marble rolls over a flat floor of triangles as over a plane: its speed and height are
  // the same. Method: let a marble cross a flat sheet of triangles at an angle.
  Scene scene = scene_with({.restitution = 0.5, .friction = 0.4});
  std::vector<Vec3> vertices_m;
  std::vector<TriangleCorners> triangles;
  for (std::uint32_t y = 0; y < 12; ++y) {
    for (std::uint32_t x = 0; x < 12; ++x)
      vertices_m.emplace_back(0.03 * x, 0.03 * y, 0);
  }
  for (std::uint32_t y = 0; y + 1 < 12; ++y) {
    for (std::uint32_t x = 0; x + 1 < 12; ++x) {
      const std::uint32_t at = 12 * y + x;
      triangles.push_back({at, at + 1, at + 13});
      triangles.push_back({at, at + 13, at + 12});
    }
  }
  scene.meshes.push_back(
      {.name = "floor",
       .mesh = std::make_shared<const TriangleMesh>(
           TriangleMesh::make(vertices_m, triangles, MeshClosure::may_be_open).value())});
  const Vec3 v(0.4, 0.23, 0);
  scene.bodies.push_back(marble({0.02, 0.05, k_radius_m + k_close_m}, v,
                                {-v.y() / k_radius_m, v.x() / k_radius_m, 0}));
  const RecordedRun run = testing::recorded(scene, 0.5);
  ASSERT_EQ(run.error, "");
  // The marble crosses about fourteen seams, and each seam causes two segments.
  EXPECT_GT(run.counts.modes, 10U);
  EXPECT_LT(run.recording.segments({0}).size(), 40U);
  const Vec3 expected = scene.bodies[0].start.pose.position_m + 0.5 * v;
  EXPECT_NEAR(last_place(run).x(), expected.x(), 1e-9);
  EXPECT_NEAR(last_place(run).y(), expected.y(), 1e-9);
  EXPECT_GT(last_place(run).z(), k_radius_m);
  EXPECT_LT(last_place(run).z(), k_radius_m + k_touch_m);
}

std::shared_ptr<const ConvexPolyhedron> block(const Vec3& low_m, const Vec3& high_m) {
  std::vector<Vec3> corners_m;
  for (const double x : {low_m.x(), high_m.x()}) {
    for (const double y : {low_m.y(), high_m.y()}) {
      for (const double z : {low_m.z(), high_m.z()})
        corners_m.emplace_back(x, y, z);
    }
  }
  return std::make_shared<const ConvexPolyhedron>(convex_hull(corners_m).value());
}

TEST(Modes, AMarbleRollsOffATable) {
  // Goal: at 0.5 m/s, above sqrt(g r) = 0.31 m/s, a marble leaves the edge level and flies on a
  // parabola. At 0.1 m/s, the marble rolls around the edge and converts height to speed. Method:
  // test the velocity at the start of the flight, the energy and the number of segments.
  for (const double speed_mps : {0.5, 0.1}) {
    Scene scene = scene_with({.restitution = 0.3, .friction = 0.6});
    scene.convexes.push_back(
        {.name = "table", .polyhedron = block({-0.2, -0.1, -0.5}, {0, 0.1, 0}), .material = {}});
    scene.bodies.push_back(marble({-0.05, 0, k_radius_m + k_close_m}, {speed_mps, 0, 0},
                                  {0, speed_mps / k_radius_m, 0}));
    const RecordedRun run = testing::recorded(scene, 0.05 / speed_mps + 0.15);
    ASSERT_EQ(run.error, "");
    const auto entries = run.recording.segments({0});
    EXPECT_LT(entries.size(), 2000U) << speed_mps;
    EXPECT_EQ(last_mode(run), MotionMode::free);
    EXPECT_LT(last_place(run).z(), -0.01);
    EXPECT_GT(last_place(run).x(), 0);
    const double before =
        energy_jpkg(scene, 0, entries.front().segment, entries.front().cause.tick);
    const double after = energy_jpkg(scene, 0, entries.back().segment, run.recording.end());
    EXPECT_LT(after, before + 1e-13);
    // Impacts at the edge take some energy.
    EXPECT_GT(after, before - 0.2 * k_g_mps2 * k_radius_m);
    if (speed_mps > 0.4) {
      EXPECT_LT(entries.size(), 10U);
      EXPECT_NEAR(entries.back().segment.flight.velocity_mps.x(), speed_mps, 1e-9);
      EXPECT_NEAR(entries.back().segment.flight.position_m.x(), 0, 1e-6);
    }
  }
}

TEST(Modes, AMarbleRollsInAValley) {
  // Goal: between two planes at a right angle, a ball rolls with the acceleration g sin(slope) / (1
  // + 2/5 (r / d)^2). Here, d = r / sqrt(2) is the distance of the ball's centre from the line of
  // both contacts.
  Scene scene = scene_with({.restitution = 0.2, .friction = 0.5});
  const Vec3 along = math::normalized(Vec3(1, 0, -0.2));
  const Vec3 up = math::normalized(Vec3(0.2, 0, 1));
  const Vec3 side(0, 1, 0);
  const Vec3 left = math::normalized(up + side);
  const Vec3 right = math::normalized(up - side);
  scene.planes.push_back(plane(left));
  scene.planes.push_back(plane(right));
  scene.bodies.push_back(marble((std::numbers::sqrt2 * (k_radius_m + k_close_m)) * up));
  const RecordedRun run = testing::recorded(scene, 1);
  ASSERT_EQ(run.error, "");
  EXPECT_EQ(last_mode(run), MotionMode::rolling);
  EXPECT_LT(run.counts.events(), 40U);
  EXPECT_LT(run.recording.segments({0}).size(), 12U);
  const Segment& segment = run.recording.segments({0}).back().segment;
  const double known_mps2 = k_g_mps2 * -along.z() / (1 + 0.4 * 2);
  EXPECT_LT(math::norm(segment.flight.acceleration_mps2 - known_mps2 * along), 1e-13);
  const Twist twist = testing::twist_in(segment, scene.bodies[0].inertia, run.recording.end());
  for (const Vec3& n : {left, right}) {
    const Vec3 slip =
        twist.velocity_mps - k_radius_m * math::cross(twist.angular_velocity_radps, n);
    EXPECT_LT(math::norm(slip), 1e-6);
  }
}

TEST(Modes, AMarbleComesToRestInACorner) {
  // Goal: if three walls that lean outwards hold a ball, the ball loses its spin and rests after
  // few events.
  Scene scene = scene_with({.restitution = 0.4, .friction = 0.4});
  for (const Vec3& n : {Vec3(1, 0, 0.7), Vec3(-0.5, 0.8, 0.6), Vec3(-0.4, -0.9, 0.7)})
    scene.planes.push_back(plane(n));
  scene.bodies.push_back(marble({0.002, 0.001, 0.04}, {0.05, 0, 0}, {30, -20, 10}));
  const RecordedRun run = testing::recorded(scene, 3);
  ASSERT_EQ(run.error, "");
  EXPECT_EQ(last_mode(run), MotionMode::resting);
  EXPECT_LT(run.counts.events(), 500U);
}

TEST(Modes, AMarbleThatLeansOnARestingCubeTakesFewEvents) {
  // Goal: if a marble rolls down a slope against a cube, the simulation doesn't stall, and the
  // marble doesn't sink into the cube. Method: let a marble roll against a cube on a gentle slope,
  // where friction holds the cube. Count the events, and compute the least clearance between marble
  // and cube.
  Scene scene = scene_with({.restitution = 0.3, .friction = 0.6});
  scene.planes.push_back(plane({0.1, 0, 1}));
  const Vec3 n = math::normalized(Vec3(0.1, 0, 1));
  const BodyShape solid =
      in_body_frame(std::vector{cube(0.02).value()}, 2500, InertiaSymmetry::spherical).value();
  scene.bodies.push_back(marble({-0.03, 0.002, 0.014}));
  scene.bodies.push_back({.name = {},
                          .shape = std::make_shared<const Compound>(Compound{.parts = solid.parts}),
                          .inertia = solid.inertia,
                          .start = {.pose = {.position_m = (0.01 + 1e-6) * n,
                                             .orientation = math::quaternion_of_rotation_vector(
                                                 {0, std::atan(0.1), 0})},
                                    .twist = {}}});
  const RecordedRun run = testing::recorded(scene, 3);
  ASSERT_EQ(run.error, "");
  EXPECT_LT(run.counts.events(), 5'000U);
  EXPECT_GT(run.counts.collisions, 0U);
  double least_m = 1;
  for (const Recording::Entry& entry : run.recording.segments({0})) {
    const Tick tick = entry.cause.tick;
    const Segment& of_cube = *run.recording.segment_at({1}, tick);
    const Pose pose{testing::place_at(of_cube, tick),
                    testing::turn_at(of_cube, run.scene.bodies[1].inertia, tick)};
    const double distance_m = testing::distance(testing::place_at(entry.segment, tick),
                                                testing::solid_at(solid.parts[0], pose));
    least_m = std::min(least_m, distance_m - k_radius_m);
  }
  std::printf("%llu events, %llu collisions of the pair, clearance at least %.2e m\n",
              static_cast<unsigned long long>(run.counts.events()),
              static_cast<unsigned long long>(run.counts.collisions), least_m);
  EXPECT_GT(least_m, -1e-9);
  EXPECT_LT(least_m, 2 * k_touch_m);
}

TEST(Modes, MarblesGainNoEnergyAndNeverSink) {
  // Goal: unless another marble collides with a marble, no event gives the marble more energy than
  // at the start of its segment. During a segment on a plane, a marble gains no energy. During a
  // segment on an edge, a marble gains at most the energy with which the load lifts it
  // (edge_motion.h). No marble jumps or sinks into a plane. Method: test each marble's energy and
  // place in all segments of the scene "marbles". The scene has slopes, valleys, corners, a ridge
  // and a pedestal.
  std::uint64_t staying = 0;
  double worst_gain = 0;
  double worst_lift = 0;
  double worst_jump_m = 0;
  double lowest_m = 1;
  for (const std::uint64_t seed : property::seeds(40)) {
    const scenes::Setting setting = scenes::marbles(12, seed);
    const RecordedRun run = testing::recorded(setting.scene, 1);
    ASSERT_EQ(run.error, "") << "seed " << seed;
    for (std::uint32_t body = 0; body < 12; ++body) {
      const auto entries = run.recording.segments({body});
      const double radius_m = std::get<Sphere>(setting.scene.bodies[body].shape).radius_m;
      for (std::size_t i = 0; i < entries.size(); ++i) {
        const Segment& segment = entries[i].segment;
        const Tick begin = segment.flight.begin;
        const Tick end =
            i + 1 < entries.size() ? entries[i + 1].segment.flight.begin : run.recording.end();
        const Vec3 place_m = testing::place_at(segment, end);
        const double last = energy_jpkg(setting.scene, body, segment, end);
        const double first = energy_jpkg(setting.scene, body, segment, begin);
        if (in_contact(segment)) {
          ++staying;
          const bool on_a_plane = std::ranges::any_of(setting.scene.planes, [&](const auto& wall) {
            return math::dot(wall.outside.normal, segment.flight.position_m) -
                       wall.outside.offset_m - radius_m <
                   1e-6;
          });
          double& worst = on_a_plane ? worst_gain : worst_lift;
          worst = std::max(worst, last - first);
        }
        if (i + 1 < entries.size()) {
          const Segment& next = entries[i + 1].segment;
          worst_jump_m = std::max(worst_jump_m, math::norm(place_m - next.flight.position_m));
          // If no other marble takes part in an event, the event may not add energy.
          const EventKey& cause = entries[i + 1].cause;
          const bool alone = cause.kind == EventKind::mode ||
                             (cause.kind == EventKind::collision && (cause.higher >> 31U) != 0);
          if (alone) {
            const double then = energy_jpkg(setting.scene, body, next, end);
            worst_gain = std::max({worst_gain, then - first, then - last});
          }
        }
        for (const StaticPlane& wall : setting.scene.planes) {
          lowest_m = std::min(
              lowest_m, math::dot(wall.outside.normal, place_m) - wall.outside.offset_m - radius_m);
        }
      }
    }
  }
  std::printf(
      "%llu segments in contact; gain of energy at most %.1e J/kg (over edges meanwhile %.1e), "
      "jumps %.1e m, gap %.2e m\n",
      static_cast<unsigned long long>(staying), worst_gain, worst_lift, worst_jump_m, lowest_m);
  if (property::all_cases()) {
    EXPECT_GT(staying, 2000U);
  }
  EXPECT_LT(worst_gain, 1e-13);
  EXPECT_LT(worst_lift, 1e-4);
  EXPECT_LT(worst_jump_m, 1e-14);
  EXPECT_GT(lowest_m, -1e-9);
}

}  // namespace sleight::physics::modes_test
