// An arbitrary direction perpendicular to a normal.
//
// Thread safety: pure functions.
#pragma once

#include <cmath>

#include "common/math/vector.h"

namespace sleight::physics {

/// Returns a unit vector. REQUIRES: the normal has length 1.
inline math::Vec3 any_tangent(const math::Vec3& normal) {
  const math::Vec3 axis = std::fabs(normal.x()) < 0.6 ? math::Vec3(1, 0, 0) : math::Vec3(0, 1, 0);
  return math::normalized(math::cross(normal, axis));
}

}  // namespace sleight::physics
