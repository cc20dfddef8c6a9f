// What a part of a scene looks like, as flat polygons: the one place that knows each shape.
//
// clients/pictures projects the polygons; clients/export makes triangles of them for glTF and the
// gallery. So a new shape of body is drawn everywhere once it has facets here. Ground and surfaces
// are scenery that a body never has: they have none.
//
// Frame: the part's, z up, metres. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "common/scene/scene.h"

namespace sleight::shapes {

/// A convex polygon.
struct Facet {
  std::vector<math::Vec3> corners_m{};  ///< counter-clockwise seen from outside
  /// Unit normals at the corners, where the facet is part of a curved surface; empty: it is flat.
  std::vector<math::Vec3> normals{};
  std::uint32_t face = 0;  ///< 1 to 6: of a die's face and its pips; 0: of all else
  bool is_pip = false;     ///< lies a hundredth of half a side above its face
  bool is_seen_from_behind = false;
};

/// Spheres have 192 triangles' worth of facets. A die's face comes before its pips. `offsets_m`
/// move vertices of meshes (scene::Vertex::offset).
std::vector<Facet> facets_of(const scene::Scene& scene, const scene::Part& part,
                             std::span<const math::Vec3> offsets_m);

/// Where a mesh's vertex is in an animation.
math::Vec3 place_of(const scene::Vertex& vertex, std::span<const math::Vec3> offsets_m);

/// Which face of a die is most upwards.
std::uint32_t upper_face(const math::Quat& orientation);

}  // namespace sleight::shapes
