// Collects the triangles of a look by material. Private to look.cpp and triangles.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>

#include "clients/export/look.h"
#include "clients/shapes/facets.h"
#include "common/scene/surface.h"

namespace sleight::gltf {

/// Height of goals above the ground.
inline constexpr double k_lift_m = 0.2e-3;

/// Maps a part's frame to its feature's frame.
struct Frame {
  math::Vec3 origin_m{0, 0, 0};
  math::Quat turn = math::Quat::Identity();

  math::Vec3 at(const math::Vec3& place_m) const { return origin_m + math::rotated(turn, place_m); }
};

class Triangles {
 public:
  explicit Triangles(const Material& material) { primitive.material = material; }

  /// Adds a vertex and returns its number. REQUIRES: the normal isn't zero.
  std::uint32_t vertex(const math::Vec3& place_m, const math::Vec3& normal);
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// Adds a flat polygon, counter-clockwise from outside, unless it has no area.
  void polygon(std::span<const math::Vec3> corners_m);
  /// Adds a piece of a curved surface; neighbours share vertices.
  void curved(std::span<const math::Vec3> corners_m, std::span<const math::Vec3> normals);

  Primitive primitive{};

 private:
  void fan(std::span<const std::uint32_t> numbers);

  std::map<std::array<float, 6>, std::uint32_t> shared_{};  ///< vertices by place and normal
};

void add_facet(Triangles& to, const Frame& frame, const shapes::Facet& facet);
void add_surface(Triangles& to, std::span<const scene::ControlPoint> points, double spacing_m);
/// Adds a closed ribbon to the left of a line that runs counter-clockwise as seen from above.
/// Places below the surface are raised to it.
void add_ribbon(Triangles& to, std::span<const math::Vec3> line_m, double width_m,
                const scene::Surface* surface);

}  // namespace sleight::gltf
