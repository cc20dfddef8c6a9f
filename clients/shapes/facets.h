// Converts a part of a scene description to flat polygons. No other code has the shapes' geometry.
//
// clients/pictures projects the polygons, and clients/export makes triangles of them for glTF and
// the gallery. So a new shape of body only needs facets here. Ground and surfaces have no facets,
// because bodies never have these shapes.
//
// Polygons are in the part's frame, with z up, in metres. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "common/scene/scene.h"

namespace sleight::shapes {

struct Facet {
  std::vector<math::Vec3> corners_m{};  ///< counter-clockwise seen from outside
  /// Unit normals at the corners of a piece of a curved surface. Empty: flat.
  std::vector<math::Vec3> normals{};
  std::uint32_t face = 0;  ///< 1 to 6: a die's face and its pips; 0: others
  bool is_pip = false;     ///< lies above its face by a hundredth of half a side
  bool is_seen_from_behind = false;
};

/// Returns the facets of a part. A sphere's facets amount to 192 triangles. A die's face comes
/// before its pips. `offsets_m` move vertices of meshes (scene::Vertex::offset).
std::vector<Facet> facets_of(const scene::Scene& scene, const scene::Part& part,
                             std::span<const math::Vec3> offsets_m);

/// Returns a mesh vertex's place in an animation.
math::Vec3 place_of(const scene::Vertex& vertex, std::span<const math::Vec3> offsets_m);

/// Returns the face of a die that points up most.
std::uint32_t upper_face(const math::Quat& orientation);

}  // namespace sleight::shapes
