// Axis-aligned boxes that hold a body for a span of time: temporal bounding volumes (thesis 3.2.1).
//
// Corners are floats: boxes only say which pairs to watch, never what happens, so they are small
// and rounded outwards by whoever makes them. Boxes are closed: touching ones overlap.
// Thread safety: values.
#pragma once

#include <array>
#include <cstddef>

namespace sleight::physics {

struct Box {
  std::array<float, 3> low_m{};   ///< least x, y, z
  std::array<float, 3> high_m{};  ///< greatest; >= low_m
};

constexpr bool overlap(const Box& a, const Box& b) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (a.low_m[axis] > b.high_m[axis] || b.low_m[axis] > a.high_m[axis]) return false;
  }
  return true;
}

}  // namespace sleight::physics
