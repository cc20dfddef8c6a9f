#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "clients/export/triangles.h"

namespace sleight::gltf {
namespace {

using math::Vec3;

constexpr std::int32_t k_squares = 4;  ///< squares per side of a patch
/// Surfaces with more patches than this (no table is so large) have one square per patch.
constexpr std::size_t k_fine_patches_max = 20'000;

/// Minimum spacing of control points; closer points give invalid slopes.
constexpr double k_spacing_m_min = 1e-9;

/// Height and slopes of a patch, from its sixteen control points.
class PatchHeights {
 public:
  PatchHeights(std::span<const scene::ControlPoint> points, const scene::Surface::Patch& patch) {
    for (std::int32_t row = 0; row < 4; ++row) {
      for (std::int32_t column = 0; column < 4; ++column) {
        const std::pair key(patch.j - 1 + row, patch.i - 1 + column);
        const auto found = std::lower_bound(
            points.begin(), points.end(), key,
            [](const auto& point, const auto& k) { return std::pair(point.j, point.i) < k; });
        heights_m_[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
            found->height_m;
      }
    }
  }

  double sum(const std::array<double, 4>& along_x, const std::array<double, 4>& along_y) const {
    double sum = 0;
    for (std::size_t row = 0; row < 4; ++row) {
      for (std::size_t column = 0; column < 4; ++column)
        sum += along_x[column] * along_y[row] * heights_m_[row][column];
    }
    return sum;
  }

 private:
  std::array<std::array<double, 4>, 4> heights_m_{};
};

/// Derivatives of scene::spline_weights; they add up to 0.
std::array<double, 4> weight_slopes(double u) {
  const double v = 1 - u;
  return {-v * v / 2, (3 * u * u - 4 * u) / 2, -(3 * v * v - 4 * v) / 2, u * u / 2};
}

}  // namespace

std::uint32_t Triangles::vertex(const Vec3& place_m, const Vec3& normal) {
  primitive.places.push_back(y_up(place_m));
  primitive.normals.push_back(y_up(math::normalized(normal)));
  return static_cast<std::uint32_t>(primitive.places.size() - 1);
}

void Triangles::triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  primitive.corners.insert(primitive.corners.end(), {a, b, c});
}

void Triangles::fan(std::span<const std::uint32_t> numbers) {
  for (std::size_t i = 1; i + 1 < numbers.size(); ++i)
    triangle(numbers[0], numbers[i], numbers[i + 1]);
}

namespace {

/// Returns a vector along the normal, or nothing if the polygon has no area.
std::optional<Vec3> area_of(std::span<const Vec3> corners_m) {
  Vec3 area{0, 0, 0};
  for (std::size_t i = 1; i + 1 < corners_m.size(); ++i)
    area += math::cross(Vec3(corners_m[i] - corners_m[0]), Vec3(corners_m[i + 1] - corners_m[0]));
  const double size = math::norm(area);
  return size > 0 && std::isfinite(size) ? std::optional(area) : std::nullopt;
}

}  // namespace

void Triangles::polygon(std::span<const Vec3> corners_m) {
  const std::optional<Vec3> area = area_of(corners_m);
  if (!area) return;
  std::vector<std::uint32_t> numbers;
  for (const Vec3& corner : corners_m)
    numbers.push_back(vertex(corner, *area));
  fan(numbers);
}

void Triangles::curved(std::span<const Vec3> corners_m, std::span<const Vec3> normals) {
  if (!area_of(corners_m)) return;
  std::vector<std::uint32_t> numbers;
  for (std::size_t i = 0; i < corners_m.size(); ++i) {
    const auto [x, y, z] = y_up(corners_m[i]);
    const auto [nx, ny, nz] = y_up(normals[i]);
    const auto [found, is_new] = shared_.try_emplace({x, y, z, nx, ny, nz}, 0);
    if (is_new) found->second = vertex(corners_m[i], normals[i]);
    numbers.push_back(found->second);
  }
  fan(numbers);
}

void add_facet(Triangles& to, const Frame& frame, const shapes::Facet& facet) {
  std::vector<Vec3> corners_m;
  for (const Vec3& corner : facet.corners_m)
    corners_m.push_back(frame.at(corner));
  if (facet.normals.empty()) {
    to.polygon(corners_m);
    return;
  }
  std::vector<Vec3> normals;
  for (const Vec3& normal : facet.normals)
    normals.push_back(math::rotated(frame.turn, normal));
  to.curved(corners_m, normals);
}

void add_surface(Triangles& to, std::span<const scene::ControlPoint> points, double spacing_m) {
  if (!(spacing_m >= k_spacing_m_min)) return;
  const scene::Surface surface(points, spacing_m);
  const std::int32_t squares = surface.patches().size() <= k_fine_patches_max ? k_squares : 1;
  for (const scene::Surface::Patch& patch : surface.patches()) {
    const PatchHeights heights(points, patch);
    const auto first = static_cast<std::uint32_t>(to.primitive.places.size());
    for (std::int32_t row = 0; row <= squares; ++row) {
      for (std::int32_t column = 0; column <= squares; ++column) {
        const double u = static_cast<double>(column) / squares;
        const double v = static_cast<double>(row) / squares;
        const auto along_x = scene::spline_weights(u);
        const auto along_y = scene::spline_weights(v);
        const Vec3 normal(-heights.sum(weight_slopes(u), along_y) / spacing_m,
                          -heights.sum(along_x, weight_slopes(v)) / spacing_m, 1);
        to.vertex(
            {(patch.i + u) * spacing_m, (patch.j + v) * spacing_m, heights.sum(along_x, along_y)},
            normal);
      }
    }
    const auto width = static_cast<std::uint32_t>(squares + 1);
    for (std::uint32_t row = 0; row + 1 < width; ++row) {
      for (std::uint32_t column = 0; column + 1 < width; ++column) {
        const std::uint32_t corner = first + row * width + column;
        to.triangle(corner, corner + 1, corner + width + 1);
        to.triangle(corner, corner + width + 1, corner + width);
      }
    }
  }
}

void add_ribbon(Triangles& to, std::span<const Vec3> line_m, double width_m,
                const scene::Surface* surface) {
  const auto raised = [&](Vec3 place_m) {
    if (surface != nullptr) {
      const auto height_m = surface->height_m(place_m.x(), place_m.y());
      if (height_m && *height_m > place_m.z()) place_m.z() = *height_m;
    }
    place_m.z() += k_lift_m;
    return place_m;
  };
  const std::size_t count = line_m.size();
  std::vector<Vec3> inner_m(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 along = line_m[(i + 1) % count] - line_m[(i + count - 1) % count];
    const double length = math::norm(along);
    if (!(length > 0)) return;
    inner_m[i] = line_m[i] + (width_m / length) * Vec3(-along.y(), along.x(), 0);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t next = (i + 1) % count;
    to.polygon(std::array<Vec3, 4>{raised(line_m[i]), raised(line_m[next]), raised(inner_m[next]),
                                   raised(inner_m[i])});
  }
}

}  // namespace sleight::gltf
