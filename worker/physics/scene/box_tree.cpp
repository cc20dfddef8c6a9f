#include "worker/physics/scene/box_tree.h"

#include <algorithm>
#include <bit>

namespace sleight::physics {
namespace {

constexpr std::uint32_t k_bits = 10;  ///< per axis, and per pass of the sort
constexpr std::uint32_t k_digits = 1U << k_bits;

void join(Box& box, const Box& other) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low_m[axis] = std::min(box.low_m[axis], other.low_m[axis]);
    box.high_m[axis] = std::max(box.high_m[axis], other.high_m[axis]);
  }
}

/// Spreads ten bits, inserting two zeros before each bit.
std::uint32_t spread(std::uint32_t bits) {
  bits = (bits | bits << 16) & 0x030000FF;
  bits = (bits | bits << 8) & 0x0300F00F;
  bits = (bits | bits << 4) & 0x030C30C3;
  return (bits | bits << 2) & 0x09249249;
}

/// Returns twice the middle of a box along an axis.
float middle(const Box& box, std::size_t axis) {
  return box.low_m[axis] + box.high_m[axis];
}

struct Item {
  std::uint32_t code;
  std::uint32_t index;
};

/// Returns each box's Morton code.
std::vector<Item> coded(std::span<const Box> boxes) {
  std::array<float, 3> low{};
  std::array<float, 3> high{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    low[axis] = high[axis] = middle(boxes[0], axis);
  for (const Box& box : boxes) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], middle(box, axis));
      high[axis] = std::max(high[axis], middle(box, axis));
    }
  }
  // Use one scale for all axes, so that cells are cubes.
  const float extent = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  const float scale = extent > 0 ? static_cast<float>(k_digits) / extent : 0;
  std::vector<Item> items(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    std::uint32_t code = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float cell = (middle(boxes[i], axis) - low[axis]) * scale;
      code |= spread(std::min(static_cast<std::uint32_t>(cell), k_digits - 1)) << axis;
    }
    items[i] = {.code = code, .index = static_cast<std::uint32_t>(i)};
  }
  return items;
}

/// Sorts by code, then by index, with a stable radix sort.
void sort(std::vector<Item>& items) {
  std::vector<Item> other(items.size());
  std::array<std::uint32_t, k_digits> places;
  for (std::uint32_t pass = 0; pass < 3; ++pass) {
    const auto digit = [pass](const Item& item) {
      return item.code >> (pass * k_bits) & (k_digits - 1);
    };
    places.fill(0);
    for (const Item& item : items)
      ++places[digit(item)];
    std::uint32_t before = 0;
    for (std::uint32_t& place : places) {
      const std::uint32_t count = place;
      place = before;
      before += count;
    }
    for (const Item& item : items)
      other[places[digit(item)]++] = item;
    items.swap(other);
  }
}

}  // namespace

BoxTree::BoxTree(std::span<const Box> boxes) {
  if (boxes.empty()) return;
  std::vector<Item> items = coded(boxes);
  sort(items);
  indices_.reserve(items.size());
  boxes_.reserve(items.size());
  std::vector<std::uint32_t> codes;
  codes.reserve(items.size());
  for (const Item& item : items) {
    indices_.push_back(item.index);
    boxes_.push_back(boxes[item.index]);
    codes.push_back(item.code);
  }
  nodes_.reserve(boxes.size() + 1);
  build(codes, 0, static_cast<std::uint32_t>(boxes.size()));
}

Box BoxTree::build(std::span<const std::uint32_t> codes, std::uint32_t begin, std::uint32_t end) {
  const auto place = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Box all = boxes_[begin];
  if (end - begin <= k_leaf) {
    for (std::uint32_t i = begin + 1; i < end; ++i)
      join(all, boxes_[i]);
    nodes_[place].begin = begin;
    nodes_[place].end = end;
  } else {
    // Some bits differ among the codes: cut where the highest one changes. If all codes are equal,
    // cut in the middle.
    std::uint32_t cut = begin + (end - begin) / 2;
    if (const std::uint32_t differ = codes[begin] ^ codes[end - 1]; differ != 0) {
      const std::uint32_t bit = std::bit_floor(differ);
      cut = static_cast<std::uint32_t>(
          std::partition_point(codes.begin() + begin, codes.begin() + end,
                               [bit](std::uint32_t code) { return (code & bit) == 0; }) -
          codes.begin());
    }
    all = build(codes, begin, cut);
    join(all, build(codes, cut, end));
  }
  nodes_[place].box = all;
  nodes_[place].skip = static_cast<std::uint32_t>(nodes_.size());
  return all;
}

}  // namespace sleight::physics
