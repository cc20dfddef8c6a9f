// Boxes that don't move, as a tree: which of them does a box overlap?
//
// Idea. The boxes are sorted along a curve that fills space (Morton's order of their middles, ten
// bits per axis; Karras 2012, section 3) and cut in two where the highest bit changes, down to
// leaves of a few. Sorting takes three passes over the boxes, so a tree is built anew for less than
// it would cost to mend. Nodes lie in one array in depth-first order, each with the place to go on
// at if its box is missed, so a query needs no stack.
//
// Invariants
//   1. Each box lies in one leaf; a node's box holds those of all leaves below it.
//   2. The tree is a function of the boxes in their order.
// Thread safety: const functions may run at once.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/broad_phase/box.h"

namespace sleight::physics {

class BoxTree {
 public:
  BoxTree() = default;
  /// REQUIRES: finite corners.
  explicit BoxTree(std::span<const Box> boxes);

  /// Calls visit(index) for each overlapping box, in no particular order but always the same.
  template <class Visit>
  void for_each_overlap(const Box& box, Visit&& visit) const {
    for_each_that([&](const Box& other) { return meets(other, box); }, visit);
  }

  /// The same for each box that is within a distance, or by rounding a little more: fewer than
  /// overlap a box that is wider by it.
  template <class Visit>
  void for_each_within(const Box& box, float distance_m, Visit&& visit) const {
    constexpr float k_rounding = 1 + 0x1p-18F;
    const float most_m2 = k_rounding * distance_m * distance_m;
    for_each_that([&](const Box& other) { return square_distance_m2(other, box) <= most_m2; },
                  visit);
  }

 private:
  static constexpr std::uint32_t k_leaf = 4;

  struct Node {
    Box box;
    std::uint32_t skip = 0;   ///< where to go on without the nodes below
    std::uint32_t begin = 0;  ///< a leaf's boxes; none in inner nodes
    std::uint32_t end = 0;
  };

  /// overlap(), all six comparisons at once: which of them fails first can't be foretold.
  static bool meets(const Box& a, const Box& b) {
    unsigned apart = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      apart |= static_cast<unsigned>(a.low_m[axis] > b.high_m[axis]);
      apart |= static_cast<unsigned>(b.low_m[axis] > a.high_m[axis]);
    }
    return apart == 0;
  }
  static float square_distance_m2(const Box& a, const Box& b) {
    float sum_m2 = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float apart_m =
          std::max(std::max(a.low_m[axis] - b.high_m[axis], b.low_m[axis] - a.high_m[axis]), 0.0F);
      sum_m2 += apart_m * apart_m;
    }
    return sum_m2;
  }
  template <class Test, class Visit>
  void for_each_that(const Test& test, Visit& visit) const {
    std::uint32_t at = 0;
    const auto end = static_cast<std::uint32_t>(nodes_.size());
    while (at < end) {
      const Node& node = nodes_[at];
      if (!test(node.box)) {
        at = node.skip;
        continue;
      }
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        if (test(boxes_[i])) visit(indices_[i]);
      }
      ++at;
    }
  }
  Box build(std::span<const std::uint32_t> codes, std::uint32_t begin, std::uint32_t end);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> indices_;
  std::vector<Box> boxes_;  ///< in the order of indices_
};

}  // namespace sleight::physics
