// Computes touch boxes. A touch box contains a ball's centre when the ball touches a feature.
//
// Idea. A ball touches a feature only from within the feature's region, so the direction from the
// feature to the centre is limited. For a face, the direction is the normal. For an edge, the
// direction is perpendicular to the edge, between its two faces. For a vertex, the direction makes
// an obtuse angle with each of its edges. A touch box is the feature's own box, enlarged by the
// ball's radius times these directions. Moving vertices change thousands of touch boxes, so vector
// registers compute all axes at once. Each number has the same bits as with scalar float
// operations.
//
// Thread safety: pure functions.
#pragma once

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/scene/static_geometry.h"

namespace sleight::physics {

/// A box in whole vector registers; the fourth numbers are 0.
struct alignas(32) TouchBox {
  std::array<float, 4> low_m{};
  std::array<float, 4> high_m{};
};

inline TouchBox touch_box_of(const Box& box) {
  TouchBox result;
  for (std::size_t i = 0; i < 3; ++i) {
    result.low_m[i] = box.low_m[i];
    result.high_m[i] = box.high_m[i];
  }
  return result;
}

inline void enlarge(TouchBox& box, const Vec3& place_m, float margin_m) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at_m = static_cast<float>(place_m[static_cast<Eigen::Index>(axis)]);
    box.low_m[axis] = std::min(box.low_m[axis], at_m - margin_m);
    box.high_m[axis] = std::max(box.high_m[axis], at_m + margin_m);
  }
}

/// An empty box, for features that can't be met.
inline constexpr TouchBox k_unmeetable{
    .low_m = {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
              std::numeric_limits<float>::infinity(), 0},
    .high_m = {-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
               -std::numeric_limits<float>::infinity(), 0}};

/// Padding of touch boxes on each side, far above the rounding in the verdict of a collision.
inline constexpr double k_touch_box_pad_m = 1e-6;

/// Padding of positions, far above their rounding and the touch distance.
inline constexpr double k_place_pad_m = 2e-6;

/// Whether two boxes overlap. Inline, since it is called for everything near a path.
inline bool overlaps(const TouchBox& a, const TouchBox& b) {
#ifdef __SSE2__
  const __m128 from_a = _mm_cmple_ps(_mm_load_ps(a.low_m.data()), _mm_load_ps(b.high_m.data()));
  const __m128 from_b = _mm_cmple_ps(_mm_load_ps(b.low_m.data()), _mm_load_ps(a.high_m.data()));
  return _mm_movemask_ps(_mm_and_ps(from_a, from_b)) == 15;
#else
  bool all = true;
  for (std::size_t i = 0; i < 3; ++i)
    all = all && a.low_m[i] <= b.high_m[i] && b.low_m[i] <= a.high_m[i];
  return all;
#endif
}

/// The part of a touch box that depends only on the feature's own box. The fourth numbers are 0.
struct alignas(16) FeatureExtent {
  std::array<float, 4> low_m{};
  std::array<float, 4> high_m{};
  std::array<float, 4> pad_m{};
};

/// `reach_m`: the radius plus the touch distance.
FeatureExtent extent_of(const Box& own, float reach_m);

/// REQUIRES: the feature can be met and isn't a plane without sides; `extent` was computed with the
/// same reach.
TouchBox touch_box_of(const SphereFeature& feature, std::span<const RegionSide> sides,
                      const FeatureExtent& extent, float reach_m);

/// Arrays indexed by feature.
struct TouchBoxes {
  std::span<const FeatureExtent> extents;
  std::span<const TouchBox> homes;
  std::span<TouchBox> boxes;
};

/// Writes the touch boxes of some features. If a feature can't be met, writes k_unmeetable. If a
/// touch box has left its home, appends the feature to `outgrown`. REQUIRES: no planes.
void write_touch_boxes(const StaticGeometry& statics, std::span<const FeatureId> features,
                       float reach_m, const TouchBoxes& table, std::vector<FeatureId>& outgrown);

}  // namespace sleight::physics
