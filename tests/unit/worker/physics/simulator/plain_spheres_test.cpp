// Tests spheres that only fly. The spheres' segments are written only on request (Bodies::fly_on).
#include <gtest/gtest.h>

#include <utility>

#include "common/math/vector.h"
#include "tests/scenes/shared/random_starts.h"
#include "tests/scenes/shared/scenes.h"
#include "tests/support/property.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics {
namespace {

/// Elastic spheres of two sizes between walls. Later, one sphere gets a spin, and another sphere
/// gets a push.
Scene spheres_in_a_box(std::uint64_t seed) {
  Scene scene = scenes::boxed_spheres(24, seed).scene;
  random::Stream stream = scenes::stream_of_scene(seed, 3);
  scene.controls.push_back({.tick = Tick{} + ticks_after(1.0),
                            .body = {3},
                            .velocity_change_mps = scenes::vector_between(stream, -1, 1),
                            .angular_velocity_change_radps = {0, 0, 5}});
  scene.controls.push_back({.tick = Tick{} + ticks_after(1.5),
                            .body = {4},
                            .velocity_change_mps = scenes::vector_between(stream, -1, 1),
                            .angular_velocity_change_radps = Vec3::Zero()});
  return scene;
}

struct End {
  std::vector<Vec3> places_m;
  std::vector<Vec3> velocities_mps;
  double energy_j = 0;
  std::uint64_t digest = 0;
};

End end_of(const Scene& scene, SimulationOptions options, int pieces) {
  auto started = Simulation::start(scene, options);
  EXPECT_TRUE(started.ok());
  Simulation simulation = std::move(started).value();
  End end;
  for (int piece = 1; piece <= pieces; ++piece) {
    const auto error = simulation.run_until(Tick{} + ticks_after(4.0 * piece / pieces));
    EXPECT_FALSE(error) << error->message;
    // Reading the energy writes segments.
    if (piece % 2 == 0) end.energy_j = simulation.kinetic_energy_j();
  }
  for (std::uint32_t body = 0; body < scene.bodies.size(); ++body) {
    end.places_m.push_back(simulation.pose({body}, simulation.now()).position_m);
    end.velocities_mps.push_back(simulation.twist({body}, simulation.now()).velocity_mps);
  }
  end.energy_j = simulation.kinetic_energy_j();
  if (options.record) end.digest = simulation.recording().digest();
  return end;
}

TEST(PlainSpheres, AreTheSameRecordedOrNot) {
  // Goal: a segment that is written late has the same bits as a recorded segment. Method: run
  // spheres between walls with three algorithms. Some runs keep a recording, some keep a history,
  // some keep both, and some keep neither. Some runs have several portions. Between portions, the
  // test reads the energy.
  for (const std::uint64_t seed : property::cases(property::long_run() ? 200 : 6)) {
    const Scene scene = spheres_in_a_box(seed + 1);
    SimulationOptions all_pairs;
    all_pairs.algorithm = Algorithm::all_pairs;
    const End reference = end_of(scene, all_pairs, 1);
    for (const Algorithm algorithm : {Algorithm::asynchronous, Algorithm::synchronous}) {
      for (int way = 0; way < 8; ++way) {
        SimulationOptions options;
        options.algorithm = algorithm;
        options.record = (way & 1) != 0;
        options.keep_history = (way & 2) != 0;
        const End end = end_of(scene, options, (way & 4) != 0 ? 37 : 1);
        EXPECT_EQ(end.places_m, reference.places_m) << seed << ", way " << way;
        EXPECT_EQ(end.velocities_mps, reference.velocities_mps) << seed << ", way " << way;
        EXPECT_EQ(end.energy_j, reference.energy_j) << seed << ", way " << way;
        if (options.record) {
          EXPECT_EQ(end.digest, reference.digest) << seed << ", way " << way;
        }
      }
    }
  }
}

}  // namespace
}  // namespace sleight::physics
