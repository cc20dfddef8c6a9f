#include "clients/export/look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "clients/plot/scene_colors.h"
#include "clients/plot/text.h"
#include "clients/shapes/facets.h"
#include "common/math/elementary.h"
#include "common/scene/surface.h"

namespace sleight::gltf {
namespace {

using math::Vec3;

/// Height of goals above the ground.
constexpr double k_lift_m = 0.2e-3;

/// Maps a part's frame to its feature's frame.
struct Frame {
  Vec3 origin_m{0, 0, 0};
  math::Quat turn = math::Quat::Identity();

  Vec3 at(const Vec3& place_m) const { return origin_m + math::rotated(turn, place_m); }
};

/// Collects the triangles of one material.
class Triangles {
 public:
  explicit Triangles(const Material& material) { primitive.material = material; }

  /// Adds a vertex and returns its number. REQUIRES: the normal isn't zero.
  std::uint32_t vertex(const Vec3& place_m, const Vec3& normal);
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// Adds a flat polygon, counter-clockwise from outside, unless it has no area.
  void polygon(std::span<const Vec3> corners_m);
  /// Adds a piece of a curved surface; neighbours share vertices.
  void curved(std::span<const Vec3> corners_m, std::span<const Vec3> normals);

  Primitive primitive{};

 private:
  void fan(std::span<const std::uint32_t> numbers);

  std::map<std::array<float, 6>, std::uint32_t> shared_{};  ///< vertices by place and normal
};

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

/// Returns a vector along the normal, or nothing if the polygon has no area.
std::optional<Vec3> area_of(std::span<const Vec3> corners_m) {
  Vec3 area{0, 0, 0};
  for (std::size_t i = 1; i + 1 < corners_m.size(); ++i)
    area += math::cross(Vec3(corners_m[i] - corners_m[0]), Vec3(corners_m[i + 1] - corners_m[0]));
  const double size = math::norm(area);
  return size > 0 && std::isfinite(size) ? std::optional(area) : std::nullopt;
}

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

/// Adds a closed ribbon to the left of a line that runs counter-clockwise as seen from above.
/// Places below the surface are raised to it.
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

namespace colors = plot::scene_colors;
using scene::FeatureKind;
using scene::Shape;

constexpr double k_ribbon = 0.06;  ///< width relative to the diameter or the shorter side
constexpr std::uint32_t k_ring_corners = 36;
constexpr std::uint32_t k_side_pieces = 8;  ///< per side of a rectangle's ribbon
constexpr double k_tint_opacity = 0.5;
constexpr double k_ground_reach = 0.4;  ///< of the shorter side, below a flat goal

Frame frame_of(const scene::Part& part) {
  return {.origin_m = part.position_m, .turn = math::normalized(part.orientation)};
}

class Maker {
 public:
  Maker(const scene::Scene& scene, std::uint32_t number, const scene::Variation& own,
        std::span<const Vec3> offsets_m)
      : scene_(scene),
        number_(number),
        feature_(scene.features[number]),
        own_(own),
        offsets_m_(offsets_m) {}

  void add(const scene::Part& part) {
    if (feature_.kind == FeatureKind::wanted) {
      add_wanted(part);
      return;
    }
    const Frame frame = frame_of(part);
    if (part.shape == Shape::surface) {
      add_surface(of(table()), own_.points, part.size_m.z());
      return;
    }
    scene::Part shown = part;
    if (part.shape == Shape::ground) {
      shown.shape = Shape::box;
      shown.size_m.z() = 0;
    }
    for (const shapes::Facet& facet : shapes::facets_of(scene_, shown, offsets_m_))
      add_facet(of(material_of(part, facet)), frame, facet);
  }

  Look take() {
    Look look;
    for (Triangles& triangles : found_) {
      if (!triangles.primitive.corners.empty()) look.push_back(std::move(triangles.primitive));
    }
    return look;
  }

 private:
  Triangles& of(const Material& material) {
    const auto found = std::ranges::find_if(
        found_, [&](const Triangles& one) { return one.primitive.material == material; });
    return found != found_.end() ? *found : found_.emplace_back(material);
  }

  Material solid() const {
    if (feature_.kind == FeatureKind::body)
      return {.name = plot::printable(feature_.name),
              .color = colors::of_body(number_, scene_.bodies())};
    return {.name = "fixed", .color = colors::k_fixed};
  }
  Material sheet() const {
    Material material = solid();
    material.is_double_sided = true;
    return material;
  }
  static Material table() {
    return {.name = "table", .color = colors::k_table, .is_double_sided = true};
  }

  Material material_of(const scene::Part& part, const shapes::Facet& facet) const {
    if (facet.is_pip) return {.name = "ink", .color = plot::palette::k_ink};
    switch (part.shape) {
      case Shape::die:
        return {.name = "ivory", .color = colors::k_ivory};
      case Shape::disc:
      case Shape::mesh:
        return sheet();
      case Shape::ground:
      case Shape::surface:
        return table();
      case Shape::sphere:
      case Shape::box:
        return solid();
    }
    return solid();
  }

  /// Adds a goal: a tinted area for any body, a ring for a single body. A disc is always a ring.
  void add_wanted(const scene::Part& part) {
    const bool is_flat = part.size_m.z() == 0;
    const bool is_of_one = feature_.body != scene::k_none;
    if (part.shape == Shape::disc || (part.shape == Shape::box && is_flat && is_of_one)) {
      add_ring(part);
      return;
    }
    Frame frame = frame_of(part);
    if (is_flat) frame.origin_m = frame.at({0, 0, ground_above_m(part, frame) + k_lift_m});
    Triangles& to = of({.name = "wanted",
                        .color = colors::k_tint.with_opacity(k_tint_opacity),
                        .is_double_sided = true});
    for (const shapes::Facet& facet : shapes::facets_of(scene_, part, offsets_m_)) {
      if (!facet.is_pip) add_facet(to, frame, facet);
    }
  }

  /// Returns the height of fixed vertices above the middle of a flat goal. Ignores vertices near
  /// the goal's rim, which belong to walls, and vertices far above the goal, which belong to
  /// hanging things.
  double ground_above_m(const scene::Part& part, const Frame& frame) const {
    const double reach_m = k_ground_reach * std::min(part.size_m.x(), part.size_m.y());
    double highest_m = 0;
    for (const scene::Part& other : scene_.parts) {
      if (other.shape != Shape::mesh || scene_.features[other.feature].kind != FeatureKind::fixed)
        continue;
      const Frame from = frame_of(other);
      for (const auto& triangle :
           std::span(scene_.triangles).subspan(other.first_triangle, other.triangles)) {
        for (const std::uint32_t vertex : triangle) {
          const Vec3 place_m = math::rotated(
              math::inverse(frame.turn),
              from.at(shapes::place_of(scene_.vertices[vertex], offsets_m_)) - frame.origin_m);
          if (std::abs(place_m.x()) < reach_m && std::abs(place_m.y()) < reach_m &&
              place_m.z() < reach_m)
            highest_m = std::max(highest_m, place_m.z());
        }
      }
    }
    return highest_m;
  }

  void add_ring(const scene::Part& part) {
    const Frame frame = frame_of(part);
    std::vector<Vec3> line_m;
    double width_m = k_ribbon * part.size_m.x();
    if (part.shape == Shape::disc) {
      for (std::uint32_t i = 0; i < k_ring_corners; ++i) {
        const math::SinCos round = math::sincos(2 * M_PI * i / k_ring_corners);
        line_m.push_back(frame.at(0.5 * part.size_m.x() * Vec3(round.cos, round.sin, 0)));
      }
    } else {
      width_m = k_ribbon * std::min(part.size_m.x(), part.size_m.y());
      constexpr std::array<std::array<double, 2>, 4> k_corners{
          {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}};
      for (std::size_t side = 0; side < k_corners.size(); ++side) {
        const auto& a = k_corners[side];
        const auto& b = k_corners[(side + 1) % k_corners.size()];
        for (std::uint32_t i = 0; i < k_side_pieces; ++i) {
          const double share = static_cast<double>(i) / k_side_pieces;
          line_m.push_back(frame.at(Vec3((a[0] + share * (b[0] - a[0])) * part.size_m.x(),
                                         (a[1] + share * (b[1] - a[1])) * part.size_m.y(), 0)));
        }
      }
    }
    add_ribbon(of({.name = "goal", .color = colors::k_ring, .is_double_sided = true}), line_m,
               width_m, surface());
  }

  /// Returns the animation's surface, if it has one.
  const scene::Surface* surface() {
    if (surface_ || own_.points.empty()) return surface_ ? &*surface_ : nullptr;
    const auto part = std::ranges::find_if(
        scene_.parts, [](const scene::Part& one) { return one.shape == Shape::surface; });
    if (part == scene_.parts.end() || !(part->size_m.z() > 0)) return nullptr;
    surface_.emplace(own_.points, part->size_m.z());
    return &*surface_;
  }

  const scene::Scene& scene_;
  std::uint32_t number_;
  const scene::Feature& feature_;
  const scene::Variation& own_;
  std::span<const Vec3> offsets_m_;
  std::vector<Triangles> found_{};
  std::optional<scene::Surface> surface_{};
};

}  // namespace

Look look_of(const scene::Scene& scene, std::uint32_t feature, const scene::Variation& own,
             std::span<const Vec3> offsets_m) {
  Maker maker(scene, feature, own, offsets_m);
  for (const std::vector<scene::Part>* parts : {&scene.parts, &own.parts}) {
    for (const scene::Part& part :
         std::ranges::equal_range(*parts, feature, {}, &scene::Part::feature))
      maker.add(part);
  }
  return maker.take();
}

}  // namespace sleight::gltf
