// The noise of one impact (scene/contact_noise.h).
//
// Thread safety: pure functions.
#pragma once

#include <algorithm>

#include "common/math/vector.h"
#include "worker/physics/response/tangent.h"

namespace sleight::physics {

/// A value times the impact's strength and the standard deviations.
struct ImpactNoise {
  double tilt_first = 0;
  double tilt_second = 0;
  double restitution = 0;

  math::Vec3 tilted(const math::Vec3& normal) const {
    const math::Vec3 first = any_tangent(normal);
    const math::Vec3 second = math::cross(normal, first);
    return math::normalized(normal + tilt_first * first + tilt_second * second);
  }
  double noised(double law_restitution) const {
    return std::clamp(law_restitution + restitution, 0.0, 1.0);
  }
};

}  // namespace sleight::physics
