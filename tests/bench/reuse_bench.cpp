// Cost and benefit of keeping a simulation's history (docs/SIMULATOR.md, "Replay of an earlier
// simulation").
//
// Each row alternates between a recorded simulation from scratch (`whole_ms`) and the row's own
// simulation (`ms`). CPU times include the start and the new history.
//
//   - Row `keep` times a simulation that keeps its history.
//   - In rows `all`, all bodies differ. The simulation gets the useless history of another scene,
//     or none.
//   - In rows `early`, one body starts differently, or is kicked, at the beginning. In scenes whose
//     bodies mix, the whole motion is simulated again.
//   - In rows `half`, the change comes after half of the time. In rows `late`, the change comes
//     after nine tenths.
//
// In rows `early`, `half` and `late`, both simulations keep their histories, as in a chain of
// proposals. In `all`, neither does. Both recordings have the same digest, which is the verified
// hash.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <ctime>
#include <memory>
#include <string_view>
#include <utility>

#include "tests/bench/harness.h"
#include "tests/scenes/shared/scenes.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::bench {
namespace {

using physics::History;
using physics::Scene;
using physics::Simulation;
using physics::SimulationOptions;
using physics::Tick;
namespace scenes = physics::scenes;

constexpr std::uint64_t k_seed = 1;

struct Subject {
  const char* name;
  scenes::Setting (*make)(std::uint32_t bodies, std::uint64_t seed);
  std::uint32_t n;
  double duration_s;
};

constexpr Subject k_subjects[] = {
    {"boxed_spheres", scenes::boxed_spheres, 64, 100},
    {"boxed_polyhedra", scenes::boxed_polyhedra, 64, 50},
    {"hourglass", scenes::hourglass, 40, 7},
    {"marbles", scenes::marbles, 15, 2},
};

enum class Row : std::uint8_t { keep, all, early, half, late };
constexpr const char* k_rows[] = {"keep", "all", "early", "half", "late"};

struct Outcome {
  double cpu_s = 0;
  std::uint64_t replayed = 0;
  std::shared_ptr<const History> history;
};

Outcome timed(const Scene& scene, double duration_s, bool keeps_history,
              const std::shared_ptr<const History>& history) {
  SimulationOptions options;
  options.keep_history = keeps_history;
  const std::clock_t begin = std::clock();
  Simulation simulation = Simulation::start(scene, options, history).value();
  const auto error = simulation.run_until(Tick{} + physics::ticks_after(duration_s));
  CHECK(!error);
  Outcome outcome{.history = simulation.history()};
  outcome.cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  outcome.replayed = simulation.counts().replayed;
  return outcome;
}

std::uint64_t digest_of(const Scene& scene, double duration_s,
                        const std::shared_ptr<const History>& history) {
  Simulation simulation = Simulation::start(scene, {}, history).value();
  CHECK(!simulation.run_until(Tick{} + physics::ticks_after(duration_s)));
  return simulation.recording().digest();
}

/// Returns a proposal: one body changes after a fraction of the time, or all bodies change.
Scene changed(const Subject& subject, const Scene& before, Row row) {
  Scene scene = before;
  if (row == Row::all) {
    for (physics::BodyDescription& body : scene.bodies)
      body.start.twist.velocity_mps.x() += 1e-9;
  } else if (row != Row::keep) {
    const double share = row == Row::early ? 0 : row == Row::half ? 0.5 : 0.9;
    const std::size_t last = scene.bodies.size() - 1;
    if (scene.bodies[last].start_tick > Tick{}) {
      // Bodies start one after the other.
      const auto chosen = static_cast<std::size_t>(share * static_cast<double>(last));
      scene.bodies[chosen].start.twist.angular_velocity_radps.x() += 1;
    } else {
      scene.controls.push_back({.tick = Tick{} + physics::ticks_after(share * subject.duration_s),
                                .body = {3},
                                .velocity_change_mps = {0.01, 0, 0}});
    }
  }
  return scene;
}

void run(benchmark::State& state, const Subject& subject, Row row) {
  const Scene before = subject.make(subject.n, k_seed).scene;
  const Scene scene = changed(subject, before, row);
  const auto history =
      row == Row::keep ? nullptr : timed(before, subject.duration_s, true, nullptr).history;
  const bool both_keep = row != Row::keep && row != Row::all;
  double whole_s = 0;
  double s = 0;
  std::uint64_t replayed = 0;
  std::size_t bytes = 0;
  for (auto _ : state) {
    whole_s += timed(scene, subject.duration_s, both_keep, nullptr).cpu_s;
    const Outcome outcome = timed(scene, subject.duration_s, row != Row::all, history);
    s += outcome.cpu_s;
    replayed = outcome.replayed;
    if (outcome.history) bytes = outcome.history->bytes();
  }
  const auto runs = static_cast<double>(state.iterations());
  state.counters["whole_ms"] = 1e3 * whole_s / runs;
  state.counters["ms"] = 1e3 * s / runs;
  state.counters["ratio"] = s / whole_s;
  state.counters["replayed"] = static_cast<double>(replayed);
  state.counters["history_MB"] = 1e-6 * static_cast<double>(bytes);
  verify(state, digest_of(scene, subject.duration_s, history),
         digest_of(scene, subject.duration_s, nullptr));
}

[[maybe_unused]] const bool k_added = [] {
  for (const Subject& subject : k_subjects) {
    for (std::size_t i = 0; i < std::size(k_rows); ++i) {
      benchmark::RegisterBenchmark(
          fmt::format("reuse/{}/{}", subject.name, k_rows[i]).c_str(),
          [&subject, i](benchmark::State& state) { run(state, subject, static_cast<Row>(i)); })
          ->Unit(benchmark::kMillisecond);
    }
  }
  return true;
}();

}  // namespace
}  // namespace sleight::bench
