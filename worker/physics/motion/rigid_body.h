// Mass and state of a rigid body.
//
// A body's frame has its origin at the centre of mass and its axes along the principal axes of
// inertia. A pose maps this frame to the world: world = position + rotated(orientation, body).
// Velocities and angular velocities are in the world's frame. Thread safety: values.
#pragma once

#include <cstdint>

#include "common/math/rotation.h"
#include "common/math/vector.h"

namespace sleight::physics {

using math::Mat3;
using math::Quat;
using math::Vec3;

/// Says which principal moments a shape declares equal. The symmetry selects how free rotation is
/// computed.
enum class InertiaSymmetry : std::uint8_t {
  spherical,  ///< all three equal: sphere, cube, icosahedron
  axial,      ///< x and y equal: a symmetric top about the body's z axis
  general
};

struct Inertia {
  double mass_kg = 0;                  ///< > 0
  Vec3 principal_kgm2 = Vec3::Zero();  ///< about the body's axes, through the centre of mass; > 0
  InertiaSymmetry symmetry = InertiaSymmetry::general;
};

/// Returns whether the vector is exactly 0.
inline bool is_zero(const Vec3& v) {
  return v.x() == 0 && v.y() == 0 && v.z() == 0;
}

struct Pose {
  Vec3 position_m = Vec3::Zero();
  Quat orientation = Quat::Identity();
};

struct Twist {
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 angular_velocity_radps = Vec3::Zero();
};

}  // namespace sleight::physics
