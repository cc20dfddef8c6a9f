#include "worker/physics/marbles/surroundings.h"

#include "worker/physics/scene/static_geometry.h"

namespace sleight::physics {
void Surroundings::settle(const NearFeatures& near, const NearFeatures::Cell& cell,
                          const Four& centre_m) {
  const double half_m = k_settled_radii * near.radius_m();
  // The fourth number of a position is 0, so a wall at 1 never matters.
  const Four half = Four::of(std::array<double, 4>{half_m, half_m, half_m, 1});
  low_m_ = max(cell.low_m, centre_m - half);
  high_m_ = min(cell.high_m, centre_m + half);
  // Conversion to float changes a number by at most 2^-24 of its value.
  const double pad_m = k_place_pad_m + 0x1p-20 * (sum(fabs(centre_m)) + near.radius_m());
  const Four axes = Four::axes(1);
  const TouchBox centres{.low_m = floats_of(axes * (low_m_ - Four::all(pad_m))),
                         .high_m = floats_of(axes * (high_m_ + Four::all(pad_m)))};
  // Box of the whole ball.
  Box balls;
  const auto reach_m = static_cast<float>(near.radius_m() + pad_m);
  for (std::size_t i = 0; i < 3; ++i) {
    balls.low_m[i] = centres.low_m[i] - reach_m;
    balls.high_m[i] = centres.high_m[i] + reach_m;
  }
  const CentreRange range(balls, near.radius_m());
  std::size_t count = 0;
  bool fits = true;
  const auto take = [&](std::span<const FeatureId> features) {
    for (const FeatureId feature : features) {
      if (!overlaps(centres, near.touch_boxes()[feature]) ||
          !near.statics().may_meet(feature, range))
        continue;
      fits = fits && count < k_most;
      if (fits) features_[count++] = feature;
    }
  };
  take(cell.faces);
  face_count_ = static_cast<std::uint32_t>(count);
  take(cell.corners);
  corner_count_ = static_cast<std::uint32_t>(count) - face_count_;
  if (!fits) *this = {};
}

}  // namespace sleight::physics
