// That broad phases stop allocating once warm.
#include <gtest/gtest.h>

#include "tests/unit/worker/physics/broad_phase/scenes.h"
#include "tests/unit/worker/physics/counted_allocations.h"
#include "worker/physics/broad_phase/all_pairs.h"
#include "worker/physics/broad_phase/hierarchical_grid.h"
#include "worker/physics/broad_phase/sweep_and_prune.h"

namespace sleight::physics {
namespace {

using counting::allocations;

/// Lists of neighbours without allocation: one bit per pair, and room for one list.
class FixedSink {
 public:
  explicit FixedSink(std::uint32_t bodies) : bodies_(bodies), pairs_(bodies * bodies) {
    list_.reserve(bodies);
  }
  void look_at(std::uint32_t body) {
    body_ = body;
    list_.clear();
    for (std::uint32_t other = 0; other < bodies_; ++other) {
      if (pairs_[body * bodies_ + other]) list_.push_back(BodyId{other});
    }
  }
  void begin(BodyId other) { set(body_, other.value, true); }
  void end(BodyId other) { set(body_, other.value, false); }
  void begin(BodyId a, BodyId b) { set(a.value, b.value, true); }
  void end(BodyId a, BodyId b) { set(a.value, b.value, false); }
  std::span<const BodyId> neighbours() const { return list_; }
  std::span<const BodyId> neighbours(BodyId body) {
    look_at(body.value);
    return list_;
  }

 private:
  void set(std::uint32_t a, std::uint32_t b, bool value) {
    pairs_[a * bodies_ + b] = value;
    pairs_[b * bodies_ + a] = value;
  }
  std::uint32_t bodies_;
  std::vector<bool> pairs_;
  std::uint32_t body_ = 0;
  std::vector<BodyId> list_;
};

template <class Structure>
class BroadPhaseAllocation : public ::testing::Test {};
using Structures = ::testing::Types<AllPairs, SweepAndPrune, HierarchicalGrid>;
TYPED_TEST_SUITE(BroadPhaseAllocation, Structures);

TYPED_TEST(BroadPhaseAllocation, StopsOnceWarm) {
  // Goal: invariant 4 of broad_phase.h. Method: count calls of operator new over 2000 random moves,
  // removals, insertions and moves of all, after doing those same ones once.
  constexpr std::uint32_t k_bodies = 100;
  for (const Scene& scene : scenes()) {
    TypeParam structure({.bodies = k_bodies, .period_m = scene.period_m, .size_m = scene.size_m});
    FixedSink sink(k_bodies);
    std::vector<Box> all(k_bodies);
    std::uint64_t warm = 0;
    for (int round = 0; round < 2; ++round) {
      Dice dice(7);
      warm = allocations;
      for (int i = 0; i < 2000; ++i) {
        const BodyId body{dice.below(k_bodies)};
        sink.look_at(body.value);
        Box& box = all[body.value];
        box = scene.fresh(dice);
        if (!structure.contains(body)) {
          structure.insert(body, box, sink);
        } else if (dice.once_in(8)) {
          structure.remove(body, sink);
        } else {
          structure.move(body, box, sink);
        }
        if (dice.once_in(20)) structure.move_all(all, sink);
      }
      // The second round begins as the first did, with nobody there.
      for (std::uint32_t body = 0; body < k_bodies; ++body) {
        sink.look_at(body);
        if (structure.contains(BodyId{body})) structure.remove(BodyId{body}, sink);
      }
    }
    EXPECT_GT(warm, 0U) << "the counter does not count";
    EXPECT_EQ(allocations, warm) << scene.name;
  }
}

}  // namespace
}  // namespace sleight::physics
