// Balls that spell HI: one simulation of ten balls to rest, its geometry included, and iterations
// of Algorithm 2.1.
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

void rest(benchmark::State& state) {
  const Spelling world{worlds::spelling::Parameters{}};
  const auto states = full_states(world, 200);
  ResultHash hash;
  for (std::size_t i = 0; i < 20; ++i) {
    const auto outcome = world.simulate(states[i]);
    hash.add(std::uint64_t{outcome.filled});
    hash.add(outcome.end_s);
  }
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(world.simulate(states[i++ % states.size()]));
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), 0xe3447bdb81acc35cU);
}
BENCHMARK(rest)->Name("spelling_hi/rest")->Unit(benchmark::kMillisecond);

void chain(benchmark::State& state) {
  const Spelling world{worlds::spelling::Parameters{}};
  auto sample = sampling::initialize(world, k_streams);
  ResultHash hash;
  std::uint64_t i = 1;
  for (; i <= 50; ++i) {
    sampling::metropolis_hastings_step(world, 1.0, k_streams, i, sample);
    hash.add(std::uint64_t{sample.outcome.filled});
    hash.add(sample.log_prior);
  }
  for (auto _ : state)
    sampling::metropolis_hastings_step(world, 1.0, k_streams, i++, sample);
  benchmark::DoNotOptimize(sample);
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), 0x25d3af82c4f432d0U);
}
BENCHMARK(chain)->Name("spelling_hi/iteration")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sleight::bench
