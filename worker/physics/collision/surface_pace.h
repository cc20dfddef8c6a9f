// Bounds how fast a box can move relative to the surface under it.
//
// Internal to surface_search.cpp. Thread safety: one thread per surface, because it caches lookups.
#pragma once

#include <algorithm>
#include <cmath>

#include "worker/physics/collision/first_collision.h"
#include "worker/physics/collision/surface_search.h"

namespace sleight::physics::surface_pace {

/// The bounds hold while the box's centre moves by less than this share of the box's reach. If the
/// box is higher than the whole surface nearby, its centre may move by the reach plus one patch.
/// Affects speed only.
inline constexpr double k_room = 0.25;

/// The rounding error of a gap or rate is less than this share of the numbers from which it is
/// computed.
inline constexpr double k_rounding = 0x1p-48;

/// Maximum rates of change, valid for `valid_s`.
struct Pace {
  SurfaceBounds surface;
  double stretch = 1;              ///< sqrt(1 + slope^2): length of (-S_x, -S_y, 1)
  double bend_per_m = 0;           ///< of the surface, up or down
  double past_mps = 0;             ///< maximum horizontal speed of any point of the box
  double turning_radps = 0;        ///< of the box
  double fall_mps2 = 0;            ///< the second derivative of a gap is at least minus this
  double jerk_mps3 = k_forever_s;  ///< maximum rate of that derivative, if the box turns evenly
  double valid_s = 0;
  double rounding_m = 0;  ///< of gaps
  double rounding_mps = 0;

  /// Returns a tighter `fall_mps2` (at least 0) for one point and the time up to `until_s`.
  /// `pull_mps2` is the second derivative of the point's gap now.
  double fall_of(double pull_mps2, double until_s) const {
    if (jerk_mps3 == k_forever_s) return fall_mps2;
    const double fall = -pull_mps2 + 0.5 * jerk_mps3 * until_s;
    return std::clamp(fall, 0.0, fall_mps2);
  }
};

/// Longer than any simulation. Not infinite, because 0 times infinity isn't a number.
inline constexpr double k_always_s = seconds(k_tick_max.value);

/// Returns a time for which the centre's horizontal distance from its present place stays below
/// `room_m`.
inline double stays_within_s(const MovingPiece& box, double room_m) {
  const auto across = [](const Vec3& v) { return std::sqrt(v.x() * v.x() + v.y() * v.y()); };
  const double speed_mps = across(box.velocity_mps);
  const double root = std::sqrt(speed_mps * speed_mps + 2 * across(box.acceleration_mps2) * room_m);
  return 2 * room_m < k_always_s * (speed_mps + root) ? 2 * room_m / (speed_mps + root)
                                                      : k_always_s;
}

inline SurfaceBounds bounds_around(SplineSurface& surface, const MovingPiece& box, double room_m) {
  const Vec3& centre_m = box.pose.position_m;
  const double away_m = box.reach_m + room_m;
  return surface.bounds_in(centre_m.x() - away_m, centre_m.x() + away_m, centre_m.y() - away_m,
                           centre_m.y() + away_m);
}

inline Pace pace_of(SplineSurface& surface, const MovingPiece& box) {
  const double room_m = k_room * box.reach_m;
  Pace pace{.surface = bounds_around(surface, box, room_m)};
  const SurfaceBounds& bounds = pace.surface;
  const Vec3& pull_mps2 = box.acceleration_mps2;
  const double aside_mps2 =
      std::sqrt(pull_mps2.x() * pull_mps2.x() + pull_mps2.y() * pull_mps2.y());
  const double turning_mps = std::sqrt(box.turning_acceleration_mps2 * box.reach_m);
  pace.valid_s = stays_within_s(box, room_m);
  pace.stretch = std::sqrt(1 + bounds.slope * bounds.slope);
  pace.bend_per_m = std::max(bounds.hollow_per_m, bounds.bump_per_m);
  const double gained_mps = aside_mps2 > 0 ? aside_mps2 * pace.valid_s : 0;
  const Vec3& v = box.velocity_mps;
  pace.past_mps = std::sqrt(v.x() * v.x() + v.y() * v.y()) + turning_mps + gained_mps;
  pace.turning_radps = std::max(math::norm(box.angular_velocity_radps), turning_mps / box.reach_m);
  // d2/dt2 (z - S) = z'' - grad S . x'' - x'^T H x'; x'' is the centre's acceleration plus the
  // acceleration caused by turning.
  pace.fall_mps2 = std::max(0.0, (bounds.slope * aside_mps2 - pull_mps2.z()) +
                                     pace.stretch * box.turning_acceleration_mps2 +
                                     bounds.hollow_per_m * (pace.past_mps * pace.past_mps));
  if (box.turns_evenly) {
    // The point adds (-grad S, 1) . j to d3/dt3 (z - S); the surface adds -3 v^T H a - T v^3.
    pace.jerk_mps3 =
        pace.stretch * pace.turning_radps * box.turning_acceleration_mps2 +
        pace.past_mps * (3 * pace.bend_per_m * (aside_mps2 + box.turning_acceleration_mps2) +
                         bounds.twist_per_m2 * (pace.past_mps * pace.past_mps));
  }
  const double height_m = std::fabs(box.pose.position_m.z()) + box.reach_m;
  const double across_m = std::fabs(box.pose.position_m.x()) + std::fabs(box.pose.position_m.y());
  pace.rounding_m = k_rounding * (height_m + bounds.slope * (across_m + box.reach_m));
  pace.rounding_mps = k_rounding * (std::fabs(v.z()) + pace.stretch * pace.past_mps +
                                    pace.turning_radps * box.reach_m);
  return pace;
}

}  // namespace sleight::physics::surface_pace
