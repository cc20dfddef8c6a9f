#include "worker/physics/marbles/near_features.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/physics/event/tolerances.h"

namespace sleight::physics {
namespace {

constexpr float k_infinity = std::numeric_limits<float>::infinity();
/// Cells and the margins about them, as parts of a ball's radius: smaller cells have shorter lists,
/// wider margins let a path stay longer. Speed only.
constexpr double k_cell_radii = 0.5;
constexpr double k_margin_radii = 0.4;
/// Touch boxes may grow by this before they are strays.
constexpr double k_growth_radii = 0.15;
/// When there are more strays than this, lists are made anew.
constexpr std::size_t k_strays_max = 8;
/// More cells than this are made larger.
constexpr double k_cells_max = 1 << 16;
/// Far more than rounding of what collisions are judged by.
constexpr double k_pad_m = 1e-6;

constexpr TouchBox k_everywhere{.low_m = {-k_infinity, -k_infinity, -k_infinity, 0},
                                .high_m = {k_infinity, k_infinity, k_infinity, 0}};
constexpr TouchBox k_nowhere{.low_m = {k_infinity, k_infinity, k_infinity, 0},
                             .high_m = {-k_infinity, -k_infinity, -k_infinity, 0}};

float padded_below(double x, double pad) {
  return static_cast<float>(x - (pad + std::fabs(x) * 0x1p-20));
}
float padded_above(double x, double pad) {
  return static_cast<float>(x + (pad + std::fabs(x) * 0x1p-20));
}

/// Of unit vectors from a feature to a centre in its region: greatest component each way.
struct Spread {
  std::array<double, 3> low{-1, -1, -1};
  std::array<double, 3> high{1, 1, 1};
};

/// From an edge: all at right angles to it, between its two faces if it has two.
Spread spread_of_edge(const SphereFeature& edge, std::span<const RegionSide> sides) {
  // Signs of components are taken for those of what is nearly 0 both ways.
  constexpr double k_nearly = 1e-9;
  Spread spread;
  for (std::size_t i = 0; i < 3; ++i) {
    const double along = edge.direction[static_cast<int>(i)];
    const double amplitude = std::sqrt(std::max(0.0, 1 - along * along));
    spread.low[i] = -amplitude;
    spread.high[i] = amplitude;
  }
  if (sides.size() != 4) return spread;
  // The region ends at rays at right angles to the sides' normals.
  const Vec3& first = sides[2].space.normal;
  const Vec3& second = sides[3].space.normal;
  Vec3 ray_a = math::cross(first, edge.direction);
  if (math::dot(ray_a, second) < 0) ray_a = -ray_a;
  Vec3 ray_b = math::cross(second, edge.direction);
  if (math::dot(ray_b, first) < 0) ray_b = -ray_b;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<int>(i);
    // The way along an axis that is at right angles to the edge lies in the region, or the border
    // goes furthest.
    if (first[axis] < -k_nearly || second[axis] < -k_nearly)
      spread.high[i] = std::max(ray_a[axis], ray_b[axis]);
    if (first[axis] > k_nearly || second[axis] > k_nearly)
      spread.low[i] = std::min(ray_a[axis], ray_b[axis]);
  }
  return spread;
}

/// From a vertex: at an obtuse angle to each of its edges.
Spread spread_of_vertex(std::span<const RegionSide> sides) {
  Spread spread;
  for (const RegionSide& side : sides) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double inwards = side.space.normal[static_cast<int>(i)];
      const double most = std::sqrt(std::max(0.0, 1 - inwards * inwards));
      if (inwards < 0) spread.high[i] = std::min(spread.high[i], most);
      if (inwards > 0) spread.low[i] = std::max(spread.low[i], -most);
    }
  }
  return spread;
}

bool holds(const TouchBox& outer, const TouchBox& inner) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (inner.low_m[i] < outer.low_m[i] || inner.high_m[i] > outer.high_m[i]) return false;
  }
  return true;
}

}  // namespace

bool overlaps(const TouchBox& a, const TouchBox& b) {
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

NearFeatures::NearFeatures(const StaticGeometry& statics, double radius_m)
    : statics_(statics), radius_m_(radius_m) {
  make_lists();
}

TouchBox NearFeatures::touch_box_of(std::uint32_t index) const {
  const SphereFeature& feature = statics_.feature(index);
  const double reach_m = radius_m_ + 2 * k_touch_m;
  if (index < statics_.plane_count()) {
    TouchBox box = k_everywhere;
    for (std::size_t i = 0; i < 3; ++i) {
      // Centres may be anywhere below, too: a plane has no sides.
      const double slope = feature.direction[static_cast<int>(i)];
      const double place_m = feature.point_m[static_cast<int>(i)];
      if (slope == 1) box.high_m[i] = padded_above(place_m + reach_m, k_pad_m);
      if (slope == -1) box.low_m[i] = padded_below(place_m - reach_m, k_pad_m);
    }
    return box;
  }
  if (statics_.is_absent(index)) return k_nowhere;
  Spread spread;
  switch (feature.kind) {
    case FeatureKind::face:
      for (std::size_t i = 0; i < 3; ++i)
        spread.low[i] = spread.high[i] = feature.direction[static_cast<int>(i)];
      break;
    case FeatureKind::edge:
      spread = spread_of_edge(feature, statics_.sides(feature));
      break;
    case FeatureKind::vertex:
      spread = spread_of_vertex(statics_.sides(feature));
      break;
  }
  const Box& own = statics_.feature_box(index);
  TouchBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    box.low_m[i] =
        padded_below(double{own.low_m[i]} + std::min(0.0, reach_m * spread.low[i]), k_pad_m);
    box.high_m[i] =
        padded_above(double{own.high_m[i]} + std::max(0.0, reach_m * spread.high[i]), k_pad_m);
  }
  return box;
}

template <class Visit>
void NearFeatures::for_each_cell(const TouchBox& box, const Visit& visit) const {
  std::array<std::uint32_t, 3> from{};
  std::array<std::uint32_t, 3> to{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto place = [&](double x) {
      return static_cast<std::uint32_t>(
          std::clamp(std::floor((x - origin_m_[i]) / cell_m_), 0.0, counts_[i] - 1.0));
    };
    // Some more than the margin: which cell a centre is in is a matter of rounding.
    from[i] = place(double{box.low_m[i]} - 1.01 * margin_m_);
    to[i] = place(double{box.high_m[i]} + 1.01 * margin_m_);
  }
  for (std::uint32_t z = from[2]; z <= to[2]; ++z) {
    for (std::uint32_t y = from[1]; y <= to[1]; ++y) {
      for (std::uint32_t x = from[0]; x <= to[0]; ++x)
        visit((std::size_t{z} * counts_[1] + y) * counts_[0] + x);
    }
  }
}

void NearFeatures::make_lists() {
  const std::uint32_t count = statics_.feature_count();
  touch_boxes_.resize(count);
  homes_.resize(count, k_nowhere);
  strays_.clear();
  is_stray_.assign(count, 0);
  TouchBox all = k_nowhere;
  for (std::uint32_t f = 0; f < count; ++f) {
    touch_boxes_[f] = touch_box_of(f);
    if (f < statics_.plane_count()) {
      strays_.push_back(f);
      is_stray_[f] = 1;
      continue;
    }
    // What has been met keeps the room that it had: so a few times of this are enough for all that
    // vertices ever do.
    const double growth_m = k_growth_radii * radius_m_;
    const bool outgrown = !statics_.is_absent(f) && !holds(homes_[f], touch_boxes_[f]);
    for (std::size_t i = 0; i < 3 && outgrown; ++i) {
      homes_[f].low_m[i] =
          std::min(homes_[f].low_m[i], padded_below(touch_boxes_[f].low_m[i], growth_m));
      homes_[f].high_m[i] =
          std::max(homes_[f].high_m[i], padded_above(touch_boxes_[f].high_m[i], growth_m));
    }
    for (std::size_t i = 0; i < 3; ++i) {
      all.low_m[i] = std::min(all.low_m[i], homes_[f].low_m[i]);
      all.high_m[i] = std::max(all.high_m[i], homes_[f].high_m[i]);
    }
  }
  cell_m_ = k_cell_radii * radius_m_;
  counts_ = {1, 1, 1};
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
  margin_m_ = k_margin_radii / k_cell_radii * cell_m_;
  // Each list's length, then the lists.
  first_.assign(std::size_t{counts_[0]} * counts_[1] * counts_[2] + 1, 0);
  const auto each = [&](const auto& visit) {
    for (std::uint32_t f = statics_.plane_count(); f < count; ++f) {
      if (homes_[f].low_m[0] <= homes_[f].high_m[0])
        for_each_cell(homes_[f], [&](std::size_t c) { visit(c, f); });
    }
  };
  each([&](std::size_t cell, std::uint32_t) { ++first_[cell + 1]; });
  for (std::size_t c = 1; c < first_.size(); ++c)
    first_[c] += first_[c - 1];
  members_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  each([&](std::size_t cell, std::uint32_t f) { members_[next[cell]++] = f; });
}

void NearFeatures::refresh() {
  for (const std::uint32_t f : statics_.refreshed()) {
    touch_boxes_[f] = touch_box_of(f);
    if (is_stray_[f] != 0 || holds(homes_[f], touch_boxes_[f])) continue;
    if (statics_.is_absent(f)) continue;
    is_stray_[f] = 1;
    strays_.insert(std::upper_bound(strays_.begin(), strays_.end(), f), f);
  }
  if (strays_.size() > statics_.plane_count() + k_strays_max) make_lists();
}

NearFeatures::Cell NearFeatures::cell_at(const Vec3& centre_m) const {
  constexpr double k_far = std::numeric_limits<double>::infinity();
  Cell cell{};
  std::array<std::uint32_t, 3> at{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double place = (centre_m[static_cast<int>(i)] - origin_m_[i]) / cell_m_;
    const double last = counts_[i] - 1.0;
    const double whole = std::floor(place < 0 ? 0 : (place > last ? last : place));
    at[i] = static_cast<std::uint32_t>(whole);
    cell.low_m[i] = at[i] == 0 ? -k_far : origin_m_[i] + whole * cell_m_ - margin_m_;
    cell.high_m[i] =
        at[i] + 1 == counts_[i] ? k_far : origin_m_[i] + (whole + 1) * cell_m_ + margin_m_;
  }
  const std::size_t index = (std::size_t{at[2]} * counts_[1] + at[1]) * counts_[0] + at[0];
  cell.features = std::span(members_).subspan(first_[index], first_[index + 1] - first_[index]);
  return cell;
}

}  // namespace sleight::physics
