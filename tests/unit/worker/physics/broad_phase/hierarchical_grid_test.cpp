// Tests cases that only the grid can get wrong: full cells, shared cell numbers and a varying
// reach.
#include <gtest/gtest.h>

#include "tests/engines/all_pairs.h"
#include "tests/unit/worker/physics/broad_phase/neighbourhood.h"
#include "tests/unit/worker/physics/broad_phase/scenes.h"
#include "worker/physics/broad_phase/hierarchical_grid.h"

namespace sleight::physics::hierarchical_grid_test {

/// The grid and the reference. Both receive the same operations.
class Twins {
 public:
  explicit Twins(const BroadPhaseOptions& options)
      : grid_(options), all_(options), told_grid_(options.bodies), told_all_(options.bodies) {}

  void put(std::uint32_t body, const Box& box) {
    auto grid = told_grid_.of(BodyId{body});
    auto all = told_all_.of(BodyId{body});
    if (grid_.contains(BodyId{body})) {
      grid_.move(BodyId{body}, box, grid);
      all_.move(BodyId{body}, box, all);
    } else {
      grid_.insert(BodyId{body}, box, grid);
      all_.insert(BodyId{body}, box, all);
    }
  }
  /// Returns the number of boxes that overlap the body's box. Checks that grid and reference agree.
  std::size_t overlaps(std::uint32_t body) {
    EXPECT_EQ(told_grid_.complaint(), "");
    EXPECT_EQ(sorted(told_grid_, body), sorted(told_all_, body)) << "of body " << body;
    return told_grid_.neighbours(BodyId{body}).size();
  }

 private:
  static std::vector<BodyId> sorted(const Neighbourhood& told, std::uint32_t body) {
    const std::span<const BodyId> list = told.neighbours(BodyId{body});
    std::vector<BodyId> made(list.begin(), list.end());
    std::ranges::sort(made);
    return made;
  }
  HierarchicalGrid grid_;
  AllPairs all_;
  Neighbourhood told_grid_;
  Neighbourhood told_all_;
};

Box cube(double x, double y, double z, double edge) {
  const auto at = [](double value) { return static_cast<float>(value); };
  return {{at(x), at(y), at(z)}, {at(x + edge), at(y + edge), at(z + edge)}};
}

Box somewhere(Dice& dice, double room_m, double edge) {
  return cube(dice.between(0, room_m), dice.between(0, room_m), dice.between(0, room_m), edge);
}

TEST(HierarchicalGrid, HoldsTenThousandInOneCell) {
  // Goal: the grid finds the right overlaps even if a cell has far more bodies than one block can
  // hold. Method: put 10,000 boxes of one level into one cell. Few of the boxes overlap, although
  // all low corners are within a hundredth of the cell. Move random boxes within the cell, out of
  // it and back, and compare the grid with the reference.
  constexpr std::uint32_t k_bodies = 10000;
  Twins twins({.bodies = k_bodies, .size_m = 100});
  Dice dice(11);
  // The plates are 80 m long, because the typical level begins at edges of 63 m. The plates are 3
  // mm thin, so few of them overlap.
  const auto plate = [&](double x) {
    const auto y = static_cast<float>(dice.between(0, 1));
    const auto z = static_cast<float>(dice.between(0, 1));
    return Box{{static_cast<float>(x), y, z}, {static_cast<float>(x + 80), y + 0.003F, z + 0.003F}};
  };
  for (std::uint32_t body = 0; body < k_bodies; ++body)
    twins.put(body, plate(dice.between(0, 1)));
  std::size_t overlaps = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::uint32_t body = dice.below(k_bodies);
    twins.put(body, plate(dice.once_in(3) ? 1000 : dice.between(0, 1)));
    overlaps += twins.overlaps(body);
  }
  EXPECT_GT(overlaps, 100U);
}

TEST(HierarchicalGrid, FindsEachBodyOnceWhereCellsShareNumbers) {
  // Goal: a query reports each body once, even if the query visits more cells than there are
  // entries in the cell table. Method: put 2000 small boxes into a clump of 1024 cells. Move a box
  // that is twelve small cells long onto the clump and far away again. Repeat this at different
  // places of the clump.
  constexpr std::uint32_t k_bodies = 2001;
  Twins twins({.bodies = k_bodies, .size_m = 1});
  Dice dice(12);
  for (std::uint32_t body = 0; body + 1 < k_bodies; ++body)
    twins.put(body, somewhere(dice, 0.05, 1 + dice.between(0, 1)));
  for (int i = 0; i < 25; ++i) {
    twins.put(k_bodies - 1, cube(1000, 0, 0, 1));
    EXPECT_EQ(twins.overlaps(k_bodies - 1), 0U);
    twins.put(k_bodies - 1,
              cube(-dice.between(0, 15), -dice.between(0, 15), -dice.between(0, 15), 15.5));
    EXPECT_EQ(twins.overlaps(k_bodies - 1), k_bodies - 1);
  }
}

TEST(HierarchicalGrid, ReachGrowsAndShrinks) {
  // Goal: if a box grows, the grid reports the box's overlaps with distant boxes at once. The box
  // may stay at its level or move to a higher level. After boxes shrink, the grid misses no
  // overlap. Method: compare the overlaps of 300 boxes with the reference. The largest box size
  // differs from round to round. One run has periods, and the other run has none.
  for (const double period_m : {0.0, 24.0}) {
    Twins twins({.bodies = 300, .period_m = {period_m, period_m, 0}, .size_m = 1});
    Dice dice(13);
    std::size_t overlaps = 0;
    for (int round = 0; round < 12; ++round) {
      const double most =
          std::array{1.0, 2.4, 0.7, 9.0, 1.0, 0.1}[static_cast<std::size_t>(round) % 6];
      for (int i = 0; i < 3000; ++i) {
        const std::uint32_t body = dice.below(300);
        Box box = somewhere(dice, 20, dice.between(0.5, 1) * most);
        const std::size_t axis = dice.below(3);
        box.high_m[axis] = box.low_m[axis] + (box.high_m[axis] - box.low_m[axis]) / 4;
        twins.put(body, box);
        if (dice.once_in(10)) overlaps += twins.overlaps(body);
      }
      for (std::uint32_t body = 0; body < 300; ++body)
        overlaps += twins.overlaps(body);
    }
    EXPECT_GT(overlaps, 1000U);
  }
}

}  // namespace sleight::physics::hierarchical_grid_test
