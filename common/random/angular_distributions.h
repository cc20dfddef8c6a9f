// Distributions on directions and on rotations. distributions.h states their common properties.
#pragma once

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "common/random/stream.h"

namespace sleight::random {

/// Tolerance of log_density for a squared norm of 1. Rounding causes about 1e-15.
constexpr double k_unit_square_tolerance = 1e-9;

/// A unit vector of the plane, with density 1/(2 pi) by arc length. One word per draw.
struct UniformDirection2 {
  math::Vec2 draw(Stream& stream) const;
  double log_density(const math::Vec2& x) const;
};

/// A unit vector of space, with density 1/(4 pi) by area. The height z is uniform on [-1, 1]
/// (Archimedes). Two words per draw.
struct UniformDirection3 {
  math::Vec3 draw(Stream& stream) const;
  double log_density(const math::Vec3& x) const;
};

/// A uniform rotation (Haar measure) as a unit quaternion, with density 1/(2 pi^2) by volume on the
/// unit sphere of four dimensions. Both q and -q occur; they are the same rotation. Method:
/// Shoemake, "Uniform random rotations", Graphics Gems III (1992). Three words per draw.
struct UniformRotation {
  math::Quat draw(Stream& stream) const;
  double log_density(const math::Quat& x) const;
};

}  // namespace sleight::random
