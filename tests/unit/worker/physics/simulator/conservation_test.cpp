#include <gtest/gtest.h>

#include <map>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/simulator/fixed_and_filtered.h"
#include "tests/unit/worker/physics/simulator/mixed_scene.h"
#include "tests/unit/worker/physics/simulator/noised_scenes.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "tests/unit/worker/physics/simulator/scenes_under_test.h"

namespace sleight::physics {
namespace {

using testing::RecordedRun;

Simulation begun(const Scene& scene) {
  SimulationOptions options;
  options.record = false;
  auto started = Simulation::start(scene, options);
  EXPECT_TRUE(started.ok());
  return std::move(started).value();
}

std::uint64_t collisions_of(const Simulation& simulation) {
  return simulation.counts().collisions + simulation.counts().static_collisions;
}

/// Largest relative deviation of the kinetic energy from its initial value.
double drift_of(const Scene& scene, std::uint64_t collisions, double step_s) {
  Simulation simulation = begun(scene);
  const double at_first_j = simulation.kinetic_energy_j();
  double drift = 0;
  while (collisions_of(simulation) < collisions) {
    const auto error = simulation.run_until(simulation.now() + ticks_after(step_s));
    if (error) {
      ADD_FAILURE() << error->message;
      break;
    }
    drift = std::max(drift, std::fabs(simulation.kinetic_energy_j() / at_first_j - 1));
  }
  std::printf("%llu collisions, %.4g s: drift of energy %.2e\n",
              static_cast<unsigned long long>(collisions_of(simulation)),
              seconds(simulation.now() - Tick{}), drift);
  return drift;
}

TEST(Conservation, AGasKeepsItsEnergy) {
  // Goal: if collisions lose no energy, the energy of a gas drifts by less than 1e-9 over 1e5
  // collisions. Method: run scenes without gravity, where all energy is kinetic, and measure the
  // energy at intervals.
  EXPECT_LT(drift_of(scenes::hard_sphere_gas(108, 0.4, 1).scene, 100'000, 1), 1e-9);
  EXPECT_LT(drift_of(scenes::hard_sphere_gas(500, 0.1, 2).scene, 100'000, 1), 1e-9);
  EXPECT_LT(drift_of(scenes::boxed_spheres(64, 3).scene, 100'000, 20), 1e-9);
}

TEST(Conservation, PolyhedraKeepTheirEnergy) {
  // Goal: the energy of colliding polyhedra doesn't drift, although their translation and rotation
  // exchange energy. The long run has the number of collisions that the project promises.
  const std::uint64_t collisions = property::long_run() ? 100'000 : 4'000;
  EXPECT_LT(drift_of(scenes::boxed_polyhedra(12, 1).scene, collisions, 20), 1e-9);
}

TEST(Conservation, APeriodicGasKeepsItsMomentum) {
  // Goal: a gas in a periodic box keeps its total momentum. Method: compare the total momentum at
  // the start and at the end. The tolerance is relative to the sum of the momenta's magnitudes.
  const scenes::Setting setting = scenes::hard_sphere_gas(256, 0.3, 4);
  Simulation simulation = begun(setting.scene);
  const auto momentum = [&]() -> Vec3 {
    Vec3 sum = Vec3::Zero();
    for (std::uint32_t body = 0; body < setting.scene.bodies.size(); ++body)
      sum += setting.scene.bodies[body].inertia.mass_kg *
             simulation.twist({body}, simulation.now()).velocity_mps;
    return sum;
  };
  const Vec3 before = momentum();
  ASSERT_FALSE(simulation.run_until(Tick{} + ticks_after(20)));
  EXPECT_GT(simulation.counts().collisions, 10'000U);
  EXPECT_LT(math::norm(momentum() - before), 1e-9 * 256);
}

/// Energy changes at events. A change is summed over the bodies that begin a segment at the event.
struct EnergyChanges {
  double largest_gain = 0;  ///< relative to the energy of these bodies
  double total_loss_j = 0;
  EventKey where;
};

EnergyChanges energy_changes_of(const RecordedRun& run) {
  struct Sum {
    double before_j = 0;
    double after_j = 0;
    double scale_j = 0;
  };
  std::map<EventKey, Sum> sums;
  for (std::uint32_t body = 0; body < run.scene.bodies.size(); ++body) {
    const auto entries = run.recording.segments({body});
    for (std::size_t i = 1; i < entries.size(); ++i) {
      const Tick tick = entries[i].segment.flight.begin;
      Sum& sum = sums[entries[i].cause];
      const double before_j = testing::energy_j(run.scene, body, entries[i - 1].segment, tick);
      sum.before_j += before_j;
      sum.after_j += testing::energy_j(run.scene, body, entries[i].segment, tick);
      sum.scale_j += std::fabs(before_j);
    }
  }
  EnergyChanges changes;
  for (const auto& [key, sum] : sums) {
    const double gain = (sum.after_j - sum.before_j) / sum.scale_j;
    if (gain > changes.largest_gain) {
      changes.largest_gain = gain;
      changes.where = key;
    }
    changes.total_loss_j += sum.before_j - sum.after_j;
  }
  return changes;
}

/// Returns the scene without user controls, because they can add energy.
Scene without_controls(Scene scene) {
  scene.controls.clear();
  return scene;
}

TEST(Conservation, EventsGainNoEnergy) {
  // Goal: no event gains energy, for any friction, restitution and contact noise. Method: record
  // scenes of every kind, without user controls. Compare the bodies' kinetic plus potential energy
  // before and after each event. Another test covers the motion between events.
  double largest = 0;
  const auto look = [&](const Scene& scene, double duration_s, const std::string& name) {
    const RecordedRun run = testing::recorded(without_controls(scene), duration_s);
    ASSERT_EQ(run.error, "") << name;
    const EnergyChanges changes = energy_changes_of(run);
    EXPECT_LT(changes.largest_gain, 1e-12)
        << name << ", tick " << changes.where.tick.value << ", body " << changes.where.lower;
    largest = std::max(largest, changes.largest_gain);
  };
  for (const std::uint64_t n :
       property::cases(property::long_run() ? 1200 : property::of_tier(27, 120))) {
    const testing::TestScene scene = testing::test_scene(n);
    look(scene.setting.scene, scene.setting.duration_s,
         "scene " + std::to_string(n) + ": " + scene.name);
  }
  for (const std::uint64_t seed : property::seeds(property::of_tier(2, 8))) {
    look(testing::mixed_scene(seed), 0.6, "mixed scene " + std::to_string(seed));
    testing::Dice dice(20270312, seed);
    look(testing::fixed_and_filtered(testing::mixed_scene(seed), dice), 0.6,
         "mixed scene with fixed bodies " + std::to_string(seed));
    Scene noised = testing::mixed_scene(seed);
    testing::add_noise(noised, 0.05, dice);
    noised.noise.tilt_sd_rad = 0.3;
    look(noised, 0.6, "mixed scene with noise " + std::to_string(seed));
  }
  std::printf("largest gain of an event, of its bodies' energy: %.2e\n", largest);
}

TEST(Conservation, AGainIsSeen) {
  // Goal: energy_changes_of() finds a gain. Method: use a control to push a body, which adds
  // energy.
  Scene scene = scenes::rain(5, 3).scene;
  scene.controls.assign(
      1, {.tick = Tick{} + ticks_after(0.3), .body = {0}, .velocity_change_mps = {0, 0, 10}});
  const RecordedRun run = testing::recorded(scene, 0.5);
  EXPECT_GT(energy_changes_of(run).largest_gain, 1);
  EXPECT_EQ(energy_changes_of(run).where.kind, EventKind::control);
}

}  // namespace
}  // namespace sleight::physics
