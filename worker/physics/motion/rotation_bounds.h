// Bounds how fast a body in free flight turns, and how fast its angular velocity changes.
//
// Idea. The angular velocity in the body's frame moves along the polhode. Energy and angular
// momentum give two linear equations for w1^2, w2^2 and w3^2, so all three are linear functions of
// y = |w|^2. If I1 <= I2 <= I3, only w2^2 falls as y grows, so y is greatest at w2 = 0:
//   y <= w1^2 + w2^2 + w3^2 + w2^2 (I2 - I1)(I3 - I2)/(I1 I3).
// This bound is exact: a body on a full polhode reaches it. The bound on |w| is never above |L|/I1
// and often far below. Each of the three squares is greatest at an end of the interval of y. So
// Euler's equations bound |dw/dt|, which is the same in the body's and the world's frame because w
// x w = 0. Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "worker/physics/motion/free_flight.h"

namespace sleight::physics {

/// These bounds hold at all times from the flight's start, for exact motion and for the results of
/// rotation_track.h. A margin of 2^-30 of each value covers rounding and drift.
struct RotationBounds {
  double angular_speed_radps = 0;
  /// Maximum |dw/dt| in the world's frame. 0 for spherical bodies.
  double angular_acceleration_radps2 = 0;
  /// Sum of the angular rates that closed forms multiply by time. An orientation s seconds after
  /// the flight's start has a rounding error of about 2^-51 (4 + rate s) rad. 0 for general bodies,
  /// because their steps round independently of time.
  double phase_rate_radps = 0;
};

RotationBounds rotation_bounds(const FreeFlight& flight, const Inertia& inertia);

/// Returns a general body's bounds, given the angular velocity in the body's frame.
RotationBounds general_rotation_bounds(const Vec3& principal_kgm2, const Vec3& body_radps);

/// Returns the maximum speed of points within the radius, relative to the centre of mass.
inline double turning_speed_mps_max(const RotationBounds& bounds, double radius_m) {
  return bounds.angular_speed_radps * radius_m;
}

/// Bounds the distance between a point's positions in two poses. The point is within the radius of
/// the centre. If |q - p| = d or |q + p| = d, the unit quaternions p and q differ by a turn of 4
/// asin(d / 2). This turn moves the point by at most 2 d times the radius.
inline double moved_m_max(const Pose& then, const Pose& now, double radius_m) {
  const Eigen::Vector4d& p = then.orientation.coeffs();
  const Eigen::Vector4d& q = now.orientation.coeffs();
  const double apart = std::sqrt(std::min((q - p).squaredNorm(), (q + p).squaredNorm()));
  return math::norm(now.position_m - then.position_m) + 2 * apart * radius_m;
}

/// Returns the maximum acceleration of points within the radius, relative to the centre of mass: |w
/// x (w x r) + dw/dt x r| <= (|w|^2 + |dw/dt|) |r|.
inline double turning_acceleration_mps2_max(const RotationBounds& bounds, double radius_m) {
  return (bounds.angular_speed_radps * bounds.angular_speed_radps +
          bounds.angular_acceleration_radps2) *
         radius_m;
}

}  // namespace sleight::physics
