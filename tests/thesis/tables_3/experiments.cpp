#include "tests/thesis/tables_3/experiments.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "common/base/error.h"
#include "tests/engines/engines.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::thesis {
namespace {

using physics::Algorithm;
using physics::BroadPhaseKind;
using physics::Counts;
using physics::QueueKind;
using physics::Simulation;
using physics::SimulationOptions;
using physics::Tick;
namespace scenes = physics::scenes;

constexpr double k_thesis_box_half_m = 5.25;
/// Minimum distance of bodies from the walls at the start of the scene list's boxed_polyhedra().
constexpr double k_from_wall_m = 0.52;

/// Returns the scene list's boxed_polyhedra() in the thesis's box. The thesis used one box size for
/// all numbers of bodies. The list's scene instead keeps the density that 64 bodies have.
scenes::Setting in_the_thesis_box(std::uint32_t bodies, std::uint64_t seed) {
  scenes::Setting setting = scenes::boxed_polyhedra(bodies, seed);
  const double half_m = -setting.scene.planes.front().outside.offset_m;
  for (physics::StaticPlane& wall : setting.scene.planes)
    wall.outside.offset_m = -k_thesis_box_half_m;
  for (physics::BodyDescription& body : setting.scene.bodies)
    body.start.pose.position_m *= (k_thesis_box_half_m - k_from_wall_m) / (half_m - k_from_wall_m);
  return setting;
}

struct Measured {
  Counts counts;
  double cpu_s = 0;
};

Measured run(const scenes::Setting& setting, Algorithm algorithm) {
  SimulationOptions options;
  options.algorithm = algorithm;
  options.record = false;
  if (algorithm == Algorithm::synchronous)
    options.make_engine =
        physics::engine_with(BroadPhaseKind::sweep_and_prune, QueueKind::tournament);
  const std::clock_t begin = std::clock();
  auto started = Simulation::start(setting.scene, options);
  if (!started) throw base::Error(base::ExitCode::bug, started.error().message);
  Simulation simulation = std::move(started).value();
  const auto failure = simulation.run_until(Tick{} + physics::ticks_after(setting.duration_s));
  if (failure) throw base::Error(base::ExitCode::bug, failure->message);
  return {.counts = simulation.counts(),
          .cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC};
}

}  // namespace

Experiment boxed_polyhedra(double duration_s) {
  return {.setting =
              [duration_s](std::uint32_t bodies, std::uint64_t seed) {
                scenes::Setting setting = in_the_thesis_box(bodies, seed);
                setting.duration_s = duration_s;
                return setting;
              },
          .sizes = {1, 2, 3, 4, 6, 8, 11, 16, 23, 32, 45, 64},
          .seeds = 5};
}

Experiment hourglass(double duration_s_max) {
  return {.setting =
              [duration_s_max](std::uint32_t bodies, std::uint64_t seed) {
                scenes::Setting setting = scenes::hourglass(bodies, seed);
                setting.duration_s = std::min(setting.duration_s, duration_s_max);
                return setting;
              },
          .sizes = {10, 20, 30, 40, 50, 60, 70, 80, 90, 100},
          .seeds = 10};
}

Row measure(const Experiment& experiment, std::uint32_t n) {
  Row row;
  row.n = n;
  const auto share = 1 / static_cast<double>(experiment.seeds);
  for (std::uint64_t seed = 1; seed <= experiment.seeds; ++seed) {
    const scenes::Setting setting = experiment.setting(n, seed);
    const Measured sync = run(setting, Algorithm::synchronous);
    const Measured async = run(setting, Algorithm::asynchronous);
    if (sync.counts.collisions != async.counts.collisions ||
        sync.counts.static_collisions != async.counts.static_collisions) {
      throw base::Error(base::ExitCode::bug,
                        fmt::format("the algorithms differ with {} bodies, seed {}", n, seed));
    }
    row.sync.events += share * static_cast<double>(sync.counts.events());
    row.sync.total_s += share * sync.cpu_s;
    row.async.events += share * static_cast<double>(async.counts.events());
    row.async.total_s += share * async.cpu_s;
    row.collisions +=
        share * static_cast<double>(async.counts.collisions + async.counts.static_collisions);
  }
  return row;
}

}  // namespace sleight::thesis
