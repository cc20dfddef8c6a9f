// Balls that spell HI: one simulation of ten balls until its outcome is decided, and to rest, with
// geometry that all differs from the last one's; and a chain of Algorithm 2.1.
#include <benchmark/benchmark.h>

#include <vector>

#include "tests/bench/harness.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::bench {
namespace {

using worlds::spelling::Spelling;

constexpr sampling::ChainStreams k_streams{.seed = 1, .chain = {}, .replica = {}};

/// Prior draws with all balls active.
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
    auto candidate = propose(world.prior(), enable, state, stream).candidate;
    if (candidate.active_count() == world.balls()) states.push_back(std::move(candidate));
  }
  return states;
}

using Simulate = worlds::spelling::Outcome (*)(const Spelling&, const Spelling::State&);

worlds::spelling::Outcome decide(const Spelling& world, const Spelling::State& state) {
  return world.simulate(state);
}
/// Of a candidate about whose state nothing is known: the whole simulation, with its history.
worlds::spelling::Outcome decide_and_tell(const Spelling& world, const Spelling::State& state) {
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
/// The same with all that simulations of similar states need.
BENCHMARK_CAPTURE(simulation, decision_told, &decide_and_tell, Replays::yes, 0xcbb75db773a49fa5U)
    ->Name("spelling_hi/decision_told")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(simulation, rest, &run_to_rest, Replays::no, 0x90497cb06cba6dfbU)
    ->Name("spelling_hi/rest")
    ->Unit(benchmark::kMillisecond);

/// A whole chain, as figure 2.8 shows it.
void chain(benchmark::State& state, worlds::spelling::Replays replays) {
  constexpr std::uint64_t k_iterations = 20'000;
  const Spelling world(worlds::spelling::Parameters{}, replays);
  std::uint64_t result = 0;
  std::uint64_t simulated = 0;
  for (auto _ : state) {
    ResultHash hash;
    simulated = 0;
    auto sample = sampling::initialize(world, k_streams);
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

}  // namespace
}  // namespace sleight::bench
