// Distributions on directions and on rotations. distributions.h says what all distributions share.
#pragma once

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "common/random/stream.h"

namespace sleight::random {

/// A vector or quaternion whose squared norm is within this of 1 lies on the sphere, for
/// log_density. Rounding makes about 1e-15; only a forgotten normalisation makes more.
constexpr double k_unit_square_tolerance = 1e-9;

/// A unit vector of the plane, density 1/(2 pi) with respect to arc length. One word per draw.
struct UniformDirection2 {
  math::Vec2 draw(Stream& stream) const;
  double log_density(const math::Vec2& x) const;
};

/// A unit vector of space, density 1/(4 pi) with respect to area on the unit sphere: the height z
/// is uniform on [-1, 1] (Archimedes). Two words per draw.
struct UniformDirection3 {
  math::Vec3 draw(Stream& stream) const;
  double log_density(const math::Vec3& x) const;
};

/// A rotation, all as likely (Haar measure), as a unit quaternion: density 1/(2 pi^2) with respect
/// to volume on the unit sphere of four dimensions. q and -q, the same rotation, both occur.
/// Method: K. Shoemake, "Uniform random rotations", Graphics Gems III (1992). Three words per draw.
struct UniformRotation {
  math::Quat draw(Stream& stream) const;
  double log_density(const math::Quat& x) const;
};

}  // namespace sleight::random
