// Time to draw random numbers and to evaluate elementary functions, as in every simulation.
#include <benchmark/benchmark.h>

#include "common/math/elementary.h"
#include "common/random/distributions.h"
#include "tests/bench/harness.h"

namespace sleight::bench {
namespace {

random::Stream stream_of(std::uint64_t iteration) {
  return random::Stream({.seed = 1, .purpose = random::Purpose::prior}, iteration);
}

void fresh_stream(benchmark::State& state) {
  ResultHash hash;
  for (std::uint64_t i = 0; i < 1000; ++i)
    hash.add(stream_of(i).bits());
  std::uint64_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(stream_of(i++).bits());
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), 0x34eaa351536cdbfdU);
}
BENCHMARK(fresh_stream)->Name("random/fresh_stream");

template <class Distribution>
void draws(benchmark::State& state, const Distribution& distribution, std::uint64_t expected) {
  ResultHash hash;
  random::Stream first = stream_of(0);
  for (int i = 0; i < 1000; ++i)
    hash.add(distribution.draw(first));
  random::Stream stream = stream_of(1);
  for (auto _ : state)
    benchmark::DoNotOptimize(distribution.draw(stream));
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), expected);
}

void uniform(benchmark::State& state) {
  draws(state, random::Uniform{.low = -1, .high = 1}, 0x88bc7536e58d4119U);
}
BENCHMARK(uniform)->Name("random/uniform");

void normal(benchmark::State& state) {
  draws(state, random::Normal{.mean = 0, .sd = 1}, 0x0f750f75f630aab9U);
}
BENCHMARK(normal)->Name("random/normal");

}  // namespace
}  // namespace sleight::bench
