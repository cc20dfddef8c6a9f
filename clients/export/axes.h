// From the scene's axes to those of glTF, both right-handed and in metres.
//
// The scene has z up; glTF has y up and +z towards the viewer: (x, y, z) becomes (x, z, -y). All
// data are so converted, instead of turning one root node, so that no rounding enters: a program
// with z up that undoes it (Blender) has the archive's numbers, to float's precision.
//
// Pure functions.
#pragma once

#include <array>

#include "common/math/rotation.h"
#include "common/math/vector.h"

namespace sleight::gltf {

using Float3 = std::array<float, 3>;
using Float4 = std::array<float, 4>;

/// A place, a direction or a displacement. Has no -0, which would be printed as such.
inline Float3 y_up(const math::Vec3& v) {
  return {static_cast<float>(v.x() + 0.0), static_cast<float>(v.z() + 0.0),
          static_cast<float>(0.0 - v.y())};
}

/// A rotation, in glTF's order of components: x, y, z, w.
inline Float4 y_up(const math::Quat& q) {
  return {static_cast<float>(q.x() + 0.0), static_cast<float>(q.z() + 0.0),
          static_cast<float>(0.0 - q.y()), static_cast<float>(q.w() + 0.0)};
}

/// Sizes along the axes: no sign.
inline constexpr Float3 k_shown{1, 1, 1};
inline constexpr Float3 k_hidden{0, 0, 0};

}  // namespace sleight::gltf
