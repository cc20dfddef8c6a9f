// What a ball that hardly moves may touch.
//
// Idea. Most motions are much shorter than a ball is wide: bounces that die out, pieces of rolling.
// So what a ball may touch from anywhere in a small box is looked up once and asked until it leaves
// that box. As it is asked often, it may cost something to leave out what only comes near: unlike a
// cell of the table (near_features.h), it leaves out features into whose region the ball can't
// come.
//
// Invariant: of the features in the cells' lists, the ball collides with none but those here while
// its centre is in the box, rounding included.
// Thread safety: const functions may run at once.
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
  /// As of a cell whose reach is the box. REQUIRES: it holds some centre.
  NearFeatures::Cell cell() const {
    const std::span<const FeatureId> all(features_);
    return {.low_m = low_m_,
            .high_m = high_m_,
            .faces = all.first(face_count_),
            .corners = all.subspan(face_count_, corner_count_)};
  }
  /// Those of a centre in a cell, or none if there are too many. The geometry must not change
  /// until the next time.
  void settle(const NearFeatures& near, const NearFeatures::Cell& cell, const Four& centre_m);

 private:
  static constexpr std::size_t k_most = 24;
  // At first it holds nothing.
  Four low_m_ = Four::all(1);
  Four high_m_ = Four::all(-1);
  std::uint32_t face_count_ = 0;
  std::uint32_t corner_count_ = 0;
  std::array<FeatureId, k_most> features_{};
};

/// Half of the box's sides, as a part of the radius. Speed only.
inline constexpr double k_settled_radii = 0.25;

}  // namespace sleight::physics
