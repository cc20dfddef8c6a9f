#include "clients/export/look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "clients/export/triangles.h"
#include "clients/plot/scene_colors.h"
#include "clients/plot/text.h"
#include "common/math/elementary.h"

namespace sleight::gltf {
namespace {

namespace colors = plot::scene_colors;
using math::Vec3;
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
