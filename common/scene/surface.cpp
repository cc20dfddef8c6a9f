#include "common/scene/surface.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>

#include "common/base/check.h"

namespace sleight::scene {
namespace {

std::pair<std::int32_t, std::int32_t> key_of(const ControlPoint& point) {
  return {point.j, point.i};
}

/// Maximum patch index. No table is so large.
constexpr double k_index_max = 1e9;

std::optional<std::int32_t> patch_at(double place_m, double spacing_m) {
  const double index = std::floor(place_m / spacing_m);
  if (!(std::abs(index) <= k_index_max)) return std::nullopt;
  return static_cast<std::int32_t>(index);
}

}  // namespace

std::array<double, 4> spline_weights(double u) {
  const double v = 1 - u;
  return {v * v * v / 6, (3 * u * u * u - 6 * u * u + 4) / 6, (3 * v * v * v - 6 * v * v + 4) / 6,
          u * u * u / 6};
}

Surface::Surface(std::span<const ControlPoint> points, double spacing_m)
    : points_(points.begin(), points.end()), spacing_m_(spacing_m) {
  CHECK_GT(spacing_m, 0);
  for (const ControlPoint& point : points_) {
    // Patch (i, j) is whole if all points from (i - 1, j - 1) to (i + 2, j + 2) are present.
    const auto [i, j] = std::pair(point.i, point.j);
    bool is_whole = true;
    for (std::int32_t row = j - 1; is_whole && row <= j + 2; ++row) {
      for (std::int32_t column = i - 1; is_whole && column <= i + 2; ++column)
        is_whole = find(column, row) != nullptr;
    }
    if (is_whole) patches_.push_back({i, j});
  }
}

const ControlPoint* Surface::find(std::int32_t i, std::int32_t j) const {
  const auto found = std::lower_bound(
      points_.begin(), points_.end(), std::pair(j, i),
      [](const ControlPoint& point, const auto& key) { return key_of(point) < key; });
  return found != points_.end() && found->i == i && found->j == j ? &*found : nullptr;
}

std::optional<double> Surface::height_m(double x_m, double y_m) const {
  const auto i = patch_at(x_m, spacing_m_);
  const auto j = patch_at(y_m, spacing_m_);
  if (!i || !j) return std::nullopt;
  const std::array<double, 4> along_x = spline_weights(x_m / spacing_m_ - *i);
  const std::array<double, 4> along_y = spline_weights(y_m / spacing_m_ - *j);
  double height = 0;
  for (std::int32_t row = 0; row < 4; ++row) {
    for (std::int32_t column = 0; column < 4; ++column) {
      const ControlPoint* point = find(*i - 1 + column, *j - 1 + row);
      if (point == nullptr) return std::nullopt;
      height += along_x[static_cast<std::size_t>(column)] * along_y[static_cast<std::size_t>(row)] *
                point->height_m;
    }
  }
  return height;
}

std::vector<std::array<std::int32_t, 2>> indices_about(std::span<const Vec3> places_m,
                                                       double half_m, double spacing_m) {
  std::set<std::pair<std::int32_t, std::int32_t>> all;
  for (const Vec3& place : places_m) {
    const auto left = patch_at(place.x() - half_m, spacing_m);
    const auto right = patch_at(place.x() + half_m, spacing_m);
    const auto front = patch_at(place.y() - half_m, spacing_m);
    const auto back = patch_at(place.y() + half_m, spacing_m);
    if (!left || !right || !front || !back) continue;
    for (std::int32_t j = *front - 1; j <= *back + 2; ++j) {
      for (std::int32_t i = *left - 1; i <= *right + 2; ++i)
        all.emplace(j, i);
    }
  }
  std::vector<std::array<std::int32_t, 2>> indices;
  for (const auto& [j, i] : all)
    indices.push_back({i, j});
  return indices;
}

}  // namespace sleight::scene
