// Converts a scene feature to triangles with materials.
//
// Triangles of a body are in the body's frame, other triangles in the scene's frame, both with y up
// (axes.h). Spheres have 192 triangles and smooth normals. Pips are discs above a die's faces, at a
// hundredth of its half side. A surface has sixteen squares per patch. Goals are 0.2 mm above the
// table, so that renderers show only one of the two; a ring follows the surface below it. Pure
// functions.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "clients/export/axes.h"
#include "clients/plot/figure.h"
#include "common/scene/scene.h"

namespace sleight::gltf {

struct Material {
  std::string name{};
  plot::Color color{};
  bool is_double_sided = false;
  friend bool operator==(const Material&, const Material&) = default;
};

struct Primitive {
  Material material{};
  std::vector<Float3> places{};
  std::vector<Float3> normals{};
  std::vector<std::uint32_t> corners{};  ///< three per triangle, counter-clockwise from outside
  friend bool operator==(const Primitive&, const Primitive&) = default;
};

/// No primitive is empty. Invisible features have none.
using Look = std::vector<Primitive>;

/// Returns the look in one animation. REQUIRES: a valid scene description (scene::fault_of) and
/// variation.
Look look_of(const scene::Scene& scene, std::uint32_t feature, const scene::Variation& own,
             std::span<const math::Vec3> offsets_m);

}  // namespace sleight::gltf
