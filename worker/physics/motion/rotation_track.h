// The orientation and angular velocity of a body in free flight, at any tick.
//
// Idea. Spherical and axially symmetric bodies have closed forms (closed_rotation.h). A general
// body is integrated by fixed steps from its flight's own start (general_rotation.h), which makes
// a question at a late tick dear; a RotationTrack keeps the current step, so that questions in
// about the order of time are cheap.
//
// Invariants
//   1. The functions without a track are pure, and a track returns the same bits as they do,
//      whatever it was asked before.
//   2. Only ticks since begin enter (free_flight.h, invariant 2); at begin, what the flight holds.
//   3. Where moments coincide, the closed forms agree with the general steps up to rounding;
//      an axial body with three equal moments has the bits of a spherical one.
// Accuracy: closed forms are within 2^-50 (4 + angle) of exact, where the angle is what turned
// since begin; general ones keep energy and angular momentum to 1e-14 or so over 1,000
// revolutions.
// Thread safety: pure functions; one RotationTrack is not shared between threads.
#pragma once

#include <memory>

#include "worker/physics/motion/closed_rotation.h"
#include "worker/physics/motion/general_rotation.h"

namespace sleight::physics {

/// From the body's frame to the world's. REQUIRES: t <= rotation_horizon, and for a general body
/// t >= begin. Cost: 40 ns spherical, 60 ns axial; a general body's grows with t - begin, 0.4 us
/// for each eighth to quarter radian.
Quat orientation_at(const FreeFlight& flight, const Inertia& inertia, Tick t);

/// In the world's frame. REQUIRES, cost: the same.
Vec3 angular_velocity_at(const FreeFlight& flight, const Inertia& inertia, Tick t);

/// The latest tick at which a flight's rotation may be asked for, at most k_tick_max; the flight's
/// begin if it is too fast. Whoever begins a flight of a general body asks this and ends in a typed
/// error what would fly beyond it: GeneralRotation::k_steps_max steps, over 131,000 rad (22 minutes
/// at 100 rad/s).
Tick rotation_horizon(const FreeFlight& flight, const Inertia& inertia);

/// One body's current flight. Small for bodies with closed forms; a general one allocates its steps
/// once, 1.3 kB, and restart() uses them again.
class RotationTrack {
 public:
  RotationTrack() = default;
  RotationTrack(const FreeFlight& flight, const Inertia& inertia) { restart(flight, inertia); }

  /// Follows another flight.
  /// REQUIRES: moments > 0 and as equal as the symmetry says; orientation of norm 1; all finite.
  void restart(const FreeFlight& flight, const Inertia& inertia);

  /// What rotation_horizon gives.
  Tick horizon() const;

  /// What the functions above give, and as they REQUIRE.
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

/// Centre of mass and orientation at once. REQUIRES: the track follows this flight.
inline Pose pose_at(const FreeFlight& flight, RotationTrack& track, Tick t) {
  return {.position_m = position_at(flight, t), .orientation = track.orientation_at(t)};
}

/// REQUIRES: the same.
inline Twist twist_at(const FreeFlight& flight, RotationTrack& track, Tick t) {
  return {.velocity_mps = velocity_at(flight, t),
          .angular_velocity_radps = track.angular_velocity_at(t)};
}

}  // namespace sleight::physics
