// A bounding-volume tree over boxes that don't move, for overlap and distance queries.
//
// Idea. The boxes are sorted by the positions of their centres on Morton's space-filling curve,
// with ten bits per axis (Karras 2012, section 3). The sorted array is cut in two where the highest
// bit changes. Each part is cut again, until it has at most k_leaf boxes: it is then a leaf.
// Sorting takes three passes over the boxes, so rebuilding a tree costs less than repairing it. The
// nodes form one array in depth-first order. Each node stores the index at which queries continue
// if they miss the node's box, so queries need no stack.
//
// Invariants
//   1. Each box is in exactly one leaf; a node's box contains the boxes of all leaves below it.
//   2. The tree depends only on the boxes and their order.
// Thread safety: const functions may run concurrently.
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

  /// Calls visit(index) for each overlapping box, in an unspecified but reproducible order.
  template <class Visit>
  void for_each_overlap(const Box& box, Visit&& visit) const {
    for_each_that([&](const Box& other) { return meets(other, box); }, visit);
  }

  /// Calls visit(index) for each box within a distance, allowing for rounding. Compared with
  /// for_each_overlap on a widened box, fewer boxes are visited.
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
    std::uint32_t skip = 0;   ///< next node if this node's box is missed
    std::uint32_t begin = 0;  ///< boxes of a leaf; empty in inner nodes
    std::uint32_t end = 0;
  };

  /// Equals overlap(), but makes all six comparisons without branches: the processor couldn't
  /// predict which one fails first.
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
