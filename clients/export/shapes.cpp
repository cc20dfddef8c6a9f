#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "clients/export/triangles.h"
#include "common/math/elementary.h"

namespace sleight::gltf {
namespace {

using math::Vec3;

// A sphere: 12 by 9 pieces are 192 triangles.
constexpr std::uint32_t k_round = 12;
constexpr std::uint32_t k_bands = 9;
constexpr std::uint32_t k_disc_corners = 36;

constexpr std::uint32_t k_pip_corners = 12;
constexpr double k_pip_radius = 0.19;  ///< in halves of a side, as are the next two
constexpr double k_pip_off = 0.5;      ///< of a pip beside the middle
constexpr double k_pip_above = 0.01;

constexpr std::int32_t k_squares = 4;  ///< of a patch, on either side
/// Larger surfaces than any table has have a square to a patch.
constexpr std::size_t k_fine_patches_max = 20'000;

/// Closer control points are none of a table, and its slopes no numbers.
constexpr double k_spacing_m_min = 1e-9;

/// The height of a patch, and how steep it is, from its sixteen control points.
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

/// The slopes of scene::spline_weights; they add up to 0.
std::array<double, 4> weight_slopes(double u) {
  const double v = 1 - u;
  return {-v * v / 2, (3 * u * u - 4 * u) / 2, -(3 * v * v - 4 * v) / 2, u * u / 2};
}

struct FaceFrame {
  Vec3 normal = Vec3::Zero();
  Vec3 u = Vec3::Zero();
  Vec3 v = Vec3::Zero();
};

/// Right-handed: u turned to v is seen counter-clockwise from outside.
FaceFrame face_frame(Eigen::Index axis, double side) {
  FaceFrame frame;
  frame.normal[axis] = side;
  frame.u[(axis + 1) % 3] = side;
  frame.v[(axis + 2) % 3] = 1;
  return frame;
}

/// Half the box along each of a face's directions.
Vec3 scaled(const Vec3& direction, const Vec3& half_m) {
  return direction.cwiseProduct(half_m);
}

struct Off {
  double u;
  double v;
};

/// The middle if the number is odd, then pairs opposite each other.
std::vector<Off> pip_places(std::uint32_t number) {
  constexpr double k = k_pip_off;
  constexpr std::array<Off, 6> k_pairs{{{-k, -k}, {k, k}, {-k, k}, {k, -k}, {-k, 0}, {k, 0}}};
  std::vector<Off> places;
  if (number % 2 == 1) places.push_back({0, 0});
  for (const Off& off : std::span(k_pairs).first(number - number % 2))
    places.push_back(off);
  return places;
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

void Triangles::polygon(std::span<const Vec3> corners_m) {
  Vec3 area{0, 0, 0};
  for (std::size_t i = 1; i + 1 < corners_m.size(); ++i)
    area += math::cross(Vec3(corners_m[i] - corners_m[0]), Vec3(corners_m[i + 1] - corners_m[0]));
  const double size = math::norm(area);
  if (!(size > 0 && std::isfinite(size))) return;
  std::vector<std::uint32_t> numbers;
  for (const Vec3& corner : corners_m)
    numbers.push_back(vertex(corner, area));
  for (std::size_t i = 1; i + 1 < numbers.size(); ++i)
    triangle(numbers[0], numbers[i], numbers[i + 1]);
}

void add_sphere(Triangles& to, const Frame& frame, double diameter_m) {
  if (!(diameter_m > 0)) return;
  const auto at = [&](double z, double across, const math::SinCos& round) {
    const Vec3 normal(across * round.cos, across * round.sin, z);
    return to.vertex(frame.at(0.5 * diameter_m * normal), math::rotated(frame.turn, normal));
  };
  const std::uint32_t top = at(1, 0, {});
  std::uint32_t ring = top;  ///< the first of the ring above
  for (std::uint32_t band = 1; band < k_bands; ++band) {
    const math::SinCos down = math::sincos(M_PI * band / k_bands);
    const std::uint32_t above = ring;
    ring = static_cast<std::uint32_t>(to.primitive.places.size());
    for (std::uint32_t i = 0; i < k_round; ++i)
      at(down.cos, down.sin, math::sincos(2 * M_PI * i / k_round));
    for (std::uint32_t i = 0; i < k_round; ++i) {
      const std::uint32_t next = (i + 1) % k_round;
      to.triangle(ring + i, ring + next, band == 1 ? top : above + i);
      if (band > 1) to.triangle(ring + next, above + next, above + i);
    }
  }
  const std::uint32_t bottom = at(-1, 0, {});
  for (std::uint32_t i = 0; i < k_round; ++i)
    to.triangle(bottom, ring + (i + 1) % k_round, ring + i);
}

void add_box(Triangles& to, const Frame& frame, const Vec3& sides_m) {
  const Vec3 half_m = 0.5 * sides_m;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      // A flat box has one face alone.
      if (side < 0 && half_m[axis] == 0) continue;
      const FaceFrame face = face_frame(axis, side);
      const Vec3 middle_m = scaled(face.normal, half_m);
      const Vec3 u = scaled(face.u, half_m);
      const Vec3 v = scaled(face.v, half_m);
      to.polygon(std::array<Vec3, 4>{frame.at(middle_m - u - v), frame.at(middle_m + u - v),
                                     frame.at(middle_m + u + v), frame.at(middle_m - u + v)});
    }
  }
}

void add_pips(Triangles& to, const Frame& frame, const Vec3& sides_m) {
  const Vec3 half_m = 0.5 * sides_m;
  for (std::uint32_t number = 1; number <= 6; ++number) {
    const bool is_low = number <= 3;
    const FaceFrame face = face_frame(is_low ? number - 1 : 6 - number, is_low ? 1 : -1);
    for (const Off& pip : pip_places(number)) {
      std::array<Vec3, k_pip_corners> corners;
      for (std::uint32_t i = 0; i < k_pip_corners; ++i) {
        const math::SinCos round = math::sincos(2 * M_PI * i / k_pip_corners);
        const Vec3 off = (1 + k_pip_above) * face.normal +
                         (pip.u + k_pip_radius * round.cos) * face.u +
                         (pip.v + k_pip_radius * round.sin) * face.v;
        corners[i] = frame.at(scaled(off, half_m));
      }
      to.polygon(corners);
    }
  }
}

void add_disc(Triangles& to, const Frame& frame, double diameter_m) {
  std::array<Vec3, k_disc_corners> corners;
  for (std::uint32_t i = 0; i < k_disc_corners; ++i) {
    const math::SinCos round = math::sincos(2 * M_PI * i / k_disc_corners);
    corners[i] = frame.at(0.5 * diameter_m * Vec3(round.cos, round.sin, 0));
  }
  to.polygon(corners);
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
