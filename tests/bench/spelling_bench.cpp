// Times for balls that spell HI. Some rows simulate ten balls with completely new geometry, until
// the outcome is decided or until rest. Other rows run a chain of Algorithm 2.1, or compare both
// engines.
#include <benchmark/benchmark.h>

#include <ctime>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "tests/bench/harness.h"
#include "worker/physics/marbles/marbles.h"
#include "worker/physics/simulator/simulation.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::bench {
namespace {

using worlds::spelling::Spelling;

constexpr sampling::ChainStreams k_streams{.seed = 1, .chain = {}, .replica = {}};

std::vector<Spelling::State> full_states(const Spelling& world, std::uint64_t count) {
  const worlds::spelling::ProposalParameters enable{.change_all = 0,
                                                    .change_vertices = 0,
                                                    .change_ball = 0,
                                                    .disable_balls = 0,
                                                    .enable_balls = 1,
                                                    .flip_probability = 0.999};
  std::vector<Spelling::State> states;
  for (std::uint64_t i = 0; states.size() < count; ++i) {
    random::Stream stream = k_streams.at(random::Purpose::prior, i);
    const Spelling::State state = world.draw_prior(stream);
    auto candidate =
        propose_of(drawn_kind(enable, stream), world.prior(), enable, state, {}, stream).candidate;
    if (candidate.active_count() == world.balls()) states.push_back(std::move(candidate));
  }
  return states;
}

using Simulate = worlds::spelling::Outcome (*)(const Spelling&, const Spelling::State&);

worlds::spelling::Outcome decide(const Spelling& world, const Spelling::State& state) {
  return world.simulate(state);
}
/// Simulates a state from scratch and records its history.
worlds::spelling::Outcome decide_and_keep(const Spelling& world, const Spelling::State& state) {
  return world.simulate_from(state, state, {});
}
worlds::spelling::Outcome run_to_rest(const Spelling& world, const Spelling::State& state) {
  return world.simulate_to_rest(state);
}

void simulation(benchmark::State& state, Simulate simulate, worlds::spelling::Replays replays,
                std::uint64_t expected) {
  const Spelling world(worlds::spelling::Parameters{}, replays);
  const auto states = full_states(world, 200);
  ResultHash hash;
  for (std::size_t i = 0; i < 20; ++i) {
    const auto outcome = simulate(world, states[i]);
    hash.add(std::uint64_t{outcome.filled});
    hash.add(outcome.end_s);
  }
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(simulate(world, states[i++ % states.size()]));
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), expected);
}
using worlds::spelling::Replays;
BENCHMARK_CAPTURE(simulation, decision, &decide, Replays::no, 0xcbb75db773a49fa5U)
    ->Name("spelling_hi/decision")
    ->Unit(benchmark::kMillisecond);
/// The same simulation, but it also keeps all data for simulations of similar states.
BENCHMARK_CAPTURE(simulation, decision_kept, &decide_and_keep, Replays::yes, 0xcbb75db773a49fa5U)
    ->Name("spelling_hi/decision_kept")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(simulation, rest, &run_to_rest, Replays::no, 0x90497cb06cba6dfbU)
    ->Name("spelling_hi/rest")
    ->Unit(benchmark::kMillisecond);

/// A whole chain, as in figure 2.8.
void chain(benchmark::State& state, worlds::spelling::Replays replays) {
  constexpr std::uint64_t k_iterations = 20'000;
  const Spelling world(worlds::spelling::Parameters{}, replays);
  std::uint64_t result = 0;
  std::uint64_t simulated = 0;
  for (auto _ : state) {
    ResultHash hash;
    simulated = 0;
    auto sample = sampling::draw_afresh(world, k_streams, 0);
    for (std::uint64_t i = 1; i <= k_iterations; ++i) {
      simulated += metropolis_hastings_step(world, 1.0, k_streams, i, sample).simulated ? 1U : 0U;
      if (i % 1000 == 0) hash.add(sample.log_prior + sample.log_constraint);
    }
    result = hash.value();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(k_iterations));
  state.counters["simulated"] = static_cast<double>(simulated);
  verify(state, result, 0x9cc1f7e24e4dac03U);
}
BENCHMARK_CAPTURE(chain, replays, worlds::spelling::Replays::yes)
    ->Name("spelling_hi/chain_20000")
    ->Unit(benchmark::kSecond)
    ->Iterations(1);
BENCHMARK_CAPTURE(chain, fresh, worlds::spelling::Replays::no)
    ->Name("spelling_hi/chain_20000_fresh")
    ->Unit(benchmark::kSecond)
    ->Iterations(1);

// The ratio of both engines' times (docs/SIMULATOR, "Equal balls by themselves"). Each engine
// simulates the same scenes from the start until two seconds after the last drop. The time to build
// static geometry isn't part of the ratio, because a chain reuses static geometry. Rows named
// `reuse` use the history of a scene in which one ball is dropped elsewhere, as a chain's proposals
// do.

constexpr double k_after_the_last_s = 2;

struct Engines {
  double statics_s = 0;    ///< static geometry, which the simulator builds itself
  double simulator_s = 0;  ///< including statics_s
  double near_s = 0;       ///< table of near features, for marbles
  double marbles_s = 0;
  ResultHash of_simulator{};
  ResultHash of_marbles{};
};

double cpu_s() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void hash_place(ResultHash& hash, const math::Vec3& place_m) {
  for (int axis = 0; axis < 3; ++axis)
    hash.add(place_m[axis]);
}

/// Runs both engines on a scene. If `other` isn't null, the engines use its history. In `other`,
/// the ball `moved` starts elsewhere.
void run_engines(const physics::Scene& scene, const physics::Scene* other, std::uint32_t moved,
                 Engines& engines) {
  const physics::Tick end =
      scene.bodies.back().start_tick + physics::ticks_after(k_after_the_last_s);
  const auto bodies = static_cast<std::uint32_t>(scene.bodies.size());
  physics::SimulationOptions options;
  options.record = false;
  options.keep_history = other != nullptr;
  const auto started = [&](const physics::Scene& of,
                           const std::shared_ptr<const physics::History>& history) {
    return physics::Simulation::start(of, options, history).value();
  };
  std::shared_ptr<const physics::History> history;
  if (other != nullptr) {
    physics::Simulation earlier = started(*other, nullptr);
    CHECK(!earlier.run_until(end));
    history = earlier.history();
  }
  double begin_s = cpu_s();
  physics::Simulation simulation = started(scene, history);
  CHECK(!simulation.run_until(end));
  const auto own_history = simulation.history();
  engines.simulator_s += cpu_s() - begin_s;
  for (std::uint32_t ball = 0; ball < bodies; ++ball)
    hash_place(engines.of_simulator, simulation.pose({ball}, end).position_m);

  begin_s = cpu_s();
  const physics::StaticGeometry statics(scene);
  engines.statics_s += cpu_s() - begin_s;
  begin_s = cpu_s();
  const physics::NearFeatures near(statics,
                                   std::get<physics::Sphere>(scene.bodies[0].shape).radius_m);
  engines.near_s += cpu_s() - begin_s;
  physics::Marbles marbles;
  physics::MarbleHistories histories;
  if (other != nullptr) {
    marbles.start(*other, near, end, {}, UINT64_MAX, {.records = true});
    CHECK(!marbles.run_until(end));
    histories = marbles.histories();
    histories[moved] = nullptr;
  }
  begin_s = cpu_s();
  marbles.start(
      scene, near, end, {}, UINT64_MAX,
      {.histories = other != nullptr ? &histories : nullptr, .records = other != nullptr});
  const auto is_void = [&] {
    const bool failed = marbles.run_until(end).has_value();
    CHECK(!failed || marbles.is_replay_void());
    return marbles.is_replay_void();
  };
  const auto start_afresh = [&] {
    marbles.start(scene, near, end, {}, UINT64_MAX, {.records = true});
    CHECK(!is_void());
  };
  if (is_void()) start_afresh();
  if (other != nullptr) histories = marbles.histories();
  // Read all balls' places, including those of replayed balls.
  for (std::uint32_t ball = 0; ball < bodies; ++ball) {
    if (marbles.replayed({ball}) != nullptr) marbles.stop_replay({ball});
  }
  if (is_void()) start_afresh();
  engines.marbles_s += cpu_s() - begin_s;
  for (std::uint32_t ball = 0; ball < bodies; ++ball)
    hash_place(engines.of_marbles, marbles.position_m({ball}));
}

void engines(benchmark::State& state, bool reuses) {
  const Spelling world(worlds::spelling::Parameters{});
  const auto states = full_states(world, 50);
  Engines both;
  std::uint64_t hash = 0;
  for (auto _ : state) {
    for (std::size_t i = 0; i < states.size(); ++i) {
      const auto moved = static_cast<std::uint32_t>(i % states[i].active.size());
      Spelling::State proposal = states[i];
      proposal.drops_m[moved] = states[(i + 1) % states.size()].drops_m[moved];
      const physics::Scene scene = *world.scene(proposal);
      // Both scenes share the mesh, so that the engine sees at once that the mesh is unchanged.
      physics::Scene before = scene;
      before.bodies[moved].start = world.scene(states[i])->bodies[moved].start;
      run_engines(scene, reuses ? &before : nullptr, moved, both);
    }
    if (hash == 0) hash = both.of_simulator.value();
  }
  const auto runs = static_cast<double>(state.iterations()) * static_cast<double>(states.size());
  const auto ms = [&](double all_s) { return 1e3 * all_s / runs; };
  const double simulator_s = both.simulator_s - both.statics_s;
  state.counters["simulator_ms"] = ms(simulator_s);
  state.counters["marbles_ms"] = ms(both.marbles_s);
  state.counters["statics_ms"] = ms(both.statics_s);
  state.counters["near_ms"] = ms(both.near_s);
  state.counters["ratio"] = simulator_s / both.marbles_s;
  CHECK_EQ(both.of_marbles.value(), both.of_simulator.value());
  verify(state, hash, 0x4c6b070e05508c10U);
}
BENCHMARK_CAPTURE(engines, fresh, false)
    ->Name("engines/spelling_hi")
    ->Unit(benchmark::kMillisecond)
    ->Iterations(4);
BENCHMARK_CAPTURE(engines, reuse, true)
    ->Name("engines/spelling_hi_reuse")
    ->Unit(benchmark::kMillisecond)
    ->Iterations(4);

}  // namespace
}  // namespace sleight::bench
