// Bounds on rounding and speed, for the searches for convex pieces and for round pieces.
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

/// The search margins below affect speed. If a pair touches, the margins also affect how late its
/// collision may be (SIMULATOR.md, "Where it falls short"). Pieces are well apart if the gap along
/// a guessed axis exceeds this share of the smaller piece's radius. Otherwise the search computes
/// the closest points.
inline constexpr double k_well_apart = 0.02;

/// If a skip is at least this long, no second axis is tried to make it longer. In heaps, where
/// speed matters most, bodies usually change their motion sooner.
inline constexpr double k_long_enough_s = 5e-4;

/// Returns an upper bound of the coordinates of a piece's points. It determines the points'
/// rounding.
inline double size_m(const MovingPiece& piece) {
  return std::max(size_of(piece.pose.position_m), piece.coordinates_m) + piece.view->r_outer_m +
         piece.radius_m;
}
/// Returns a bound on the rounding error of gaps at the skipped ticks.
inline double rounding_m(const MovingPiece& a, const MovingPiece& b) {
  return k_rounding_ulps * std::max(size_m(a), size_m(b));
}
inline double rounding_m(const HalfSpace& solid_below, const MovingPiece& b) {
  return k_rounding_ulps * (std::fabs(solid_below.offset_m) + size_m(b));
}

/// Returns a time for which a collision is impossible because all relative speeds are too low. For
/// hovering pieces this time is long, even if rounding hides whether they touch.
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

/// Returns the time in which two touching pieces, at their present speed, may come
/// k_touching_depth_m deeper.
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
