// What the broad phases are made of: the hash table, the ring of extents, the table of cells.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <optional>
#include <set>

#include "tests/unit/worker/physics/broad_phase/scenes.h"
#include "worker/physics/broad_phase/cell_table.h"
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

/// Whether two arcs of a ring of 2^8 points share one, by going through the first's.
bool share_a_point(RingPoint start_a, RingPoint width_a, RingPoint start_b, RingPoint width_b) {
  for (std::uint32_t i = 0; i <= width_a; ++i) {
    if (static_cast<RingPoint>(start_a + i - start_b) <= width_b) return true;
  }
  return false;
}

TEST(CellTable, KeepsEachBodyInItsCell) {
  // Goal: invariants 1 and 2, through first blocks that fill up and run empty. Method: random
  // links, changes and removals of 100 bodies, mostly in 4 cells, so that chains have up to 13
  // blocks; after each, walk a cell with a query that covers everything, against a plain list.
  constexpr std::uint32_t k_bodies = 100;
  CellTable table(k_bodies);
  ASSERT_EQ(table.cells(), 64U);
  const CellTable::Query everything(
      Sketch{.start = {}, .width = {k_whole_ring, k_whole_ring, k_whole_ring}});
  std::vector<std::optional<std::uint32_t>> cell_of(k_bodies);
  std::vector<RingPoint> width_of(k_bodies);
  std::size_t most_blocks = 0;
  Dice dice(8);
  for (int i = 0; i < 100000; ++i) {
    // Phases that fill it and phases that empty it.
    const bool fill = i / 1000 % 2 == 0;
    const std::uint32_t body = dice.below(k_bodies);
    const std::uint32_t cell = dice.once_in(10) ? dice.below(UINT32_MAX) : dice.below(4);
    width_of[body] = static_cast<RingPoint>(dice.below(256));
    const Sketch sketch{.start = {}, .width = {1, width_of[body], 2}};
    std::optional<std::uint32_t>& at = cell_of[body];
    const std::uint32_t looked_at = at.value_or(cell) % table.cells();
    if (!at) {
      table.link(body, cell, sketch);
      at = cell;
    } else if (dice.once_in(fill ? 10 : 2)) {
      table.unlink(body);
      at.reset();
    } else {
      table.change(body, cell, sketch);
      at = cell;
    }
    for (const std::uint32_t look : {looked_at, cell % table.cells()}) {
      std::vector<std::uint32_t> found;
      std::uint32_t first = 0;
      const bool any = table.add_if_any(look, &first) != &first;
      std::size_t blocks = 0;
      for (std::uint32_t block = first; any && block != CellTable::k_none;
           block = table.next(block)) {
        ++blocks;
        const std::uint32_t bits = table.overlapping(block, everything);
        ASSERT_TRUE(block == first || bits == 0xFFU) << bits;
        ASSERT_EQ(bits & (bits + 1), 0U) << "slots are filled from the first on";
        for (int slot = 0; slot < std::popcount(bits); ++slot)
          found.push_back(table.body(block, static_cast<std::uint32_t>(slot)));
      }
      most_blocks = std::max(most_blocks, blocks);
      std::ranges::sort(found);
      std::vector<std::uint32_t> expected;
      for (std::uint32_t other = 0; other < k_bodies; ++other) {
        if (cell_of[other] && *cell_of[other] % table.cells() == look) expected.push_back(other);
      }
      ASSERT_EQ(found, expected) << "after " << i;
      for (const std::uint32_t other : found)
        ASSERT_EQ(table.width(other, 1), width_of[other]);
    }
  }
  EXPECT_GE(most_blocks, 3U) << "no chains";
}

TEST(CellTable, ComparesArcsOfARing) {
  // Goal: sketches overlap exactly if their arcs share a point on each axis, also where ends wrap
  // and widths together exceed the ring. Method: one random sketch in a slot, against going through
  // points; arcs on few places, so that ends meet.
  Dice dice(9);
  const auto number = [&](std::uint32_t scale) {
    return static_cast<RingPoint>(dice.below(8) * scale + dice.below(2) - 1);
  };
  const auto sketch = [&] {
    Sketch made;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      made.start[axis] = number(32);
      made.width[axis] = dice.once_in(8) ? k_whole_ring : number(dice.once_in(2) ? 32 : 2);
    }
    return made;
  };
  int overlaps = 0;
  for (int i = 0; i < 4000; ++i) {
    CellTable table(1);
    const Sketch a = sketch();
    const Sketch b = sketch();
    table.link(0, 5, a);
    bool expected = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      expected &= share_a_point(a.start[axis], a.width[axis], b.start[axis], b.width[axis]);
    ASSERT_EQ(table.overlapping(5, CellTable::Query(b)), expected ? 1U : 0U);
    overlaps += expected ? 1 : 0;
  }
  EXPECT_GT(overlaps, 400);
  EXPECT_LT(overlaps, 3600);
}

}  // namespace
}  // namespace sleight::physics
