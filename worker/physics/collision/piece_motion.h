// Rounding and speed bounds shared by the searches of convex and round pieces.
//
// Internal to worker/physics/collision. Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/collision/first_collision.h"
#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {

/// These search margins affect speed. They also affect how late the collision of a touching pair
/// may be (SIMULATOR.md, "Where it falls short"). Pieces are well apart when a guessed axis shows a
/// gap above this share of the smaller piece's radius. Below this gap, the exact line of the
/// closest points is worth computing.
inline constexpr double k_well_apart = 0.02;

/// A skip at least this long is not extended with a second axis. In heaps, where speed matters
/// most, bodies usually change their motion sooner.
inline constexpr double k_long_enough_s = 5e-4;

/// Returns the size of the coordinates of a piece's points, which determines their rounding.
inline double size_m(const MovingPiece& piece) {
  return std::max(size_of(piece.pose.position_m), piece.coordinates_m) + piece.view->r_outer_m +
         piece.radius_m;
}
/// Returns a bound on how rounding changes gaps at the skipped ticks.
inline double rounding_m(const MovingPiece& a, const MovingPiece& b) {
  return k_rounding_ulps * std::max(size_m(a), size_m(b));
}
inline double rounding_m(const HalfSpace& solid_below, const MovingPiece& b) {
  return k_rounding_ulps * (std::fabs(solid_below.offset_m) + size_m(b));
}

/// Returns a time for which no gap can shrink fast enough for a collision, because all relative
/// speeds are too low. For hovering pieces this time is long, even if rounding hides whether they
/// touch.
inline double too_slow_for_s(const MovingPiece& a, const MovingPiece& b) {
  const auto turning_mps = [](const MovingPiece& piece) {
    return math::norm(piece.angular_velocity_radps) * (piece.view->r_outer_m + piece.radius_m);
  };
  const double rounding_mps =
      k_rounding_ulps * (math::norm(a.velocity_mps) + math::norm(b.velocity_mps));
  const double left_mps =
      k_approach_mps - rounding_mps -
      (math::norm(b.velocity_mps - a.velocity_mps) + turning_mps(a) + turning_mps(b));
  if (left_mps <= 0) return 0;
  const double gains_mps2 = math::norm(b.acceleration_mps2 - a.acceleration_mps2) +
                            a.turning_acceleration_mps2 + b.turning_acceleration_mps2;
  return gains_mps2 > 0 ? left_mps / gains_mps2 : k_forever_s;
}

/// Returns the time after which two touching pieces must be examined again (k_touching_depth_m).
inline double comes_deeper_s(const MovingPiece& a, const MovingPiece& b, const Vec3& normal) {
  const auto turning_mps = [&](const MovingPiece& piece) {
    return math::norm(math::cross(piece.angular_velocity_radps, normal)) *
           (piece.view->r_outer_m + piece.radius_m);
  };
  const double fastest_mps = std::max(0.0, -math::dot(normal, b.velocity_mps - a.velocity_mps)) +
                             turning_mps(a) + turning_mps(b);
  return k_touching_depth_m / fastest_mps;
}

}  // namespace sleight::physics
