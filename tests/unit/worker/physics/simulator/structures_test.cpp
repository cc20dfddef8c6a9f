#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "common/math/vector.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "worker/physics/shape/mass_properties.h"

namespace sleight::physics::structures_test {

using testing::floor_scene;
using testing::RecordedRun;

constexpr int k_wall_rows = 8;
constexpr int k_wall_places = 12;

BodyDescription box_at(const Vec3& sides_m, const Vec3& centre_m, double density_kgpm3 = 1000) {
  const ConvexPolyhedron polyhedron = box(sides_m).value();
  const BodyShape shape =
      in_body_frame({&polyhedron, 1}, density_kgpm3, InertiaSymmetry::general).value();
  return {.name = {},
          .shape = std::make_shared<const Compound>(Compound{shape.parts}),
          .inertia = shape.inertia,
          .start = {.pose = {.position_m = centre_m, .orientation = shape.frame.orientation},
                    .twist = {}}};
}

Vec3 end_of(const RecordedRun& run, std::uint32_t body) {
  return testing::place_at(run.recording.segments({body}).back().segment, run.recording.end());
}
bool rests(const RecordedRun& run, std::uint32_t body) {
  return run.recording.segments({body}).back().segment.mode == MotionMode::resting;
}

TEST(Structures, APlankTipsUnderAGentleLoad) {
  // Goal: a resting plank extends over an edge. The plank holds a light load on its free end, but
  // tips under a heavy load, even if no blow wakes it. Method: let 0.4 of the plank's length extend
  // over the edge. Release a load of 0.1 or 0.4 times the plank's mass a few micrometres above the
  // free end.
  for (const double load : {0.1, 0.4}) {
    Scene scene = floor_scene(0.05, {.restitution = 0.2, .friction = 0.6});
    scene.convexes.push_back({.name = "step",
                              .polyhedron = std::make_shared<const ConvexPolyhedron>(
                                  convex_hull(std::vector<Vec3>{{-1, -1, 0},
                                                                {0, -1, 0},
                                                                {-1, 1, 0},
                                                                {0, 1, 0},
                                                                {-1, -1, 0.2},
                                                                {0, -1, 0.2},
                                                                {-1, 1, 0.2},
                                                                {0, 1, 0.2}})
                                      .value())});
    // The plank's centre is 0.05 inside the edge, and its end is 0.2 outside.
    scene.bodies.push_back(box_at({0.5, 0.1, 0.02}, {-0.05, 0, 0.21 + 1e-6}));
    const Vec3 size(0.04, 0.04, 0.03);
    BodyDescription weight = box_at(size, {0.18, 0, 0.22 + 0.015 + 5e-6});
    const double share = load * scene.bodies[0].inertia.mass_kg / weight.inertia.mass_kg;
    weight.inertia.mass_kg *= share;
    weight.inertia.principal_kgm2 *= share;
    weight.start_tick = Tick{} + ticks_after(0.5);
    scene.bodies.push_back(weight);
    const RecordedRun run = testing::recorded(scene, 4);
    ASSERT_EQ(run.error, "");
    ASSERT_EQ(run.recording.segment_at({0}, Tick{} + ticks_after(0.5) - 1)->mode,
              MotionMode::resting);
    // Moments about the edge are divided by the plank's weight. The plank's moment is 0.05 m, and
    // the load's moment is 0.18 m * load.
    EXPECT_EQ(end_of(run, 1).z() < 0.2, load * 0.18 > 0.05) << load;
    EXPECT_TRUE(rests(run, 0));
    EXPECT_TRUE(rests(run, 1));
  }
}

TEST(Structures, AWallTakesTheMomentumOfABall) {
  // Goal: a heavy ball's momentum passes to a wall of resting bricks, although a single brick could
  // resist each small blow. Friction takes little of the momentum. Method: test the total momentum
  // just after the hit and a twentieth of a second later.
  Scene scene = floor_scene(0.1, {.restitution = 0.2, .friction = 0.5});
  const ConvexPolyhedron polyhedron = box({0.2, 0.1, 0.1}).value();
  const BodyShape brick = in_body_frame({&polyhedron, 1}, 1500, InertiaSymmetry::general).value();
  const auto shape = std::make_shared<const Compound>(Compound{brick.parts});
  for (int row = 0; row < k_wall_rows; ++row) {
    for (int place = 0; place < k_wall_places; ++place) {
      const Vec3 centre_m(0.2005 * place + (row % 2 == 0 ? 0 : 0.1), 0, 0.05 + 0.1 * row);
      scene.bodies.push_back(
          {.name = {},
           .shape = shape,
           .inertia = brick.inertia,
           .start = {.pose = {.position_m = centre_m, .orientation = brick.frame.orientation},
                     .twist = {}},
           .rests = true});
    }
  }
  scene.bodies.push_back({.name = "ball",
                          .shape = Sphere{.radius_m = 0.15},
                          .inertia = solid_ball_inertia(30, 0.15),
                          .start = {.pose = {.position_m = {0.1 * k_wall_places, -0.3, 0.5}},
                                    .twist = {.velocity_mps = {0, 5, 1}}}});
  auto started = Simulation::start(scene, {});
  ASSERT_TRUE(started.ok()) << started.error().message;
  Simulation simulation = std::move(started).value();
  for (const double time_s : {0.06, 0.11}) {
    const auto error = simulation.run_until(Tick{} + ticks_after(time_s));
    ASSERT_FALSE(error) << error->message;
    double momentum_ns = 0;
    for (std::uint32_t body = 0; body < scene.bodies.size(); ++body)
      momentum_ns += scene.bodies[body].inertia.mass_kg *
                     simulation.twist({body}, simulation.now()).velocity_mps.y();
    EXPECT_GT(momentum_ns, 0.95 * 150) << time_s;
  }
}

}  // namespace sleight::physics::structures_test
