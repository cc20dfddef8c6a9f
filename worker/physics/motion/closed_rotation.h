// Free rotation of spherical and axially symmetric bodies, in closed form.
//
// Idea. If I1 = I2, the angular momentum is L = I1 (w + (I3/I1 - 1) w3 z). Here z is the body's
// axis in the world's frame, and w3 = w.z is constant. The axis and w both turn about the constant
// L at the rate |L|/I1 (the precession). The body turns about its own axis at w3 (1 - I3/I1):
//   q(s) = exp(L/I1 s) q(0) exp(z_body w3 (1 - I3/I1) s),   w(s) = exp(L/I1 s) w(0)
// (Landau and Lifshitz, "Mechanics", sections 33 and 35). If also I3 = I1, the body is spherical:
// L/I1 = w and w3 (1 - I3/I1) = 0. Thread safety: values and pure functions.
#pragma once

#include "common/base/check.h"
#include "worker/physics/motion/free_flight.h"

namespace sleight::physics {

struct ClosedRotation {
  Vec3 precession_radps = Vec3::Zero();  ///< L/I1, in the world's frame
  double spin_radps = 0;                 ///< about the body's z axis, in the precessing frame
};

/// REQUIRES: the symmetry is spherical or axial; moments that it declares equal are equal.
inline ClosedRotation closed_rotation(const FreeFlight& flight, const Inertia& inertia) {
  const Vec3& moments = inertia.principal_kgm2;
  const Vec3& w = flight.angular_velocity_radps;
  CHECK_EQ(moments.x(), moments.y());
  if (inertia.symmetry == InertiaSymmetry::spherical) {
    CHECK_EQ(moments.x(), moments.z());
    return {.precession_radps = w};
  }
  CHECK(inertia.symmetry == InertiaSymmetry::axial);
  const Vec3 axis = math::rotated(flight.orientation, Vec3(0, 0, 1));
  const double about_axis = math::dot(axis, w);
  const double excess = (moments.z() - moments.x()) / moments.x();
  return {.precession_radps = w + (excess * about_axis) * axis,
          .spin_radps = -(excess * about_axis)};
}

/// Returns q(s), given q(0).
inline Quat turned(const ClosedRotation& rotation, const Quat& start, double s) {
  const Quat outer = math::quaternion_of_rotation_vector(s * rotation.precession_radps);
  if (rotation.spin_radps == 0) return math::composed(outer, start);
  const math::SinCos half = math::sincos(0.5 * (rotation.spin_radps * s));
  // Compute start * (cos; 0, 0, sin) without multiplications by 0.
  const Quat inner(
      start.w() * half.cos - start.z() * half.sin, start.x() * half.cos + start.y() * half.sin,
      start.y() * half.cos - start.x() * half.sin, start.z() * half.cos + start.w() * half.sin);
  return math::composed(outer, inner);
}

/// Returns w(s), given w(0). If spin_radps is 0, the result is w(0), bit for bit.
inline Vec3 precessed(const ClosedRotation& rotation, const Vec3& start_radps, double s) {
  if (rotation.spin_radps == 0) return start_radps;
  return math::rotated(math::quaternion_of_rotation_vector(s * rotation.precession_radps),
                       start_radps);
}

}  // namespace sleight::physics
