// A body in free flight: its start, and its centre of mass at any later tick.
//
// Idea. Between two events a body has constant acceleration, so the state at the start of the
// flight determines its whole motion. The centre of mass follows a parabola, computed here.
// rotation_track.h computes the orientation. motion_bounds.h bounds position and orientation.
//
// Invariants
//   1. Evaluation depends only on flight and tick, not on earlier evaluations.
//   2. Results depend on a tick only through its exact difference from `begin`. So if a flight is
//      shifted by n ticks, its results are shifted by n ticks and keep their bits.
//   3. At the tick `begin` every function returns the flight's values, bit for bit.
// Thread safety: values and pure functions.
#pragma once

#include "worker/physics/event/tick.h"
#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

/// The start of a free flight, in the world's frame: 144 bytes. `orientation` has norm 1 to within
/// 1e-12. A flight's creator normalises `orientation`; evaluation keeps the norm.
struct FreeFlight {
  Tick begin;
  Vec3 position_m = Vec3::Zero();  ///< of the centre of mass
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 acceleration_mps2 = Vec3::Zero();  ///< constant during the flight
  Quat orientation = Quat::Identity();    ///< from the body's frame to the world's
  Vec3 angular_velocity_radps = Vec3::Zero();
};

/// Returns the time since the flight began. The result is exact for spans of up to 2^53 ticks.
inline double seconds_since_begin(const FreeFlight& flight, Tick t) {
  return seconds(t - flight.begin);
}

/// Returns p + (v + a s/2) s, with four roundings. motion_bounds.h relies on this form.
inline double parabola(double position, double velocity, double acceleration, double s) {
  return position + (velocity + acceleration * (0.5 * s)) * s;
}

/// Returns the centre of mass. Rounding error per coordinate: 2^-51 (|p| + |v| s + |a| s^2/2).
inline Vec3 position_at(const FreeFlight& flight, Tick t) {
  const double s = seconds_since_begin(flight, t);
  const Vec3& p = flight.position_m;
  const Vec3& v = flight.velocity_mps;
  const Vec3& a = flight.acceleration_mps2;
  return {parabola(p.x(), v.x(), a.x(), s), parabola(p.y(), v.y(), a.y(), s),
          parabola(p.z(), v.z(), a.z(), s)};
}

/// Returns the centre of mass's velocity. Rounding error per coordinate: 2^-52 (|v| + |a| s).
inline Vec3 velocity_at(const FreeFlight& flight, Tick t) {
  const double s = seconds_since_begin(flight, t);
  return flight.velocity_mps + s * flight.acceleration_mps2;
}

}  // namespace sleight::physics
