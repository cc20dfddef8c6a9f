// Rotations of space as unit quaternions. The functions don't call libm, and the order of
// operations is explicit.
//
// A Quat is (w; x, y, z) with w^2 + x^2 + y^2 + z^2 = 1. The rotation by the angle t about the unit
// axis n is (cos(t/2); n sin(t/2)). q and -q are the same rotation. A rotation maps coordinates
// from the body's frame to the world's: world = rotated(q, body).
//
// Invariants
//   1. The bits are the same for any instruction set, under the conditions in vector.h. Eigen's
//      quaternion product, normalisation, rotation and AngleAxis are not used.
//   2. Functions that take a Quat as a rotation REQUIRE its norm to be 1 to within some 1e-6. These
//      functions don't renormalise, and their error grows with the deviation. Each composition in a
//      chain loses about one ulp of norm; normalized() restores the norm.
// Thread safety: pure functions.
#pragma once

#include <Eigen/Geometry>

#include "common/math/vector.h"

namespace sleight::math {

/// A Quat is aligned to 16 or 32 bytes depending on build flags, so never store its raw bytes.
using Quat = Eigen::Quaterniond;

/// Exponential map: the rotation by |v| radians about v (right-handed); the identity for zero. The
/// norm is 1 to within 2^-50. REQUIRES: |v| is finite.
Quat quaternion_of_rotation_vector(const Vec3& rotation_vector_rad);

/// The rotation that does `first`, then `second` (the Hamilton product second * first).
inline Quat composed(const Quat& second, const Quat& first) {
  const Quat& a = second;
  const Quat& b = first;
  return {((a.w() * b.w() - a.x() * b.x()) - a.y() * b.y()) - a.z() * b.z(),
          ((a.w() * b.x() + a.x() * b.w()) + a.y() * b.z()) - a.z() * b.y(),
          ((a.w() * b.y() + a.y() * b.w()) + a.z() * b.x()) - a.x() * b.z(),
          ((a.w() * b.z() + a.z() * b.w()) + a.x() * b.y()) - a.y() * b.x()};
}

/// The inverse rotation: the conjugate, exact.
inline Quat inverse(const Quat& q) {
  return {q.w(), -q.x(), -q.y(), -q.z()};
}

/// Scales q to norm 1. REQUIRES: the norm is neither 0 nor infinite nor NaN.
Quat normalized(const Quat& q);

/// Rotates v from the body's frame into the world's.
inline Vec3 rotated(const Quat& q, const Vec3& v) {
  // The result is v + w t + u x t. Here t = 2 u x v, and u is the vector part of q. This formula
  // takes 15 multiplications; q v q^-1 takes 24. For the identity, the result is exactly v.
  const Vec3 u(q.x(), q.y(), q.z());
  const Vec3 half = cross(u, v);
  const Vec3 t(2 * half.x(), 2 * half.y(), 2 * half.z());
  const Vec3 ut = cross(u, t);
  return {(v.x() + q.w() * t.x()) + ut.x(), (v.y() + q.w() * t.y()) + ut.y(),
          (v.z() + q.w() * t.z()) + ut.z()};
}

/// The matrix M with product(M, v) = rotated(q, v), up to rounding.
inline Mat3 matrix_of(const Quat& q) {
  const double xx = q.x() * q.x();
  const double yy = q.y() * q.y();
  const double zz = q.z() * q.z();
  const double xy = q.x() * q.y();
  const double xz = q.x() * q.z();
  const double yz = q.y() * q.z();
  const double wx = q.w() * q.x();
  const double wy = q.w() * q.y();
  const double wz = q.w() * q.z();
  Mat3 m;
  m(0, 0) = 1 - 2 * (yy + zz);
  m(0, 1) = 2 * (xy - wz);
  m(0, 2) = 2 * (xz + wy);
  m(1, 0) = 2 * (xy + wz);
  m(1, 1) = 1 - 2 * (xx + zz);
  m(1, 2) = 2 * (yz - wx);
  m(2, 0) = 2 * (xz - wy);
  m(2, 1) = 2 * (yz + wx);
  m(2, 2) = 1 - 2 * (xx + yy);
  return m;
}

}  // namespace sleight::math
