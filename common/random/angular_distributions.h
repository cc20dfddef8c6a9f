// Distributions on the circle, on directions and on rotations. What all distributions share is in
// distributions.h; angles are in radians on [-k_pi, k_pi) (common/math/angle.h).
#pragma once

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "common/random/stream.h"

namespace sleight::random {

/// A vector or quaternion whose squared norm is within this of 1 lies on the sphere, for
/// log_density. Rounding makes about 1e-15; only a forgotten normalisation makes more.
constexpr double k_unit_square_tolerance = 1e-9;

/// A normal angle wrapped round the circle: density, with respect to angle,
///   sum over whole k of N(x + 2 pi k; mean, sd)
///     = (1/(2 pi)) (1 + 2 sum over n >= 1 of exp(-n^2 sd^2/2) cos(n (x - mean))),
/// two forms of one theta function (K. Mardia, P. Jupp, "Directional statistics", 2000,
/// section 3.5). The first is summed for sd below sqrt(2 pi), the second above: either leaves out
/// less than 1e-16 of the density. From sd = 9 on it is the uniform distribution to within 1e-17.
/// Two words per draw, or one in that last case. REQUIRES: mean finite; sd > 0 and finite.
struct WrappedNormal {
  double mean = 0;
  double sd = 1;

  double draw(Stream& stream) const;
  /// -infinity outside [-k_pi, k_pi). REQUIRES: x is not NaN.
  double log_density(double x) const;
};

/// Density 1/(2 pi) with respect to angle. One word per draw.
struct UniformAngle {
  double draw(Stream& stream) const;
  double log_density(double x) const;
};

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
