// Distributions on directions and on rotations. distributions.h states their common properties.
#pragma once

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "common/random/stream.h"

namespace sleight::random {

/// If a squared norm differs from 1 by at most this, log_density accepts it as 1. Rounding causes
/// about 1e-15.
constexpr double k_unit_square_tolerance = 1e-9;

/// A uniform unit vector of the plane. Its density by arc length is 1/(2 pi). One word per draw.
struct UniformDirection2 {
  math::Vec2 draw(Stream& stream) const;
  double log_density(const math::Vec2& x) const;
};

/// A uniform unit vector of space. Its density by area is 1/(4 pi). The height z is uniform on [-1,
/// 1] (Archimedes). Two words per draw.
struct UniformDirection3 {
  math::Vec3 draw(Stream& stream) const;
  double log_density(const math::Vec3& x) const;
};

/// A uniform rotation (Haar measure) as a unit quaternion. Its density by volume on the unit sphere
/// of four dimensions is 1/(2 pi^2). Both q and -q occur; they are the same rotation. Method:
/// Shoemake, "Uniform random rotations", Graphics Gems III (1992). Three words per draw.
struct UniformRotation {
  math::Quat draw(Stream& stream) const;
  double log_density(const math::Quat& x) const;
};

}  // namespace sleight::random
