// Rotations of space as unit quaternions, without libm and with a written-out order of operations.
//
// A Quat is (w; x, y, z) with w^2 + x^2 + y^2 + z^2 = 1: the rotation by the angle t about the unit
// axis n is (cos(t/2); n sin(t/2)). q and -q are the same rotation. A rotation maps coordinates of
// the body's frame to the world's: world = rotated(q, body).
//
// Invariants
//   1. Same bits whatever the instruction set, under the conditions that vector.h gives. Eigen's
//      quaternion product, normalisation, rotation and AngleAxis are not used.
//   2. Functions that take a Quat as a rotation REQUIRE its norm to be 1 to within 1e-6 or so: they
//      do not renormalise, and their error grows with the deviation. A chain of compositions loses
//      about one ulp of norm per step; normalized() restores it.
// Thread safety: pure functions.
#pragma once

#include <Eigen/Geometry>

#include "common/math/vector.h"

namespace sleight::math {

/// Aligned to 16 or 32 bytes depending on build flags: never store its raw bytes.
using Quat = Eigen::Quaterniond;

/// Exponential map: the rotation by |v| radians about v (right-handed); the zero vector gives the
/// identity. The norm is 1 to within 2^-50. REQUIRES: |v| is finite.
Quat quaternion_of_rotation_vector(const Vec3& rotation_vector_rad);

/// The rotation that does `first`, then `second` (the Hamilton product second * first).
Quat composed(const Quat& second, const Quat& first);

/// The inverse rotation: the conjugate, exact.
Quat inverse(const Quat& q);

/// Scaled to norm 1. REQUIRES: the norm is neither 0 nor infinite nor NaN.
Quat normalized(const Quat& q);

/// v in the world's frame, given in the body's.
Vec3 rotated(const Quat& q, const Vec3& v);

/// The matrix M with product(M, v) = rotated(q, v), up to rounding.
Mat3 matrix_of(const Quat& q);

}  // namespace sleight::math
