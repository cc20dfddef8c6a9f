// Times of the 2D ball: one simulation, one iteration of Algorithm 2.1, and one scan of a run.
#include <benchmark/benchmark.h>

#include "tests/bench/harness.h"
#include "worker/run/chain_worker.h"
#include "worker/worlds/ball_2d/ball_2d.h"

namespace sleight::bench {
namespace {

using worlds::ball_2d::Ball2d;

constexpr sampling::ChainStreams k_streams{.seed = 1, .chain = {}, .replica = {}};

void simulate(benchmark::State& state) {
  const Ball2d ball{worlds::ball_2d::Parameters{}};
  random::Stream stream = k_streams.at(random::Purpose::prior, 0);
  std::vector<Ball2d::State> throws(1024);
  for (Ball2d::State& normals : throws)
    normals = ball.draw_prior(stream);
  ResultHash hash;
  for (const Ball2d::State& normals : throws)
    hash.add(ball.simulate(normals).x_m);
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(ball.simulate(throws[i++ % throws.size()]));
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), 0x6f6f075a26eaf9c4U);
}
BENCHMARK(simulate)->Name("ball_2d/simulate");

void iteration(benchmark::State& state) {
  const Ball2d ball{worlds::ball_2d::Parameters{}};
  auto sample = sampling::draw_afresh(ball, k_streams, 0);
  ResultHash hash;
  std::uint64_t i = 1;
  for (; i <= 1000; ++i) {
    sampling::metropolis_hastings_step(ball, 1.0, k_streams, i, sample);
    hash.add(sample.outcome.x_m);
  }
  for (auto _ : state)
    sampling::metropolis_hastings_step(ball, 1.0, k_streams, i++, sample);
  benchmark::DoNotOptimize(sample);
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), 0xad0f9f9c545d214bU);
}
BENCHMARK(iteration)->Name("ball_2d/iteration");

void unit(benchmark::State& state) {
  constexpr std::uint32_t k_scans = 1000;
  const run::ChainWorker<Ball2d> worker(Ball2d{worlds::ball_2d::Parameters{}}, {});
  const plan::Unit unit{
      .replica = {}, .seed = 1, .first_scan = {}, .scans = k_scans, .starts = true};
  ResultHash hash;
  for (const plan::ScanRecord& scan : worker.run(unit, {}).scans)
    hash.add(scan.log_constraint);
  for (auto _ : state)
    benchmark::DoNotOptimize(worker.run(unit, {}));
  state.SetItemsProcessed(state.iterations() * k_scans);
  verify(state, hash.value(), 0x8638e34a0aca2590U);
}
BENCHMARK(unit)->Name("ball_2d/unit_1000_scans");

}  // namespace
}  // namespace sleight::bench
