// What a feature of a scene looks like, as triangles with materials.
//
// Of bodies the triangles are in the body's frame, of all else in the scene's; both with y up
// (axes.h). Spheres have 192 triangles and smooth normals; pips are discs a hundredth of a die's
// half side above its faces; a surface has sixteen squares to a patch. Goals lie a fifth of a
// millimetre above the table, so that renderers show one of the two; a ring follows the surface
// below it.
//
// Pure functions.
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

/// Triangles of one material.
struct Primitive {
  Material material{};
  std::vector<Float3> places{};
  std::vector<Float3> normals{};
  std::vector<std::uint32_t> corners{};  ///< three to a triangle, counter-clockwise from outside
  friend bool operator==(const Primitive&, const Primitive&) = default;
};

/// No primitive is empty; none at all where there is nothing to see.
using Look = std::vector<Primitive>;

/// In one animation. REQUIRES: a sound scene (scene::fault_of), a sound variation.
Look look_of(const scene::Scene& scene, std::uint32_t feature, const scene::Variation& own,
             std::span<const math::Vec3> offsets_m);

}  // namespace sleight::gltf
