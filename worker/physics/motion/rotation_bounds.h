// How fast a body in free flight turns at most, and how fast its angular velocity changes.
//
// Idea. The angular velocity in the body's frame moves along the polhode. Energy and angular
// momentum fix two of w1^2, w2^2 and w3^2, so all three are linear functions of y = |w|^2. With
// moments in the order I1 <= I2 <= I3, only w2^2 falls as y grows, so y is greatest at w2 = 0:
//   y <= w1^2 + w2^2 + w3^2 + w2^2 (I2 - I1)(I3 - I2)/(I1 I3).
// This bound is exact (a body on a full polhode reaches it) and never above |L|/I1, often far
// below. Each of the three squares also has its maximum at an end of its interval. So Euler's
// equations bound |dw/dt|, which is the same in both frames because w x w = 0. Thread safety: pure
// functions.
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

/// Returns the maximum speed, relative to the centre of mass, of the body's points within a radius.
inline double turning_speed_mps_max(const RotationBounds& bounds, double radius_m) {
  return bounds.angular_speed_radps * radius_m;
}

/// Returns how far a point within a radius of the centre can be in one pose from its position in
/// another pose. If two unit quaternions p and q have the distance |q - p| = d or |q + p| = d, they
/// differ by a turn of 4 asin(d / 2), which moves a point by at most 2 d times its radius.
inline double moved_m_max(const Pose& then, const Pose& now, double radius_m) {
  const Eigen::Vector4d& p = then.orientation.coeffs();
  const Eigen::Vector4d& q = now.orientation.coeffs();
  const double apart = std::sqrt(std::min((q - p).squaredNorm(), (q + p).squaredNorm()));
  return math::norm(now.position_m - then.position_m) + 2 * apart * radius_m;
}

/// Returns the maximum acceleration, relative to the centre of mass, of the body's points within a
/// radius: |w x (w x r) + dw/dt x r| <= (|w|^2 + |dw/dt|) |r|.
inline double turning_acceleration_mps2_max(const RotationBounds& bounds, double radius_m) {
  return (bounds.angular_speed_radps * bounds.angular_speed_radps +
          bounds.angular_acceleration_radps2) *
         radius_m;
}

}  // namespace sleight::physics
