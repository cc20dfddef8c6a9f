#include "worker/physics/simulator/box_tree.h"

#include <algorithm>
#include <numeric>

namespace sleight::physics {
namespace {

Box joined(const Box& a, const Box& b) {
  Box box = a;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low_m[axis] = std::min(a.low_m[axis], b.low_m[axis]);
    box.high_m[axis] = std::max(a.high_m[axis], b.high_m[axis]);
  }
  return box;
}

}  // namespace

BoxTree::BoxTree(std::span<const Box> boxes) {
  indices_.resize(boxes.size());
  std::iota(indices_.begin(), indices_.end(), 0U);
  if (!boxes.empty()) build(boxes, 0, static_cast<std::uint32_t>(boxes.size()));
  for (const std::uint32_t index : indices_)
    boxes_.push_back(boxes[index]);
}

void BoxTree::build(std::span<const Box> boxes, std::uint32_t begin, std::uint32_t end) {
  const auto place = static_cast<std::uint32_t>(nodes_.size());
  Box all = boxes[indices_[begin]];
  for (std::uint32_t i = begin; i < end; ++i)
    all = joined(all, boxes[indices_[i]]);
  nodes_.push_back({.box = all});
  if (end - begin <= k_leaf) {
    nodes_[place].begin = begin;
    nodes_[place].end = end;
  } else {
    // Halve along the axis on which the middles lie furthest apart; ties by index.
    const auto middle = [&](std::uint32_t index, std::size_t axis) {
      return boxes[index].low_m[axis] + boxes[index].high_m[axis];
    };
    std::size_t best = 0;
    float widest = -1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float low = middle(indices_[begin], axis);
      float high = low;
      for (std::uint32_t i = begin; i < end; ++i) {
        low = std::min(low, middle(indices_[i], axis));
        high = std::max(high, middle(indices_[i], axis));
      }
      if (high - low > widest) {
        widest = high - low;
        best = axis;
      }
    }
    const std::uint32_t half = begin + (end - begin) / 2;
    std::nth_element(indices_.begin() + begin, indices_.begin() + half, indices_.begin() + end,
                     [&](std::uint32_t a, std::uint32_t b) {
                       const float of_a = middle(a, best);
                       const float of_b = middle(b, best);
                       return of_a < of_b || (of_a == of_b && a < b);
                     });
    build(boxes, begin, half);
    build(boxes, half, end);
  }
  nodes_[place].skip = static_cast<std::uint32_t>(nodes_.size());
}

}  // namespace sleight::physics
