// The orientation and angular velocity of a body in free flight, at any tick.
//
// Idea. Spherical and axially symmetric bodies have closed forms (closed_rotation.h). A general
// body is integrated by fixed steps from its flight's start (general_rotation.h), so late ticks are
// expensive. A RotationTrack stores the current step, so calls are cheap if their ticks mostly
// ascend.
//
// Invariants
//   1. The functions without a track are pure. A RotationTrack's functions return the same bits.
//   2. Only ticks since the flight's start matter (free_flight.h, invariant 2). Results at the
//      start are the flight's values.
//   3. If moments coincide, closed forms and general steps agree up to rounding. An axial body with
//      three equal moments rotates as a spherical body does, bit for bit.
// Accuracy: closed forms have errors below 2^-50 (4 + angle), where `angle` is the turn since the
// start. General bodies conserve energy and angular momentum to about 1e-14 over 1,000 revolutions.
// Thread safety: pure functions; one RotationTrack is not shared between threads.
#pragma once

#include <memory>

#include "worker/physics/motion/closed_rotation.h"
#include "worker/physics/motion/general_rotation.h"

namespace sleight::physics {

/// Returns the rotation from the body's frame to the world's. REQUIRES: t <= rotation_horizon, and
/// for a general body t >= begin. Cost: 40 ns spherical, 60 ns axial. For a general body, the cost
/// grows with t - begin: 0.4 us per step of 1/8 to 1/4 radian.
Quat orientation_at(const FreeFlight& flight, const Inertia& inertia, Tick t);

/// Returns the angular velocity in the world's frame. REQUIRES and cost: as for orientation_at.
Vec3 angular_velocity_at(const FreeFlight& flight, const Inertia& inertia, Tick t);

/// Returns the latest tick at which a flight's rotation can be evaluated, at most k_tick_max. If
/// the body is too fast, this is the tick at which the flight begins. The creator of a general
/// body's flight must check this tick. If the flight lasts longer, it must end with a typed error.
/// The limit is GeneralRotation::k_steps_max steps, over 131,000 rad (22 minutes at 100 rad/s).
Tick rotation_horizon(const FreeFlight& flight, const Inertia& inertia);

/// A body's current flight. A RotationTrack is small for bodies with closed forms. For a general
/// body, it allocates 1.3 kB once, which restart() reuses.
class RotationTrack {
 public:
  RotationTrack() = default;
  RotationTrack(const FreeFlight& flight, const Inertia& inertia) { restart(flight, inertia); }

  /// Follows another flight. REQUIRES: moments > 0, and equal where the symmetry requires it;
  /// orientation of norm 1; everything finite.
  void restart(const FreeFlight& flight, const Inertia& inertia);

  /// Returns rotation_horizon() of the flight.
  Tick horizon() const;

  /// Return what the free functions above return. REQUIRES: as for these.
  Quat orientation_at(Tick t);
  Vec3 angular_velocity_at(Tick t);

 private:
  Tick begin_;
  bool is_general_ = false;
  Quat orientation_ = Quat::Identity();
  Vec3 angular_velocity_radps_ = Vec3::Zero();
  ClosedRotation closed_;                     ///< unless general
  std::unique_ptr<GeneralRotation> general_;  ///< kept while other kinds are followed
};

/// Returns centre of mass and orientation. REQUIRES: the track follows this flight.
inline Pose pose_at(const FreeFlight& flight, RotationTrack& track, Tick t) {
  return {.position_m = position_at(flight, t), .orientation = track.orientation_at(t)};
}

/// REQUIRES: the track follows this flight.
inline Twist twist_at(const FreeFlight& flight, RotationTrack& track, Tick t) {
  return {.velocity_mps = velocity_at(flight, t),
          .angular_velocity_radps = track.angular_velocity_at(t)};
}

}  // namespace sleight::physics
