// Boxes that don't move, as a tree: which of them does a box overlap?
//
// Idea. The boxes are halved by the middle of their longest spread, down to leaves of a few; nodes
// lie in one array in depth-first order, each with the place to go on at if its box is missed, so a
// query needs no stack.
// Thread safety: const functions may run at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/broad_phase/box.h"

namespace sleight::physics {

class BoxTree {
 public:
  BoxTree() = default;
  explicit BoxTree(std::span<const Box> boxes);

  /// Calls visit(index) for each overlapping box, in no particular order but always the same.
  template <class Visit>
  void for_each_overlap(const Box& box, Visit&& visit) const {
    std::uint32_t at = 0;
    while (at < nodes_.size()) {
      const Node& node = nodes_[at];
      if (!overlap(node.box, box)) {
        at = node.skip;
        continue;
      }
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        if (overlap(boxes_[i], box)) visit(indices_[i]);
      }
      ++at;
    }
  }

 private:
  static constexpr std::uint32_t k_leaf = 4;

  struct Node {
    Box box;
    std::uint32_t skip = 0;   ///< where to go on without the nodes below
    std::uint32_t begin = 0;  ///< a leaf's boxes; none in inner nodes
    std::uint32_t end = 0;
  };
  void build(std::span<const Box> boxes, std::uint32_t begin, std::uint32_t end);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> indices_;
  std::vector<Box> boxes_;  ///< in the order of indices_
};

}  // namespace sleight::physics
