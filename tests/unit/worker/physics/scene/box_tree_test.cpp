// Goal: a query finds every overlapping box once, and no other box. Method: compare the boxes that
// a query finds with the boxes that a loop over all boxes finds. The random boxes include points,
// slabs, clusters and equal boxes. Two trees of the same boxes must visit the boxes in the same
// order.
#include "worker/physics/scene/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/random/stream.h"

namespace sleight::physics::box_tree_test {

random::Stream stream_of(std::uint64_t part) {
  return random::Stream({.seed = 11, .purpose = random::Purpose::scene}, part);
}

Box random_box(random::Stream& stream, double spread_m, double size_m) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto low = static_cast<float>(spread_m * (stream.uniform() - 0.5));
    const double edge_m = stream.bits() % 4 == 0 ? 0 : size_m * stream.uniform();
    box.low_m[axis] = low;
    box.high_m[axis] = low + static_cast<float>(edge_m);
  }
  return box;
}

std::vector<std::uint32_t> visited(const BoxTree& tree, const Box& box) {
  std::vector<std::uint32_t> found;
  tree.for_each_overlap(box, [&](std::uint32_t index) { found.push_back(index); });
  return found;
}

std::vector<std::uint32_t> overlapping(const std::vector<Box>& boxes, const Box& box) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    if (overlap(boxes[i], box)) found.push_back(i);
  }
  return found;
}

/// Returns the total number of boxes found.
std::size_t expect_same(const std::vector<Box>& boxes, random::Stream& stream, double spread_m,
                        double size_m) {
  const BoxTree tree(boxes);
  const BoxTree again(boxes);
  std::size_t hits = 0;
  for (int query = 0; query < 50; ++query) {
    // One query in five is one of the boxes, so that corners coincide.
    const Box box = query % 5 == 0 && !boxes.empty() ? boxes[stream.bits() % boxes.size()]
                                                     : random_box(stream, spread_m, size_m);
    std::vector<std::uint32_t> found = visited(tree, box);
    EXPECT_EQ(found, visited(again, box));
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, overlapping(boxes, box));
    hits += found.size();
  }
  return hits;
}

TEST(BoxTree, FindsWhatOverlaps) {
  std::size_t hits = 0;
  std::uint64_t part = 0;
  for (const std::size_t count : {0U, 1U, 2U, 4U, 5U, 9U, 100U, 1000U, 5000U}) {
    for (const double size_m : {0.01, 0.3, 3.0}) {
      random::Stream stream = stream_of(part++);
      std::vector<Box> boxes;
      for (std::size_t i = 0; i < count; ++i)
        boxes.push_back(random_box(stream, 2, size_m));
      hits += expect_same(boxes, stream, 2, size_m);
    }
  }
  EXPECT_GT(hits, 10'000U);
}

TEST(BoxTree, TakesClustersAndEqualBoxes) {
  // All boxes but a distant one are in one cell of Morton's curve. Then all boxes are equal.
  random::Stream stream = stream_of(1000);
  std::vector<Box> boxes;
  for (int i = 0; i < 300; ++i)
    boxes.push_back(random_box(stream, 0.1, 0.03));
  boxes.push_back({.low_m = {1e6F, 1e6F, 1e6F}, .high_m = {1e6F, 1e6F, 1e6F}});
  EXPECT_GT(expect_same(boxes, stream, 0.1, 0.03), 100U);
  const std::vector<Box> equal(37, boxes[5]);
  EXPECT_GE(expect_same(equal, stream, 0.1, 0.01), 370U);
}

}  // namespace sleight::physics::box_tree_test
