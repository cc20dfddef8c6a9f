// How fast a body in free flight turns at most, and how fast its angular velocity changes.
//
// Idea. The angular velocity in the body's frame moves along the polhode, where w1^2, w2^2 and w3^2
// are linear functions of y = |w|^2, since energy and angular momentum fix two of the three. With
// the moments in the order I1 <= I2 <= I3 only w2^2 falls as y grows, so y is greatest where w2 =
// 0:
//   y <= w1^2 + w2^2 + w3^2 + w2^2 (I2 - I1)(I3 - I2)/(I1 I3).
// This is exact (a body on a full polhode gets there) and never above |L|/I1, often far below.
// Likewise each of the three squares has its greatest value at an end of its interval, and Euler's
// equations then bound |dw/dt|, which is the same in both frames because w x w = 0.
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "worker/physics/motion/free_flight.h"

namespace sleight::physics {

/// Valid from the flight's begin for ever, for exact motion and for what rotation_track.h computes:
/// a margin of 2^-30 of each covers rounding and drift.
struct RotationBounds {
  double angular_speed_radps = 0;
  /// Of the vector in the world's frame; 0 for spherical bodies.
  double angular_acceleration_radps2 = 0;
  /// The rates of the angles that closed forms multiply by time, added up. An orientation s seconds
  /// after begin carries a rounding error of about 2^-51 (4 + rate s) rad. 0 for general bodies,
  /// whose steps round anew without regard to time.
  double phase_rate_radps = 0;
};

RotationBounds rotation_bounds(const FreeFlight& flight, const Inertia& inertia);

/// The same for a general body, from the angular velocity about the body's own axes.
RotationBounds general_rotation_bounds(const Vec3& principal_kgm2, const Vec3& body_radps);

/// Speed, relative to the centre of mass, of any point of the body within a radius of it.
inline double turning_speed_mps_max(const RotationBounds& bounds, double radius_m) {
  return bounds.angular_speed_radps * radius_m;
}

/// How far any point within a radius of the centre is in one pose from where it was in another, at
/// most. Unit quaternions a distance d apart, or d from the other's negative, differ by a turn of
/// 4 asin(d / 2), which moves a point by at most 2 d of its radius.
inline double moved_m_max(const Pose& then, const Pose& now, double radius_m) {
  const Eigen::Vector4d& p = then.orientation.coeffs();
  const Eigen::Vector4d& q = now.orientation.coeffs();
  const double apart = std::sqrt(std::min((q - p).squaredNorm(), (q + p).squaredNorm()));
  return math::norm(now.position_m - then.position_m) + 2 * apart * radius_m;
}

/// Acceleration, relative to the centre of mass, of any such point:
/// |w x (w x r) + dw/dt x r| <= (|w|^2 + |dw/dt|) |r|.
inline double turning_acceleration_mps2_max(const RotationBounds& bounds, double radius_m) {
  return (bounds.angular_speed_radps * bounds.angular_speed_radps +
          bounds.angular_acceleration_radps2) *
         radius_m;
}

}  // namespace sleight::physics
