// Time that a broad phase needs to move one body's box, in a gas and in a heap.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/random/stream.h"
#include "tests/bench/harness.h"
#include "tests/engines/all_pairs.h"
#include "tests/engines/sweep_and_prune.h"
#include "worker/physics/broad_phase/hierarchical_grid.h"

namespace sleight::bench {
namespace {

using physics::BodyId;
using physics::Box;

/// Balls of diameter 1 near lattice places, and their moves. Each ball has a box of width 1.3.
struct Balls {
  using Point = std::array<double, 3>;
  std::array<double, 3> period_m{};
  std::vector<Box> start;
  struct Move {
    BodyId body;
    Box box;
  };
  std::vector<Move> moves;
};

constexpr double k_box_m = 1.3;
/// Maximum offset of a ball from its place, per axis. The offset lets box ends pass each other even
/// in straight rows of places.
constexpr double k_loose_m = 0.3;
constexpr std::size_t k_moves = 1 << 16;
constexpr std::size_t k_moves_verified = 2000;

/// Each ball starts within `loose_m` of its place, moves by steps of up to a third of `loose_m`,
/// and never leaves this range.
Balls moving(const std::vector<Balls::Point>& places, double loose_m) {
  random::Stream stream({.seed = 1, .purpose = random::Purpose::prior}, 0);
  const auto step = [&](double most) { return most * (2 * stream.uniform() - 1); };
  std::vector<Balls::Point> offsets(places.size());
  const auto box = [&](std::size_t ball) {
    Box made;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double centre = places[ball][axis] + offsets[ball][axis];
      made.low_m[axis] = static_cast<float>(centre - k_box_m / 2);
      made.high_m[axis] = static_cast<float>(centre + k_box_m / 2);
    }
    return made;
  };
  Balls made;
  for (std::size_t ball = 0; ball < places.size(); ++ball) {
    for (double& offset : offsets[ball])
      offset = step(loose_m);
    made.start.push_back(box(ball));
  }
  for (std::size_t i = 0; i < k_moves; ++i) {
    const std::size_t ball = stream.bits() % places.size();
    for (double& offset : offsets[ball])
      offset = std::clamp(offset + step(loose_m / 3), -loose_m, loose_m);
    made.moves.push_back({BodyId{static_cast<std::uint32_t>(ball)}, box(ball)});
  }
  return made;
}

/// A periodic cube at packing fraction 0.4. REQUIRES: n is a cube.
Balls uniform(std::uint32_t n) {
  constexpr double k_packing = 0.4;
  const auto side = static_cast<std::uint32_t>(std::lround(std::cbrt(n)));
  const double spacing = std::cbrt(3.14159265358979 / 6 / k_packing);
  std::vector<Balls::Point> places;
  for (std::uint32_t i = 0; i < n; ++i)
    places.push_back(
        {spacing * (i % side), spacing * (i / side % side), spacing * (i / side / side)});
  Balls made = moving(places, k_loose_m);
  made.period_m = {spacing * side, spacing * side, spacing * side};
  return made;
}

constexpr std::uint32_t k_shorter = 16;

/// A flat heap on a floor: square layers of balls. The side of each layer is k_shorter balls
/// shorter than the side of the layer below.
Balls clustered(std::uint32_t n) {
  const auto held = [](std::uint32_t side) {
    std::uint32_t sum = 0;
    for (; side > 0; side -= std::min(side, k_shorter))
      sum += side * side;
    return sum;
  };
  std::uint32_t side = 1;
  while (held(side) < n)
    ++side;
  std::vector<Balls::Point> places;
  for (std::uint32_t layer = 0; places.size() < n; ++layer, side -= k_shorter) {
    for (std::uint32_t i = 0; i < side * side && places.size() < n; ++i)
      places.push_back({0.5 * k_shorter * layer + i % side,
                        0.5 * k_shorter * layer + i / side % side, 0.8 * layer});
  }
  return moving(places, k_loose_m);
}

class Neighbours {
 public:
  explicit Neighbours(std::size_t bodies) : lists_(bodies) {
    for (auto& list : lists_)
      list.reserve(64);
  }
  struct Of {
    Neighbours& all;
    BodyId body;
    void begin(BodyId other) {
      all.lists_[body.value].push_back(other);
      all.lists_[other.value].push_back(body);
    }
    void end(BodyId other) {
      all.drop(body, other);
      all.drop(other, body);
    }
    std::span<const BodyId> neighbours() const { return all.lists_[body.value]; }
  };
  Of of(BodyId body) { return {*this, body}; }
  double mean() const {
    std::size_t sum = 0;
    for (const auto& list : lists_)
      sum += list.size();
    return static_cast<double>(sum) / static_cast<double>(lists_.size());
  }
  /// Hash of the set of pairs. The lists' order doesn't matter.
  std::uint64_t hash() const {
    ResultHash hash;
    for (std::uint64_t body = 0; body < lists_.size(); ++body) {
      std::vector<BodyId> sorted = lists_[body];
      std::ranges::sort(sorted);
      for (const BodyId other : sorted)
        hash.add(body << 32 | other.value);
    }
    return hash.value();
  }

 private:
  void drop(BodyId from, BodyId other) {
    auto& list = lists_[from.value];
    *std::ranges::find(list, other) = list.back();
    list.pop_back();
  }
  std::vector<std::vector<BodyId>> lists_;
};

template <physics::BroadPhase Structure>
void move(benchmark::State& state, const Balls& balls, std::uint64_t expected) {
  const auto n = static_cast<std::uint32_t>(balls.start.size());
  Structure structure({.bodies = n, .period_m = balls.period_m, .size_m = k_box_m});
  Neighbours neighbours(n);
  for (std::uint32_t body = 0; body < n; ++body) {
    auto sink = neighbours.of(BodyId{body});
    structure.insert(BodyId{body}, balls.start[body], sink);
  }
  std::size_t next = 0;
  const auto one = [&] {
    const Balls::Move& move = balls.moves[next++ % k_moves];
    auto sink = neighbours.of(move.body);
    structure.move(move.body, move.box, sink);
  };
  for (std::size_t i = 0; i < k_moves_verified; ++i)
    one();
  const std::uint64_t hash = neighbours.hash();
  for (auto _ : state)
    one();
  state.SetItemsProcessed(state.iterations());
  state.counters["overlaps_per_body"] = neighbours.mean();
  verify(state, hash, expected);
}

struct Case {
  const char* scene;
  Balls (*balls)(std::uint32_t);
  std::uint32_t n;
  std::uint64_t hash;  ///< the same for every structure
};
constexpr Case k_cases[] = {
    {"uniform", uniform, 64, 0xfb2498af3d61d135U},
    {"uniform", uniform, 1000, 0x423fc5b0c5631cf5U},
    {"uniform", uniform, 10648, 0x07b665ef36080e31U},
    {"clustered", clustered, 64, 0x5f08b9d95cf0bb35U},
    {"clustered", clustered, 1000, 0x93616ec4ab9a9605U},
    {"clustered", clustered, 10648, 0x0b5208b37faa2759U},
};

// The number of iterations is fixed, because each trial builds a scene (up to 2 s in
// sweep-and-prune).
template <physics::BroadPhase Structure>
void add(const char* structure, double iterations_over_n, std::int64_t most) {
  for (const Case& one : k_cases) {
    const auto iterations = std::min(most, static_cast<std::int64_t>(iterations_over_n / one.n));
    benchmark::RegisterBenchmark(
        fmt::format("broad_phase/{}/{}/{}", structure, one.scene, one.n).c_str(),
        [&one](benchmark::State& state) { move<Structure>(state, one.balls(one.n), one.hash); })
        ->Iterations(iterations);
  }
}

[[maybe_unused]] const bool k_added = [] {
  add<physics::AllPairs>("all_pairs", 1e8, 200'000);
  add<physics::SweepAndPrune>("sweep_and_prune", 2e7, 100'000);
  add<physics::HierarchicalGrid>("hierarchical_grid", 1e10, 500'000);
  return true;
}();

}  // namespace
}  // namespace sleight::bench
