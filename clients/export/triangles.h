// Collects the triangles of a look, material by material. Private to look.cpp and shapes.cpp.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clients/export/look.h"
#include "common/scene/surface.h"

namespace sleight::gltf {

/// Of goals above what they lie on.
inline constexpr double k_lift_m = 0.2e-3;

/// From a part's frame to its feature's.
struct Frame {
  math::Vec3 origin_m{0, 0, 0};
  math::Quat turn = math::Quat::Identity();

  math::Vec3 at(const math::Vec3& place_m) const { return origin_m + math::rotated(turn, place_m); }
};

class Triangles {
 public:
  explicit Triangles(const Material& material) { primitive.material = material; }

  /// Returns its number. REQUIRES: the normal isn't zero.
  std::uint32_t vertex(const math::Vec3& place_m, const math::Vec3& normal);
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// A flat polygon, counter-clockwise seen from outside; nothing where it has no area.
  void polygon(std::span<const math::Vec3> corners_m);

  Primitive primitive{};
};

void add_sphere(Triangles& to, const Frame& frame, double diameter_m);
void add_box(Triangles& to, const Frame& frame, const math::Vec3& sides_m);
/// The pips alone.
void add_pips(Triangles& to, const Frame& frame, const math::Vec3& sides_m);
/// About z of the frame.
void add_disc(Triangles& to, const Frame& frame, double diameter_m);
/// Its patches.
void add_surface(Triangles& to, std::span<const scene::ControlPoint> points, double spacing_m);
/// A closed ribbon beside a line, to its left, which runs counter-clockwise seen from above. Each
/// place is raised to the surface, where there is one above it.
void add_ribbon(Triangles& to, std::span<const math::Vec3> line_m, double width_m,
                const scene::Surface* surface);

}  // namespace sleight::gltf
