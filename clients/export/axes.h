// Converts from the scene's axes to those of glTF, both right-handed and in metres.
//
// The scene has z up; glTF has y up and +z towards the viewer: (x, y, z) becomes (x, z, -y). To
// avoid rounding, all data are converted instead of rotating a root node. A program with z up, such
// as Blender, reverses the conversion and gets the archive's numbers as floats. Pure functions.
#pragma once

#include <array>

#include "common/math/rotation.h"
#include "common/math/vector.h"

namespace sleight::gltf {

using Float3 = std::array<float, 3>;
using Float4 = std::array<float, 4>;

/// Converts a place, a direction or a displacement. Avoids -0, whose sign would be printed.
inline Float3 y_up(const math::Vec3& v) {
  return {static_cast<float>(v.x() + 0.0), static_cast<float>(v.z() + 0.0),
          static_cast<float>(0.0 - v.y())};
}

/// Converts a rotation; components are in glTF's order x, y, z, w.
inline Float4 y_up(const math::Quat& q) {
  return {static_cast<float>(q.x() + 0.0), static_cast<float>(q.z() + 0.0),
          static_cast<float>(0.0 - q.y()), static_cast<float>(q.w() + 0.0)};
}

/// Node scales of visible and hidden things.
inline constexpr Float3 k_shown{1, 1, 1};
inline constexpr Float3 k_hidden{0, 0, 0};

}  // namespace sleight::gltf
