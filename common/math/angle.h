// Angles on the circle: the constants, and the reduction to one turn.
//
// Angles are in radians; the circle is [-k_pi, k_pi), half open, with k_pi the double nearest to pi
// (1.2e-16 below it). Thread safety: pure functions.
#pragma once

#include <cmath>

#include "common/base/check.h"

namespace sleight::math {

constexpr double k_pi = 0x1.921fb54442d18p+1;
constexpr double k_two_pi = 0x1.921fb54442d18p+2;

/// The angle in [-k_pi, k_pi) that differs from the given one by whole turns of k_two_pi. An angle
/// already there is returned unchanged. Each turn taken off adds an error of up to 2.5e-16, and the
/// argument's own spacing is lost as always.
/// REQUIRES: finite.
inline double wrapped_angle(double angle_rad) {
  CHECK(std::isfinite(angle_rad));
  if (angle_rad >= -k_pi && angle_rad < k_pi) return angle_rad;
  // std::floor is exact. Rounding can leave the difference just outside, by less than a turn.
  const double turns = std::floor((angle_rad + k_pi) / k_two_pi);
  double wrapped = angle_rad - turns * k_two_pi;
  if (wrapped >= k_pi) wrapped -= k_two_pi;
  if (wrapped < -k_pi) wrapped += k_two_pi;
  // Arguments beyond 1e15 have lost the angle: any point of the circle is as good, but in range.
  return wrapped >= -k_pi && wrapped < k_pi ? wrapped : -k_pi;
}

}  // namespace sleight::math
