// Times of searches. One search builds pourings ball by ball
// (worker/worlds/spelling/pouring_builder.h). The map of landings is learnt in advance. Another
// search builds six dice die by die (worker/worlds/dice/throw_stages.h). Items are solutions.
// Learning the map is measured too.
#include <benchmark/benchmark.h>

#include <string>

#include "tests/bench/harness.h"
#include "tests/support/dice_scenes.h"
#include "worker/worlds/dice/throw_stages.h"
#include "worker/worlds/spelling/pouring_builder.h"

namespace sleight::bench {
namespace {

namespace spelling = worlds::spelling;
using spelling::Spelling;

constexpr std::uint64_t k_seed = 1;
/// The map is learnt from 2,000 balls. More balls don't make pourings cheaper.
constexpr std::uint64_t k_batches = 20;

Spelling world_of(const spelling::Pattern& pattern) {
  spelling::Parameters parameters;
  parameters.pattern = pattern;
  return Spelling(parameters);
}

spelling::Pattern word(const char* letters) {
  return spelling::pattern_of_word(letters, spelling::Font::rows_5).value();
}

/// Runs and measures the search's starts, beginning with start `number`. `guesses` is the counter's
/// name.
template <class Find>
void measure(benchmark::State& state, const Find& find, std::uint64_t number,
             sampling::SearchEffort& effort, const char* guesses) {
  effort = {};
  std::int64_t solutions = 0;
  for (auto _ : state)
    solutions += find(number++) ? 1 : 0;
  state.SetItemsProcessed(solutions);
  const auto each = static_cast<double>(solutions);
  state.counters["simulations"] = static_cast<double>(effort.simulations) / each;
  state.counters[guesses] = static_cast<double>(effort.guesses) / each;
}

/// Hashes the first `hashed` pourings. Then measures more pourings.
void search(benchmark::State& state, const spelling::Pattern& pattern, std::uint64_t hashed,
            std::uint64_t expected) {
  const Spelling world = world_of(pattern);
  const spelling::LandingMap map(spelling::landings_of(world, k_seed, k_batches));
  const spelling::PouringBuilder builder(world, map);
  sampling::SearchEffort effort;
  const auto find = [&](std::uint64_t number) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::search}, number);
    return sampling::search(builder, {}, stream, effort);
  };
  ResultHash hash;
  for (std::uint64_t number = 0; number < hashed; ++number) {
    const auto found = find(number);
    hash.add(found ? world.log_prior(found->state) : 0.0);
    if (found) hash.add(found->state.drops_m.back().x());
  }
  measure(state, find, hashed, effort, "lone_balls");
  verify(state, hash.value(), expected);
}
BENCHMARK_CAPTURE(search, hi, spelling::hi(), 20, 0x3f7d4ba28c0574cdU)
    ->Name("search/hi")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(search, acm, word("ACM"), 5, 0x5b6bc4abcefc1fbaU)
    ->Name("search/acm")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(search, sleight, word("SLEIGHT"), 2, 0x63f68c445fa08feeU)
    ->Name("search/sleight")
    ->Unit(benchmark::kMillisecond);

void search_six_dice(benchmark::State& state) {
  constexpr std::uint64_t k_hashed = 2;
  const worlds::dice::StagedDice world(tests::six_dice());
  const auto guide = world.learn(k_seed);
  const auto builder = world.builder(guide);
  sampling::SearchEffort effort;
  const auto find = [&](std::uint64_t number) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::search}, number);
    return sampling::search(builder, builder.limits(), stream, effort);
  };
  ResultHash hash;
  for (std::uint64_t number = 0; number < k_hashed; ++number) {
    const auto found = find(number);
    hash.add(found ? world.log_prior(found->state) : 0.0);
    if (found) hash.add(world.log_constraint(found->outcome));
  }
  measure(state, find, k_hashed, effort, "lone_throws");
  verify(state, hash.value(), 0xfcf090fa6bd45742U);
}
BENCHMARK(search_six_dice)->Name("search/six_dice")->Unit(benchmark::kMillisecond);

void landings(benchmark::State& state) {
  const Spelling world = world_of(word("ACM"));
  ResultHash hash;
  hash.add(landings_of_batch(world, k_seed, 0).total());
  hash.add(landings_of_batch(world, k_seed, 1).total());
  std::uint64_t batch = 2;
  for (auto _ : state)
    benchmark::DoNotOptimize(landings_of_batch(world, k_seed, batch++));
  state.SetItemsProcessed(state.iterations() * std::int64_t{spelling::k_landings_of_batch});
  verify(state, hash.value(), 0xa9d63cdb3a45fc6aU);
}
BENCHMARK(landings)->Name("search/landings")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sleight::bench
