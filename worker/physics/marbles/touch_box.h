// Touch boxes: where a ball's centre may be when the ball touches a feature.
//
// Idea. A feature is touched from within its region, so the way from the feature to the centre has
// a known spread of directions: of a face its normal alone, of an edge what is at right angles to
// it between its two faces, of a vertex what makes an obtuse angle with each of its edges. The
// feature's box, enlarged by a ball's radius times that spread, holds every such centre. Vertices
// that move change thousands of these boxes, so they are computed in vector registers, all axes at
// once; each number has the bits of the same operations on floats one by one.
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

/// A box in whole registers; the fourth numbers are 0.
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

/// So that a box holds a place, and some margin about it.
inline void enlarge(TouchBox& box, const Vec3& place_m, float margin_m) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at_m = static_cast<float>(place_m[static_cast<Eigen::Index>(axis)]);
    box.low_m[axis] = std::min(box.low_m[axis], at_m - margin_m);
    box.high_m[axis] = std::max(box.high_m[axis], at_m + margin_m);
  }
}

/// Holds no centre: of features that can't be met.
inline constexpr TouchBox k_unmeetable{
    .low_m = {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
              std::numeric_limits<float>::infinity(), 0},
    .high_m = {-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
               -std::numeric_limits<float>::infinity(), 0}};

/// A touch box is larger by this on each side: far more than the rounding in the verdict of a
/// collision.
inline constexpr double k_touch_box_pad_m = 1e-6;

/// Far more than rounding, and than what counts as a touch, does to a place.
inline constexpr double k_place_pad_m = 2e-6;

/// Whether two boxes overlap. Inline, since it is asked of all that is near a path.
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

/// The part of a touch box that hangs on a feature's own box alone; the fourth numbers are 0.
struct alignas(16) FeatureExtent {
  std::array<float, 4> low_m{};
  std::array<float, 4> high_m{};
  std::array<float, 4> pad_m{};
};

/// `reach_m`: the radius, and what counts as a touch.
FeatureExtent extent_of(const Box& own, float reach_m);

/// REQUIRES: the feature can be met, and is no plane without sides; its extent was made for the
/// same reach.
TouchBox touch_box_of(const SphereFeature& feature, std::span<const RegionSide> sides,
                      const FeatureExtent& extent, float reach_m);

/// All by feature.
struct TouchBoxes {
  std::span<const FeatureExtent> extents;
  std::span<const TouchBox> homes;
  std::span<TouchBox> boxes;
};

/// Writes the touch boxes of some features, k_unmeetable for those that can't be met, and appends
/// to `outgrown` those that their homes don't hold. REQUIRES: no planes.
void write_touch_boxes(const StaticGeometry& statics, std::span<const FeatureId> features,
                       float reach_m, const TouchBoxes& table, std::vector<FeatureId>& outgrown);

}  // namespace sleight::physics
