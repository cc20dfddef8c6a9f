// An axis-aligned box that contains a body for a span of time (temporal bounding volume, thesis
// 3.2.1).
//
// Callers round a box's corners outwards to floats. Floats suffice, because boxes only select which
// pairs are watched and never affect results. Boxes are closed, so touching boxes overlap. Thread
// safety: values.
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
