// Stores the boxes of all balls and answers overlap queries.
//
// Idea. When a ball's motion changes, its box is compared with all other boxes. For some ten balls,
// this is cheaper than any search structure. For each axis, the coordinates of four boxes are
// stored side by side, so that four boxes are compared at once.
//
// Invariant: boxes beyond the last ball overlap no box. Thread safety: const functions may run
// concurrently.
#pragma once

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "worker/physics/marbles/near_features.h"

namespace sleight::physics {

class BallBoxes {
 public:
  /// Makes `count` boxes that overlap no box.
  void assign(std::size_t count) {
    constexpr float k_infinity = std::numeric_limits<float>::infinity();
    Group nowhere;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      nowhere.low_m[axis].fill(k_infinity);
      nowhere.high_m[axis].fill(-k_infinity);
    }
    groups_.assign((count + 3) / 4, nowhere);
  }
  void set(BodyId ball, const TouchBox& box) {
    Group& group = groups_[ball / 4];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      group.low_m[axis][ball % 4] = box.low_m[axis];
      group.high_m[axis][ball % 4] = box.high_m[axis];
    }
  }
  TouchBox of(BodyId ball) const {
    const Group& group = groups_[ball / 4];
    TouchBox box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low_m[axis] = group.low_m[axis][ball % 4];
      box.high_m[axis] = group.high_m[axis][ball % 4];
    }
    return box;
  }
  /// Calls visit(ball) in ascending order for each ball whose box overlaps `box`. REQUIRES: `visit`
  /// changes no box.
  template <class Visit>
  void for_each_overlapping(const TouchBox& box, const Visit& visit) const {
    std::uint32_t first = 0;
    for (const Group& group : groups_) {
      for (std::uint32_t some = overlapped(group, box); some != 0; some &= some - 1)
        visit(BodyId{first + static_cast<std::uint32_t>(std::countr_zero(some))});
      first += 4;
    }
  }

 private:
  /// Coordinates of four balls' boxes, by axis.
  struct alignas(16) Group {
    std::array<std::array<float, 4>, 3> low_m;
    std::array<std::array<float, 4>, 3> high_m;
  };
  /// Returns one bit for each ball of a group, set if its box overlaps `box`.
  static std::uint32_t overlapped(const Group& group, const TouchBox& box) {
#ifdef __SSE2__
    const auto along = [&](std::size_t axis) {
      const __m128 from =
          _mm_cmple_ps(_mm_load_ps(group.low_m[axis].data()), _mm_set1_ps(box.high_m[axis]));
      const __m128 to =
          _mm_cmple_ps(_mm_set1_ps(box.low_m[axis]), _mm_load_ps(group.high_m[axis].data()));
      return _mm_and_ps(from, to);
    };
    return static_cast<std::uint32_t>(
        _mm_movemask_ps(_mm_and_ps(_mm_and_ps(along(0), along(1)), along(2))));
#else
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      bool all = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        all = all && group.low_m[axis][i] <= box.high_m[axis] &&
              box.low_m[axis] <= group.high_m[axis][i];
      bits |= all ? std::uint32_t{1} << i : 0;
    }
    return bits;
#endif
  }

  std::vector<Group> groups_;
};

}  // namespace sleight::physics
