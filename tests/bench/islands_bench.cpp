// Times of free islands of 32 particles (worker/sampling/island.h). The guide is learnt in advance.
// Rows report islands per second (as items) and simulations per island. Simulations of single dice
// count; simulations of single balls don't.
#include <benchmark/benchmark.h>

#include <cstdint>

#include "tests/bench/harness.h"
#include "tests/support/dice_scenes.h"
#include "worker/sampling/island.h"
#include "worker/worlds/dice/throw_stages.h"
#include "worker/worlds/spelling/pouring_stages.h"

namespace sleight::bench {
namespace {

namespace spelling = worlds::spelling;
using spelling::StagedSpelling;
using worlds::dice::StagedDice;

constexpr sampling::ChainStreams k_streams{.seed = 1, .chain = {}, .replica = {}};

/// Returns a world. `log_lambda` is the value that requests without a sampler use.
StagedSpelling world_of(const spelling::Pattern& pattern, double log_lambda) {
  spelling::Parameters parameters;
  parameters.pattern = pattern;
  parameters.constraint.log_lambda = log_lambda;
  return StagedSpelling(parameters);
}

/// Hashes log Z and the drawn states of the first `hashed` islands.
template <class World>
void islands(benchmark::State& state, const World& world, std::uint64_t hashed,
             std::uint64_t expected) {
  const auto guide = world.learn(k_streams.seed);
  std::uint64_t simulations = 0;
  const sampling::Islands<World> islands(
      world, guide, {.particles = 32}, k_streams,
      [&simulations](const sampling::SimulationReport&) { ++simulations; });
  ResultHash hash;
  for (std::uint64_t number = 0; number < hashed; ++number) {
    const auto island = islands.free(number);
    hash.add(island.log_z);
    if (!island.drawn) continue;
    for (const auto byte : world.encode(island.drawn->state))
      hash.add(static_cast<std::uint64_t>(byte));
  }
  simulations = 0;
  std::uint64_t number = hashed;
  for (auto _ : state)
    benchmark::DoNotOptimize(islands.free(number++));
  const auto made = state.iterations();
  state.SetItemsProcessed(made);
  state.counters["simulations"] = static_cast<double>(simulations) / static_cast<double>(made);
  verify(state, hash.value(), expected);
}

void islands_hi(benchmark::State& state) {
  islands(state, world_of(spelling::hi(), 8), 4, 0x41ddd38d27955ee4U);
}
BENCHMARK(islands_hi)->Name("islands/hi")->Unit(benchmark::kMillisecond);

void islands_acm(benchmark::State& state) {
  const auto acm = spelling::pattern_of_word("ACM", spelling::Font::rows_5).value();
  islands(state, world_of(acm, 9), 2, 0x770960f5fcf4988eU);
}
BENCHMARK(islands_acm)->Name("islands/acm")->Unit(benchmark::kMillisecond);

void islands_die(benchmark::State& state) {
  islands(state, StagedDice(tests::die(0.005, 0.005, false)), 4, 0x7394ba763feaf648U);
}
BENCHMARK(islands_die)->Name("islands/die")->Unit(benchmark::kMillisecond);

void islands_six_dice(benchmark::State& state) {
  islands(state, StagedDice(tests::six_dice()), 2, 0xd5b37f7ce176c6e9U);
}
BENCHMARK(islands_six_dice)->Name("islands/six_dice")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sleight::bench
