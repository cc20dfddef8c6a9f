// Goal: the event loop allocates nothing once its lists have grown. Method: count calls of operator
// new; after a quarter of a run, the count must stay constant. This test is a separate program
// because operator new belongs to a whole program.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/engines/engines.h"
#include "tests/scenes/shared/scenes.h"
#include "tests/unit/worker/physics/collision/surface_tables.h"
#include "tests/unit/worker/physics/counted_allocations.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics {
namespace {

using counting::allocations;

struct Case {
  const char* name;
  scenes::Setting setting;
  double duration_s;
};

std::uint64_t allocations_after_warm_up(const Scene& scene, double duration_s,
                                        const SimulationOptions& options) {
  auto started = Simulation::start(scene, options);
  EXPECT_TRUE(started.ok());
  Simulation simulation = std::move(started).value();
  const TickCount quarter = ticks_after(duration_s / 4);
  EXPECT_FALSE(simulation.run_until(Tick{} + quarter));
  const std::uint64_t events = simulation.counts().events();
  const std::uint64_t before = allocations;
  const auto error = simulation.run_until(Tick{} + 4 * quarter);
  const std::uint64_t after = allocations;
  EXPECT_FALSE(error);
  EXPECT_GT(simulation.counts().events(), events + 100);
  return after - before;
}

TEST(Allocation, TheEventLoopAllocatesNothing) {
  const Case cases[]{{"gas", scenes::hard_sphere_gas(500, 0.3, 1), 8},
                     {"dense gas", scenes::hard_sphere_gas(500, 0.5, 1), 2},
                     {"boxed spheres", scenes::boxed_spheres(64, 1), 200},
                     {"boxed polyhedra", scenes::boxed_polyhedra(30, 1), 80},
                     {"rain", scenes::rain(40, 1), 0.9},
                     {"heap", scenes::grain_heap(30, 1), 0.6},
                     {"hourglass", scenes::hourglass(20, 1), 2}};
  for (const Case& one : cases) {
    for (const BroadPhaseKind boxes :
         {BroadPhaseKind::hierarchical_grid, BroadPhaseKind::sweep_and_prune}) {
      for (const QueueKind queue : {QueueKind::tournament, QueueKind::heap, QueueKind::calendar}) {
        SimulationOptions options;
        options.record = false;
        options.make_engine = engine_with(boxes, queue);
        EXPECT_EQ(allocations_after_warm_up(one.setting.scene, one.duration_s, options), 0U)
            << one.name << ", broad phase " << static_cast<int>(boxes) << ", queue "
            << static_cast<int>(queue);
      }
    }
  }
}

TEST(Allocation, SurfacesAllocateForPatchesAndTouchesOnly) {
  // Goal: searches on surfaces allocate nothing once nearby patches exist, except when the list of
  // touches doubles. Method: let a die bounce in place without loss. The list may double four
  // times, to 16 times its size after the first quarter of the run.
  Scene scene = testing::thrown_dice(1, 1,
                                     testing::table_surface(testing::table_of([](GridIndex) {
                                                              return SurfaceControl{
                                                                  .restitution = 1, .friction = 0};
                                                            }),
                                                            0.02));
  scene.bodies[0].start.twist.velocity_mps = {0, 0, 0};
  scene.slow = {};
  SimulationOptions options;
  options.record = false;
  EXPECT_LE(allocations_after_warm_up(scene, 40, options), 4U);
}

TEST(Allocation, IsSeen) {
  // Goal: the test counts allocations. Method: reserve too little space for the recording.
  SimulationOptions options;
  options.segments_reserved = 1;
  EXPECT_GT(allocations_after_warm_up(scenes::boxed_spheres(20, 1).scene, 100, options), 0U);
}

}  // namespace
}  // namespace sleight::physics
