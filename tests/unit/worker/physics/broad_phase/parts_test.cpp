// What the broad phases are made of: the hash table, the ring of extents.
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>

#include "tests/unit/worker/physics/broad_phase/scenes.h"
#include "worker/physics/broad_phase/extent_ring.h"
#include "worker/physics/broad_phase/flat_table.h"

namespace sleight::physics {
namespace {

TEST(FlatTable, EqualsASet) {
  // Goal: inserting, finding and erasing, through collisions, gaps that close and growth. Method:
  // random pairs of few bodies, against std::set.
  PairTable table;
  std::set<std::uint64_t> expected;
  Dice dice(4);
  for (int i = 0; i < 200000; ++i) {
    const std::uint32_t range = i < 100000 ? 12 : 200;
    const std::uint32_t a = dice.below(range);
    const std::uint64_t key = pair_key(a, a + 1 + dice.below(range));
    ASSERT_EQ(table.contains(key), expected.contains(key));
    if (dice.once_in(2)) {
      ASSERT_EQ(table.insert(key).second, expected.insert(key).second);
      ASSERT_EQ(table.find(key)->key, key);
    } else {
      ASSERT_EQ(table.erase(key), expected.erase(key) == 1);
      ASSERT_EQ(table.find(key), nullptr);
    }
    ASSERT_EQ(table.size(), expected.size());
  }
}

TEST(ExtentRing, NamesAllPairsThatChange) {
  // Goal: whoever begins or ceases to overlap on an axis is among those visited, also for arcs of
  // nearly the whole ring. Method: random arcs on few points of a ring of 2^32, single travels and
  // travels of all, against the definition.
  constexpr std::uint32_t k_bodies = 8;
  Dice dice(5);
  const auto any_arc = [&] {
    const std::uint32_t width = dice.once_in(6) ? UINT32_MAX - dice.below(3) : dice.below(7) << 28;
    return Arc{dice.below(16) << 28, width};
  };
  for (int round = 0; round < 300; ++round) {
    ExtentRing ring(k_bodies);
    std::array<Arc, k_bodies> arcs;
    for (std::uint32_t body = 0; body < k_bodies; ++body) {
      arcs[body] = any_arc();
      ring.insert(body, arcs[body]);
    }
    for (int i = 0; i < 100; ++i) {
      const std::array<Arc, k_bodies> before = arcs;
      std::set<std::uint64_t> visited;
      if (dice.once_in(2)) {
        const std::uint32_t body = dice.below(k_bodies);
        arcs[body] = any_arc();
        ring.move(body, travel(before[body], arcs[body], true),
                  [&](std::uint32_t other) { visited.insert(pair_key(body, other)); });
      } else {
        for (Arc& arc : arcs)
          arc = any_arc();
        ring.move_all([&](std::uint32_t body) { return travel(before[body], arcs[body], true); },
                      [&](std::uint32_t a, std::uint32_t b) { visited.insert(pair_key(a, b)); });
      }
      for (std::uint32_t a = 0; a < k_bodies; ++a) {
        for (std::uint32_t b = a + 1; b < k_bodies; ++b) {
          if (overlap(before[a], before[b]) != overlap(arcs[a], arcs[b])) {
            ASSERT_TRUE(visited.contains(pair_key(a, b))) << a << " " << b;
          }
        }
      }
    }
  }
}

TEST(ExtentRing, TravelKeepsArcsRightSideOut) {
  // Goal: travel ends at the new arc, turns neither end by a whole turn, and on an axis that does
  // not repeat never crosses the seam. Method: random and extreme arcs.
  constexpr std::int64_t k_turn = std::int64_t{1} << 32;
  Dice dice(6);
  const auto any_arc = [&] {
    const std::uint32_t start = dice.below(UINT32_MAX);
    return Arc{start, dice.once_in(3) ? UINT32_MAX : dice.below(UINT32_MAX - start)};
  };
  for (int i = 0; i < 100000; ++i) {
    const Arc from = any_arc();
    const Arc to = any_arc();
    const ArcTravel by = travel(from, to, true);
    ASSERT_EQ(from.start + static_cast<std::uint32_t>(by.first), to.start);
    ASSERT_EQ(by.last - by.first, std::int64_t{to.width} - std::int64_t{from.width});
    ASSERT_LT(std::abs(by.first), k_turn);
    ASSERT_LT(std::abs(by.last), k_turn);
    ASSERT_EQ(std::int64_t{from.start} + travel(from, to, false).first, std::int64_t{to.start});
  }
}

}  // namespace
}  // namespace sleight::physics
