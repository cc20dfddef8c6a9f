#include "worker/physics/marbles/near_features.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/physics/event/tolerances.h"

namespace sleight::physics {
namespace {

constexpr float k_infinity = std::numeric_limits<float>::infinity();
/// Size and margin of a cell, as shares of a ball's radius. A smaller cell has a shorter list. With
/// a wider margin, a path stays longer in one cell. Both affect only speed.
constexpr double k_cell_radii = 0.7;
constexpr double k_margin_radii = 0.2;
/// Where a touch box leaves its home, the home grows by this much more than necessary, as a share
/// of the radius.
constexpr double k_growth_radii = 0.15;
/// Maximum number of cells. If there would be more, cells are made larger.
constexpr double k_cells_max = 1 << 16;

constexpr TouchBox k_everywhere{.low_m = {-k_infinity, -k_infinity, -k_infinity, 0},
                                .high_m = {k_infinity, k_infinity, k_infinity, 0}};
float padded_below(double x, double pad) {
  return static_cast<float>(x - (pad + std::fabs(x) * 0x1p-20));
}
float padded_above(double x, double pad) {
  return static_cast<float>(x + (pad + std::fabs(x) * 0x1p-20));
}

}  // namespace

TouchBox NearFeatures::touch_box_of_plane(FeatureId index) const {
  const SphereFeature& plane = statics_.feature(index);
  const double reach_m = radius_m_ + 2 * k_touch_m;
  TouchBox box = k_everywhere;
  for (std::size_t i = 0; i < 3; ++i) {
    // A plane has no sides, so centres may be anywhere below it.
    const double slope = plane.direction[static_cast<int>(i)];
    const double place_m = plane.point_m[static_cast<int>(i)];
    if (slope == 1) box.high_m[i] = padded_above(place_m + reach_m, k_touch_box_pad_m);
    if (slope == -1) box.low_m[i] = padded_below(place_m - reach_m, k_touch_box_pad_m);
  }
  return box;
}

/// The features' own boxes have slack, so they rarely change.
void NearFeatures::measure_features() {
  boxes_made_ = statics_.boxes_made();
  for (FeatureId f{statics_.plane_count()}; f < statics_.feature_count(); ++f)
    extents_[f] = extent_of(statics_.feature_box(f), reach_m());
}

NearFeatures::Range NearFeatures::cells_of(const TouchBox& box) const {
  Range range;
  if (!(box.low_m[0] <= box.high_m[0])) return range;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto place = [&](double x) {
      return static_cast<std::uint32_t>(
          std::clamp(std::floor((x - origin_m_[i]) / cell_m_), 0.0, counts_[i] - 1.0));
    };
    // Use slightly more than the margin, because rounding decides which cell contains a centre.
    range.from[i] = place(double{box.low_m[i]} - 1.01 * margin_m_);
    range.to[i] = place(double{box.high_m[i]} + 1.01 * margin_m_) + 1;
  }
  return range;
}

/// Calls visit(list) for the cells of a range that are not in `without`.
template <class Visit>
void NearFeatures::for_each_cell(const Range& range, const Range& without,
                                 const Visit& visit) const {
  for (std::uint32_t z = range.from[2]; z < range.to[2]; ++z) {
    for (std::uint32_t y = range.from[1]; y < range.to[1]; ++y) {
      for (std::uint32_t x = range.from[0]; x < range.to[0]; ++x) {
        if (!without.holds(x, y, z)) visit(list_of(x, y, z));
      }
    }
  }
}

/// Enlarges a feature's home to contain its touch box.
void NearFeatures::enlarge_home(FeatureId feature) {
  const TouchBox& box = touch_boxes_[feature];
  TouchBox& home = homes_[feature];
  const double growth_m = k_growth_radii * radius_m_;
  for (std::size_t i = 0; i < 3; ++i) {
    if (box.low_m[i] < home.low_m[i]) home.low_m[i] = padded_below(box.low_m[i], growth_m);
    if (box.high_m[i] > home.high_m[i]) home.high_m[i] = padded_above(box.high_m[i], growth_m);
  }
  double size_m = 0;
  for (std::size_t i = 0; i < 3; ++i)
    size_m += double{std::max(std::fabs(home.low_m[i]), std::fabs(home.high_m[i]))};
  coordinates_m_ = std::max(coordinates_m_, size_m);
}

/// Enlarges a feature's home and adds the feature to the additional lists.
void NearFeatures::grow_home(FeatureId feature) {
  const Range before = cells_of(homes_[feature]);
  enlarge_home(feature);
  const bool is_face = statics_.feature(feature).kind == FeatureKind::face;
  for_each_cell(cells_of(homes_[feature]), before, [&](std::size_t index) {
    std::vector<FeatureId>& list = is_face ? lists_[index].faces : lists_[index].corners;
    list.insert(std::upper_bound(list.begin(), list.end(), feature), feature);
  });
}

NearFeatures::NearFeatures(const StaticGeometry& statics, double radius_m)
    : statics_(statics), radius_m_(radius_m) {
  const std::uint32_t count = statics_.feature_count();
  homes_.assign(count, k_unmeetable);
  touch_boxes_.assign(count, k_unmeetable);
  extents_.resize(count);
  measure_features();
  TouchBox all = k_unmeetable;
  for (FeatureId f{}; f < count; ++f) {
    if (f < statics_.plane_count()) {
      touch_boxes_[f] = touch_box_of_plane(f);
      everywhere_.push_back(f);
      coordinates_m_ = std::max(coordinates_m_, sum(fabs(Four::of(statics_.feature(f).point_m))));
    } else if (!statics_.is_absent(f)) {
      const SphereFeature& feature = statics_.feature(f);
      touch_boxes_[f] = touch_box_of(feature, statics_.sides(feature), extents_[f], reach_m());
    }
    for (std::size_t i = 0; i < 3 && f >= statics_.plane_count(); ++i) {
      all.low_m[i] = std::min(all.low_m[i], touch_boxes_[f].low_m[i]);
      all.high_m[i] = std::max(all.high_m[i], touch_boxes_[f].high_m[i]);
    }
  }
  cell_m_ = k_cell_radii * radius_m_;
  if (all.low_m[0] <= all.high_m[0]) {
    const auto cells = [&](std::size_t i) {
      return std::max(1.0, std::ceil((double{all.high_m[i]} - double{all.low_m[i]}) / cell_m_));
    };
    while (cells(0) * cells(1) * cells(2) > k_cells_max)
      cell_m_ *= 1.25;
    for (std::size_t i = 0; i < 3; ++i) {
      origin_m_[i] = double{all.low_m[i]};
      counts_[i] = static_cast<std::uint32_t>(cells(i));
    }
  }
  cells_per_m_ = 1 / cell_m_;
  margin_m_ = k_margin_radii / k_cell_radii * cell_m_;
  for (std::size_t i = 0; i < 3; ++i)
    last_cell_[i] = counts_[i] - 1.0;
  strides_ = {1, 1.0 * counts_[0], 1.0 * counts_[0] * counts_[1], 0};
  lists_.resize(std::size_t{counts_[0]} * counts_[1] * counts_[2]);
  std::vector<std::uint32_t> lengths(2 * lists_.size());
  const auto is_corner = [&](FeatureId f) {
    return statics_.feature(f).kind == FeatureKind::face ? 0U : 1U;
  };
  for (FeatureId f{statics_.plane_count()}; f < count; ++f) {
    if (statics_.is_absent(f)) continue;
    enlarge_home(f);
    for_each_cell(cells_of(homes_[f]), {},
                  [&](std::size_t list) { ++lengths[2 * list + is_corner(f)]; });
  }
  for (std::size_t list = 0; list < lists_.size(); ++list) {
    lists_[list].faces.reserve(lengths[2 * list]);
    // Reserve more room, because flat edges are added later if they become convex.
    lists_[list].corners.reserve(lengths[2 * list + 1] + (lengths[2 * list + 1] + 1) / 2);
  }
  for (FeatureId f{statics_.plane_count()}; f < count; ++f) {
    if (statics_.is_absent(f)) continue;
    for_each_cell(cells_of(homes_[f]), {}, [&](std::size_t list) {
      (is_corner(f) != 0 ? lists_[list].corners : lists_[list].faces).push_back(f);
    });
  }
}

void NearFeatures::refresh() {
  if (boxes_made_ != statics_.boxes_made()) measure_features();
  outgrown_.clear();
  write_touch_boxes(statics_, statics_.refreshed(), reach_m(),
                    {.extents = extents_, .homes = homes_, .boxes = touch_boxes_}, outgrown_);
  for (const FeatureId f : outgrown_)
    grow_home(f);
}

}  // namespace sleight::physics
