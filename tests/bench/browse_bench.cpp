// Times of interactive queries on 5,000 animations of a bouncing body. Each animation has 64 path
// pieces.
//
// `find` searches for animations in which the body passes a box of some centimetres during a
// certain tenth of a second. `find_slowly` searches fewer animations by the plain algorithm of
// tests/browse. `items_per_second` counts examined animations. For `matrix`, it counts pairs.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "clients/browse/groups.h"
#include "clients/browse/index_bytes.h"
#include "clients/browse/query.h"
#include "clients/browse/resemblance.h"
#include "common/random/stream.h"
#include "tests/bench/harness.h"
#include "tests/browse/slow_query.h"

namespace sleight::bench {
namespace {

constexpr std::size_t k_animations = 5000;
constexpr std::size_t k_asked_slowly = 200;
constexpr std::size_t k_pieces = 64;
constexpr std::size_t k_questions = 64;

browse::Entry bouncing(std::uint64_t draw) {
  random::Stream stream({.seed = 26, .purpose = random::Purpose::prior}, draw);
  const auto within = [&](double size) { return size * (2 * stream.uniform() - 1); };
  browse::Entry entry{.name = {.run = "bench", .draw = draw}, .row = draw};
  math::Vec3 place_m{-0.5 + within(0.01), within(0.01), 0.1};
  math::Vec3 velocity_mps{1 + within(0.2), within(0.2), 0};
  double start_s = 0;
  for (std::size_t i = 0; i < k_pieces; ++i) {
    browse::Piece piece{.start_s = start_s, .position_m = place_m};
    if (i + 1 < k_pieces) {
      piece.velocity_mps = velocity_mps;
      piece.acceleration_mps2 = {0, 0, -9.81};
    }
    entry.pieces.push_back(piece);
    if (i > 0) entry.contacts.push_back({.time_s = start_s, .body = 0, .partner = 1});
    const double up_mps = velocity_mps.z();
    const double duration_s = (up_mps + std::sqrt(up_mps * up_mps + 2 * 9.81 * place_m.z())) / 9.81;
    place_m += duration_s * velocity_mps;
    place_m.z() = 0;
    velocity_mps.z() = 0.9 * (9.81 * duration_s - up_mps);
    velocity_mps.x() += within(0.1);
    velocity_mps.y() += within(0.1);
    start_s += duration_s;
  }
  entry.tracks = {{.first = 0, .count = k_pieces}};
  entry.end_s = entry.pieces.back().start_s;
  entry.events = k_pieces - 1;
  entry.numbers.assign(browse::k_own_numbers, 0);
  measure_reach(entry);
  return entry;
}

const browse::Index& subject() {
  static const browse::Index index = [] {
    browse::Index made{.run_id = "bench", .world = "bench"};
    made.numbers = browse::own_numbers();
    made.scene.features = {{.name = "body"},
                           {.name = "floor", .kind = scene::FeatureKind::fixed, .twin_of = 1}};
    for (std::uint64_t draw = 0; draw < k_animations; ++draw)
      made.entries.push_back(bouncing(draw));
    return made;
  }();
  return index;
}

std::vector<const browse::Entry*> entries_of(std::size_t count) {
  std::vector<const browse::Entry*> entries;
  for (std::size_t i = 0; i < count; ++i)
    entries.push_back(&subject().entries[i]);
  return entries;
}

browse::Condition question(std::uint64_t nth) {
  random::Stream stream({.seed = 27, .purpose = random::Purpose::prior}, nth);
  const math::Vec3 low_m{-0.5 + 2 * stream.uniform(), -0.3 + 0.5 * stream.uniform(),
                         0.05 * stream.uniform()};
  const double from_s = 1.5 * stream.uniform();
  return {browse::Inside{.who = {.bodies = {0}},
                         .box = {.low_m = low_m, .high_m = low_m + math::Vec3(0.05, 0.1, 0.05)},
                         .when = {.from_s = from_s, .to_s = from_s + 0.1}}};
}

void find(benchmark::State& state) {
  ResultHash hash;
  std::vector<browse::Condition> questions;
  for (std::uint64_t i = 0; i < k_questions; ++i) {
    questions.push_back(question(i));
    hash.add(std::uint64_t{browse::find(questions.back(), subject()).size()});
  }
  std::size_t next = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(browse::find(questions[next++ % k_questions], subject()));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(k_animations));
  verify(state, hash.value(), 0x7f5d35fa8b6138a0U);
}
BENCHMARK(find)->Name("browse/find")->Unit(benchmark::kMillisecond);

void find_slowly(benchmark::State& state) {
  ResultHash hash;
  std::vector<browse::Condition> questions;
  const auto ask = [&](const browse::Condition& condition) {
    std::uint64_t met = 0;
    for (std::size_t i = 0; i < k_asked_slowly; ++i)
      met += browse::testing::slow_is_met(condition, subject().entries[i]) ? 1 : 0;
    return met;
  };
  for (std::uint64_t i = 0; i < k_questions; ++i) {
    questions.push_back(question(i));
    hash.add(ask(questions.back()));
  }
  std::size_t next = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(ask(questions[next++ % k_questions]));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(k_asked_slowly));
  verify(state, hash.value(), 0x609b5de3fb679578U);
}
BENCHMARK(find_slowly)->Name("browse/find_slowly")->Unit(benchmark::kMillisecond);

void matrix(benchmark::State& state) {
  const auto entries = entries_of(browse::k_full_matrix_max);
  const browse::Sketches sketches(entries, subject().scene);
  ResultHash hash;
  for (const float value : sketches.matrix(1))
    hash.add(static_cast<double>(value));
  for (auto _ : state)
    benchmark::DoNotOptimize(sketches.matrix(1));
  const auto size = static_cast<std::int64_t>(entries.size());
  state.SetItemsProcessed(state.iterations() * size * (size - 1) / 2);
  verify(state, hash.value(), 0xdb23fe2854ec9721U);
}
BENCHMARK(matrix)->Name("browse/matrix")->Unit(benchmark::kMillisecond);

void groups(benchmark::State& state) {
  const auto entries = entries_of(k_animations);
  ResultHash hash;
  for (const browse::AlikeGroup& group : browse::groups_of(entries, subject().scene, {}).groups) {
    hash.add(std::uint64_t{group.representative});
    hash.add(std::uint64_t{group.members.size()});
  }
  for (auto _ : state)
    benchmark::DoNotOptimize(browse::groups_of(entries, subject().scene, {}));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(k_animations));
  verify(state, hash.value(), 0xbb255c398010dcaaU);
}
BENCHMARK(groups)->Name("browse/groups")->Unit(benchmark::kMillisecond);

void from_cache(benchmark::State& state) {
  const base::Bytes bytes = browse::bytes_of(subject());
  ResultHash hash;
  const auto back = browse::index_of(bytes);
  hash.add(std::uint64_t{back ? back->entries.size() : 0});
  hash.add(std::uint64_t{bytes.size()});
  for (auto _ : state)
    benchmark::DoNotOptimize(browse::index_of(bytes));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(k_animations));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes.size()));
  verify(state, hash.value(), 0xa0037047cb6b608fU);
}
BENCHMARK(from_cache)->Name("browse/from_cache")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sleight::bench
