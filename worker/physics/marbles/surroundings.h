// Stores the features that a ball may touch while it hardly moves.
//
// Idea. Most motions, such as dying bounces and pieces of rolling, are much shorter than a ball is
// wide. So the features that a ball may touch from anywhere in a small box are listed once. The
// list is used until the ball leaves the box. Computing the list may cost more than a cell
// (near_features.h), because it is used often. Unlike a cell, the list omits features whose regions
// the ball can't enter.
//
// Invariant: while a ball's centre is in the box, the ball collides with no feature of the cell
// that isn't in the list, even with rounding. Thread safety: const functions may run concurrently.
#pragma once

#include <array>
#include <cstdint>

#include "worker/physics/marbles/four.h"
#include "worker/physics/marbles/near_features.h"

namespace sleight::physics {

class Surroundings {
 public:
  bool holds(const Four& centre_m) const {
    return !is_any_negative(centre_m - low_m_) && !is_any_negative(high_m_ - centre_m);
  }
  /// Returns the features as a cell whose reach is the box. REQUIRES: holds() is true for some
  /// centre.
  NearFeatures::Cell cell() const {
    const std::span<const FeatureId> all(features_);
    return {.low_m = low_m_,
            .high_m = high_m_,
            .faces = all.first(face_count_),
            .corners = all.subspan(face_count_, corner_count_)};
  }
  /// Computes the box and the features for a centre in a cell. If there are too many features, the
  /// box is empty. REQUIRES: the geometry doesn't change until the next call.
  void settle(const NearFeatures& near, const NearFeatures::Cell& cell, const Four& centre_m);

 private:
  static constexpr std::size_t k_most = 24;
  // The initial box is empty.
  Four low_m_ = Four::all(1);
  Four high_m_ = Four::all(-1);
  std::uint32_t face_count_ = 0;
  std::uint32_t corner_count_ = 0;
  std::array<FeatureId, k_most> features_{};
};

/// Half the box's edge, as a share of the radius. Affects speed only.
inline constexpr double k_settled_radii = 0.25;

}  // namespace sleight::physics
