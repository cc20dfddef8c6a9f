// Times of the event-driven simulator in the thesis's two experiments (3.3) and in gases of
// spheres.
//
// Rows of box/, hourglass/ and wall/ time simulations without a recording. Each row first simulates
// the beginning once with a recording, and verifies the recording's digest. Both algorithms have
// the same digest. Rows named sync use Algorithm 3.4 with a complete sort of all extents. Rows
// named sync_grid use the same algorithm on the grid, which is slower in these scenes. Rows of one
// size simulate the same time, so total times are comparable (hourglass/1000 simulates a twentieth
// of a second). Rows named sync report the ratio of their time to async's time in the same run of
// the program. Rows that take more than about a second are always verified, but timed only if their
// name or scene is requested.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "tests/bench/harness.h"
#include "tests/engines/engines.h"
#include "tests/scenes/shared/scenes.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::bench {
namespace {

using physics::Algorithm;
using physics::BroadPhaseKind;
using physics::Counts;
using physics::QueueKind;
using physics::Simulation;
using physics::SimulationOptions;
using physics::Tick;
namespace scenes = physics::scenes;

constexpr std::uint64_t k_seed = 1;

enum class Way : std::uint8_t { async, sync, sync_grid };

SimulationOptions options_of(Way way, bool record) {
  SimulationOptions options;
  options.record = record;
  if (way != Way::async) options.algorithm = Algorithm::synchronous;
  if (way == Way::sync)
    options.make_engine =
        physics::engine_with(BroadPhaseKind::sweep_and_prune, QueueKind::tournament);
  return options;
}

/// Reports a benchmark error and returns nothing if the simulation fails.
std::optional<Simulation> simulated(benchmark::State& state, const physics::Scene& scene,
                                    const SimulationOptions& options, double duration_s) {
  auto started = Simulation::start(scene, options);
  if (!started) {
    state.SkipWithError(started.error().message.c_str());
    return std::nullopt;
  }
  std::optional<Simulation> simulation(std::move(started).value());
  if (const auto error = simulation->run_until(Tick{} + physics::ticks_after(duration_s))) {
    state.SkipWithError(error->message.c_str());
    return std::nullopt;
  }
  return simulation;
}

std::uint64_t digest_of(benchmark::State& state, const physics::Scene& scene, Way way,
                        double duration_s) {
  const auto simulation = simulated(state, scene, options_of(way, true), duration_s);
  return simulation ? simulation->recording().digest() : 0;
}

// ---- the thesis's experiments -------------------------------------------------------------------

struct Experiment {
  const char* scene;
  scenes::Setting (*make)(std::uint32_t bodies, std::uint64_t seed);
  std::uint32_t n;
  double duration_s;  ///< 0: the scene's own
  double verified_s;
  bool long_async;  ///< timed only when requested by name
  bool long_sync;
  std::uint64_t digest;  ///< of the recording up to verified_s
  /// Simulated time at which timing starts, if not 0. Timing then lasts duration_s.
  double from_s = 0;
};

constexpr Experiment k_experiments[] = {
    {"box", scenes::boxed_polyhedra, 1, 100, 10, false, false, 0x5a6e3e33d5911213U},
    {"box", scenes::boxed_polyhedra, 2, 100, 10, false, false, 0xbd3afd8343cd19f3U},
    {"box", scenes::boxed_polyhedra, 4, 100, 10, false, false, 0xdbcf7d65092e457fU},
    {"box", scenes::boxed_polyhedra, 8, 100, 10, false, false, 0x20108718672d4815U},
    {"box", scenes::boxed_polyhedra, 16, 100, 10, false, false, 0x482f495f6497c650U},
    {"box", scenes::boxed_polyhedra, 32, 100, 10, false, false, 0x3d6ea41aa7311758U},
    {"box", scenes::boxed_polyhedra, 64, 100, 10, false, false, 0x3f8a130a2dc87871U},
    // The run has at least ten collisions per body.
    {"box", scenes::boxed_polyhedra, 512, 40, 2, false, true, 0xf34d0f773bc47a6cU},
    {"box", scenes::boxed_polyhedra, 4096, 45, 0.25, true, true, 0xa5022b9348d23a3bU},
    {"hourglass", scenes::hourglass, 10, 0, 1.5, false, false, 0x2f83a5fc1c9c632cU},
    {"hourglass", scenes::hourglass, 20, 0, 1.5, false, false, 0x2c6c58157cd14421U},
    {"hourglass", scenes::hourglass, 30, 0, 1.5, false, false, 0x8538e9499830528cU},
    {"hourglass", scenes::hourglass, 40, 0, 1.5, false, true, 0xd9c396932c9facffU},
    {"hourglass", scenes::hourglass, 50, 0, 1.5, true, true, 0x66ce32705ec708e1U},
    {"hourglass", scenes::hourglass, 60, 0, 1.5, true, true, 0x0b569954f2d2c858U},
    {"hourglass", scenes::hourglass, 70, 0, 1.5, true, true, 0x7b8333732c290729U},
    {"hourglass", scenes::hourglass, 80, 0, 1.5, true, true, 0xadca263c862d47d6U},
    {"hourglass", scenes::hourglass, 90, 0, 1.5, true, true, 0x343444faf712f6e5U},
    {"hourglass", scenes::hourglass, 100, 0, 1.5, true, true, 0x1ce8b39c1df40df0U},
    {"round_solids", scenes::round_solids, 12, 0, 1, false, true, 0x33e4dfda7fbc0944U},
    {"bowling", scenes::bowling, 11, 0, 1, false, true, 0x26de07c6d97275fcU},
    // A ball knocks down two hundred bricks.
    {"wall", scenes::wall, 201, 0.75, 0.03, true, true, 0xdf661de415c33449U},
    // When timing starts, all grains have started, and the last grains fall on the heap. The whole
    // simulation takes minutes with the asynchronous algorithm, and an hour with the synchronous
    // algorithm.
    {"hourglass", scenes::hourglass, 1000, 0.05, 1.5, true, true, 0x4929c940aa320193U, 50},
};

/// CPU seconds of each experiment's asynchronous run. If only a part is timed, CPU seconds per
/// event.
std::map<const Experiment*, double>& async_seconds() {
  static std::map<const Experiment*, double> seconds;
  return seconds;
}

bool asked_by_name() {
  return benchmark::GetBenchmarkFilter() != ".";
}

void count(benchmark::State& state, const Counts& counts, double duration_s, double cpu_s,
           std::uint32_t bodies) {
  const double runs = static_cast<double>(state.iterations());
  const auto events = static_cast<double>(counts.events());
  const auto pairs = static_cast<double>(counts.collisions);
  const auto statics = static_cast<double>(counts.static_collisions);
  state.counters["events"] = events;
  state.counters["us_per_event"] = 1e6 * cpu_s / (runs * events);
  state.counters["collisions"] = pairs + statics;
  state.counters["collisions_a_body"] = (2 * pairs + statics) / bodies;
  state.counters["simulated_s_per_s"] = duration_s * runs / cpu_s;
}

struct Timed {
  Counts counts;  ///< of the last run
  double cpu_s = 0;
};

/// Times whole runs, including the start.
std::optional<Timed> time_whole(benchmark::State& state, const physics::Scene& scene, Way way,
                                double duration_s) {
  Timed timed;
  const std::clock_t begin = std::clock();
  for (auto _ : state) {
    const auto simulation = simulated(state, scene, options_of(way, false), duration_s);
    if (!simulation) return std::nullopt;
    timed.counts = simulation->counts();
  }
  timed.cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  return timed;
}

/// All rows of an experiment share one simulation; each row continues where the row before it
///  stopped.
std::optional<Timed> time_part(benchmark::State& state, const Experiment& experiment,
                               const physics::Scene& scene, Way way) {
  static std::map<const Experiment*, Simulation> shared;
  auto found = shared.find(&experiment);
  if (found == shared.end()) {
    auto begun = simulated(state, scene, options_of(Way::async, false), experiment.from_s);
    if (!begun) return std::nullopt;
    found = shared.emplace(&experiment, *std::move(begun)).first;
  }
  Simulation& simulation = found->second;
  simulation.go_on_with(options_of(way, false));
  Timed timed;
  const Counts before = simulation.counts();
  const std::clock_t begin = std::clock();
  for (auto _ : state) {
    const Tick end = simulation.now() + physics::ticks_after(experiment.duration_s);
    if (const auto error = simulation.run_until(end)) {
      state.SkipWithError(error->message.c_str());
      return std::nullopt;
    }
  }
  timed.cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  timed.counts = simulation.counts() - before;
  return timed;
}

void run(benchmark::State& state, const Experiment& experiment, Way way) {
  const scenes::Setting setting = experiment.make(experiment.n, k_seed);
  const double duration_s = experiment.duration_s > 0 ? experiment.duration_s : setting.duration_s;
  const std::uint64_t digest = digest_of(state, setting.scene, way, experiment.verified_s);
  const bool is_long = way == Way::async ? experiment.long_async : experiment.long_sync;
  if (is_long && !asked_by_name()) {
    for (auto _ : state)
      benchmark::DoNotOptimize(digest);
  } else {
    const auto timed = experiment.from_s > 0 ? time_part(state, experiment, setting.scene, way)
                                             : time_whole(state, setting.scene, way, duration_s);
    if (!timed) return;
    count(state, timed->counts, duration_s, timed->cpu_s, experiment.n);
    // Each row times another part of the simulation, so compare times per event.
    const double run_s = timed->cpu_s / static_cast<double>(state.iterations());
    const double unit_s =
        experiment.from_s > 0 ? run_s / static_cast<double>(timed->counts.events()) : run_s;
    if (way == Way::async) async_seconds()[&experiment] = unit_s;
    const auto async = async_seconds().find(&experiment);
    if (way != Way::async && async != async_seconds().end())
      state.counters["times_async"] = unit_s / async->second;
  }
  verify(state, digest, experiment.digest);
}

// ---- gases of spheres ---------------------------------------------------------------------------

struct Gas {
  std::uint32_t n;
  double packing;
  double warm_up_s;  ///< about 20 collisions per sphere
  double portion_s;  ///< about 50,000 collisions
  double verified_s;
  std::uint64_t digest;
};

constexpr Gas k_gases[] = {
    {1000, 0.1, 12, 56, 2, 0x2981b9108bf3eaf5U},
    {1000, 0.4, 1, 5, 0.2, 0x194f63790661ca71U},
    {10648, 0.1, 12, 5, 0.2, 0x978393082dfaa089U},
    {10648, 0.4, 1, 0.5, 0.02, 0xdbe5123885c1d48eU},
};

void gas(benchmark::State& state, const Gas& gas) {
  const scenes::Setting setting = scenes::hard_sphere_gas(gas.n, gas.packing, k_seed);
  const std::uint64_t digest = digest_of(state, setting.scene, Way::async, gas.verified_s);
  auto simulation = simulated(state, setting.scene, options_of(Way::async, false), gas.warm_up_s);
  if (!simulation) return;
  const Counts warm = simulation->counts();
  for (auto _ : state) {
    const Tick end = simulation->now() + physics::ticks_after(gas.portion_s);
    if (const auto error = simulation->run_until(end)) {
      state.SkipWithError(error->message.c_str());
      return;
    }
  }
  const Counts& counts = simulation->counts();
  const auto collisions = static_cast<double>(counts.collisions - warm.collisions);
  state.SetItemsProcessed(static_cast<std::int64_t>(collisions));
  state.counters["warm_collisions_a_sphere"] = 2 * static_cast<double>(warm.collisions) / gas.n;
  state.counters["updates_per_collision"] =
      static_cast<double>(counts.updates - warm.updates) / collisions;
  state.counters["predictions_per_collision"] =
      static_cast<double>(counts.predictions - warm.predictions) / collisions;
  verify(state, digest, gas.digest);
}

// ---- the list -----------------------------------------------------------------------------------

void add(const Experiment& experiment, Way way, const char* name) {
  auto* added = benchmark::RegisterBenchmark(
      fmt::format("{}/{}/{}", experiment.scene, name, experiment.n).c_str(),
      [&experiment, way](benchmark::State& state) { run(state, experiment, way); });
  added->Unit(benchmark::kMillisecond);
  // One run of a long row is enough. If the row isn't timed, repeating its empty loop is useless.
  if (way == Way::async ? experiment.long_async : experiment.long_sync) added->Iterations(1);
}

[[maybe_unused]] const bool k_added = [] {
  for (const Experiment& experiment : k_experiments) {
    add(experiment, Way::async, "async");
    add(experiment, Way::sync, "sync");
    if (experiment.n == 64 || experiment.n == 512) add(experiment, Way::sync_grid, "sync_grid");
  }
  for (const Gas& one : k_gases) {
    benchmark::RegisterBenchmark(fmt::format("spheres/{}/{}", one.n, one.packing).c_str(),
                                 [&one](benchmark::State& state) { gas(state, one); })
        ->Unit(benchmark::kMillisecond)
        ->Iterations(3);
  }
  return true;
}();

}  // namespace
}  // namespace sleight::bench
