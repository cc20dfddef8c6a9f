// Quantities that a free rigid body conserves: kinetic energy (without gravity) and angular
// momentum. Thread safety: pure functions.
#pragma once

#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

/// Converts an angular velocity from the world's frame to the body's.
inline Vec3 body_angular_velocity_radps(const Quat& orientation, const Vec3& world_radps) {
  return math::rotated(math::inverse(orientation), world_radps);
}

/// Returns the energy of rotation about the centre of mass: (I1 w1^2 + I2 w2^2 + I3 w3^2)/2.
inline double rotational_energy_j(const Inertia& inertia, const Quat& orientation,
                                  const Vec3& angular_velocity_radps) {
  const Vec3 w = body_angular_velocity_radps(orientation, angular_velocity_radps);
  const Vec3& moments = inertia.principal_kgm2;
  return 0.5 * ((moments.x() * (w.x() * w.x()) + moments.y() * (w.y() * w.y())) +
                moments.z() * (w.z() * w.z()));
}

inline double kinetic_energy_j(const Inertia& inertia, const Quat& orientation,
                               const Twist& twist) {
  return 0.5 * inertia.mass_kg * math::dot(twist.velocity_mps, twist.velocity_mps) +
         rotational_energy_j(inertia, orientation, twist.angular_velocity_radps);
}

/// Returns the angular momentum about the centre of mass, in the world's frame, in kg m^2/s.
inline Vec3 angular_momentum_kgm2ps(const Inertia& inertia, const Quat& orientation,
                                    const Vec3& angular_velocity_radps) {
  const Vec3 w = body_angular_velocity_radps(orientation, angular_velocity_radps);
  const Vec3& moments = inertia.principal_kgm2;
  return math::rotated(orientation,
                       Vec3(moments.x() * w.x(), moments.y() * w.y(), moments.z() * w.z()));
}

}  // namespace sleight::physics
