#include "worker/physics/marbles/near_features.h"

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
/// What outgrows its home gets one that is so much larger than need be on each side.
constexpr double k_growth_radii = 0.15;
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

NearFeatures::NearFeatures(const StaticGeometry& statics, double radius_m)
    : statics_(statics), radius_m_(radius_m) {
  const std::uint32_t count = statics_.feature_count();
  homes_.assign(count, k_nowhere);
  TouchBox all = k_nowhere;
  for (std::uint32_t f = 0; f < count; ++f) {
    touch_boxes_.push_back(touch_box_of(f));
    if (f < statics_.plane_count()) everywhere_.push_back(f);
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
  margin_m_ = k_margin_radii / k_cell_radii * cell_m_;
  lists_.resize(std::size_t{counts_[0]} * counts_[1] * counts_[2]);
  for (std::uint32_t f = statics_.plane_count(); f < count; ++f) {
    if (!statics_.is_absent(f)) grow_home(f);
  }
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

NearFeatures::Range NearFeatures::cells_of(const TouchBox& box) const {
  Range range;
  if (!(box.low_m[0] <= box.high_m[0])) return range;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto place = [&](double x) {
      return static_cast<std::uint32_t>(
          std::clamp(std::floor((x - origin_m_[i]) / cell_m_), 0.0, counts_[i] - 1.0));
    };
    // Some more than the margin: which cell a centre is in is a matter of rounding.
    range.from[i] = place(double{box.low_m[i]} - 1.01 * margin_m_);
    range.to[i] = place(double{box.high_m[i]} + 1.01 * margin_m_) + 1;
  }
  return range;
}

/// Makes a feature's home larger, so that it holds its touch box, and puts it in the lists that it
/// wasn't in before.
void NearFeatures::grow_home(std::uint32_t feature) {
  const TouchBox& box = touch_boxes_[feature];
  TouchBox& home = homes_[feature];
  const Range before = cells_of(home);
  const double growth_m = k_growth_radii * radius_m_;
  for (std::size_t i = 0; i < 3; ++i) {
    if (box.low_m[i] < home.low_m[i]) home.low_m[i] = padded_below(box.low_m[i], growth_m);
    if (box.high_m[i] > home.high_m[i]) home.high_m[i] = padded_above(box.high_m[i], growth_m);
  }
  const Range now = cells_of(home);
  const bool is_face = statics_.feature(feature).kind == FeatureKind::face;
  for (std::uint32_t z = now.from[2]; z < now.to[2]; ++z) {
    for (std::uint32_t y = now.from[1]; y < now.to[1]; ++y) {
      for (std::uint32_t x = now.from[0]; x < now.to[0]; ++x) {
        if (before.holds(x, y, z)) continue;
        List& lists = lists_[list_of(x, y, z)];
        std::vector<std::uint32_t>& list = is_face ? lists.faces : lists.corners;
        list.insert(std::upper_bound(list.begin(), list.end(), feature), feature);
      }
    }
  }
}

void NearFeatures::refresh() {
  for (const std::uint32_t f : statics_.refreshed()) {
    touch_boxes_[f] = touch_box_of(f);
    if (!statics_.is_absent(f) && !holds(homes_[f], touch_boxes_[f])) grow_home(f);
  }
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
  const List& lists = lists_[list_of(at[0], at[1], at[2])];
  cell.faces = lists.faces;
  cell.corners = lists.corners;
  return cell;
}

}  // namespace sleight::physics
