#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/math/vector.h"
#include "tests/scenes/shared/random_starts.h"
#include "tests/scenes/shared/scenes.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/distance/round_oracle.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "worker/physics/distance/round_distance.h"
#include "worker/physics/motion/invariants.h"
#include "worker/physics/scene/static_geometry.h"

namespace sleight::physics {
namespace {

using testing::RecordedRun;

/// A random height field of triangles. Round bodies of all kinds and a block are above it.
Scene round_bodies_on_bumps(std::uint64_t seed) {
  Scene scene = scenes::round_solids(8, seed).scene;
  const Scene bumps = scenes::bumpy_floor(1, seed).scene;
  scene.planes = bumps.planes;
  scene.meshes = bumps.meshes;
  return scene;
}

const Compound* compound_of(const BodyDescription& body) {
  const auto* shape = std::get_if<std::shared_ptr<const Compound>>(&body.shape);
  return shape != nullptr ? shape->get() : nullptr;
}

/// Separation along closest_round()'s normal, computed by plain_reach_m().
double separation_m(const ConvexView& own, const PlacedPose& place, const MovingPiece& other,
                    Vec3* along = nullptr) {
  const Vec3 axis = closest_round(own, place, *other.view, other.pose).normal;
  if (along != nullptr) *along = axis;
  return -testing::plain_reach_m(own, place, axis) -
         testing::plain_reach_m(*other.view, other.pose, -axis);
}

TEST(RoundStatics, NothingSinksIntoTrianglesAndBlocks) {
  // Goal: no round body is more than two micrometres deep in a triangle or a block. No round body
  // falls through. Method: at random ticks, compute separation_m() for each body and each static
  // piece. A triangle has no inside, so only triangles that face the body's centre count.
  double deepest_m = 0;
  int near_triangles = 0;
  int near_block = 0;
  int pushed_ones = 0;
  for (const std::uint64_t seed : property::cases(property::long_run() ? 100 : 4)) {
    const Scene scene = round_bodies_on_bumps(seed + 5);
    const RecordedRun run = testing::recorded(scene, 0.8);
    ASSERT_EQ(run.error, "");
    const StaticGeometry statics(scene);
    random::Stream stream = scenes::stream_of_scene(seed, 9);
    for (int look = 0; look < 60; ++look) {
      const Tick tick = Tick{} + ticks_after(scenes::between(stream, 0.05, 0.8));
      for (std::uint32_t body = 0; body < scene.bodies.size(); ++body) {
        const Compound* compound = compound_of(scene.bodies[body]);
        if (compound == nullptr || compound->round_parts.empty()) continue;
        const Segment& segment = *run.recording.segment_at({body}, tick);
        const PlacedPose place =
            placed({testing::place_at(segment, tick),
                    testing::turn_at(segment, scene.bodies[body].inertia, tick)});
        EXPECT_GT(place.position_m.z(), -0.02) << seed << ": body " << body << " fell through";
        const ConvexView own = compound->view(0);
        for (PieceId piece{statics.plane_count()}; piece < statics.piece_count(); ++piece) {
          const MovingPiece& other = statics.piece(piece);
          const bool is_triangle = other.view->vertex_count == 3;
          if (is_triangle) {
            const Vec3 to_centre_m = place.position_m - other.view->vertices_m[0];
            if (math::dot(other.view->faces[0].normal, to_centre_m) <= 0) continue;
          }
          Vec3 axis;
          const double gap_m = separation_m(own, place, other, &axis);
          if (gap_m < 1e-5) ++(is_triangle ? near_triangles : near_block);
          deepest_m = std::max(deepest_m, -gap_m);
          if (gap_m > 1e-6) continue;
          // If the body were 5 micrometres deeper, the test would notice it.
          PlacedPose pushed = place;
          pushed.position_m += 5e-6 * axis;
          ASSERT_LT(separation_m(own, pushed, other), -2e-6) << seed;
          ++pushed_ones;
        }
      }
    }
  }
  fmt::print("deepest: {:.2e} m; within 10 micrometres {} times of triangles, {} of blocks\n",
             deepest_m, near_triangles, near_block);
  EXPECT_LT(deepest_m, 2e-6);
  if (property::all_cases()) {
    EXPECT_GT(near_triangles, 50);
    EXPECT_GT(near_block, 5);
    EXPECT_GT(pushed_ones, 20);
  }
}

TEST(RoundStatics, NeverGainEnergyOnTriangles) {
  // Goal: the energy of round bodies with friction and loss never increases on a height field.
  // Method: compare kinetic plus potential energy at regular times.
  for (const std::uint64_t seed : property::cases(property::long_run() ? 100 : 4)) {
    const Scene scene = round_bodies_on_bumps(seed + 31);
    auto started = Simulation::start(scene, {});
    ASSERT_TRUE(started.ok()) << started.error().message;
    Simulation simulation = std::move(started).value();
    double before_j = 1e300;
    for (int look = 1; look <= 60; ++look) {
      const auto error = simulation.run_until(Tick{} + ticks_after(0.02 * look));
      ASSERT_FALSE(error) << error->message;
      double now_j = 0;
      for (std::uint32_t body = 0; body < scene.bodies.size(); ++body) {
        const Inertia& inertia = scene.bodies[body].inertia;
        const Pose pose = simulation.pose({body}, simulation.now());
        now_j += kinetic_energy_j(inertia, pose.orientation,
                                  simulation.twist({body}, simulation.now())) -
                 inertia.mass_kg * math::dot(scene.gravity_mps2, pose.position_m);
      }
      ASSERT_LT(now_j, before_j + 1e-12) << seed << ", look " << look;
      before_j = now_j;
    }
  }
}

}  // namespace
}  // namespace sleight::physics
