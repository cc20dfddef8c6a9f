// A piece of a body's motion between two events that change it: a closed function of time.
//
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>

#include "worker/physics/motion/free_flight.h"
#include "worker/physics/motion/rotation_bounds.h"
#include "worker/physics/motion/rotation_track.h"

namespace sleight::physics {

enum class MotionMode : std::uint8_t {
  free,     ///< flight: gravity alone acts
  sliding,  ///< on static geometry, on which it slips
  rolling,  ///< the same without slip
  resting   ///< doesn't move until it is woken
};

/// The centre of mass moves on a parabola in every mode. A body in flight turns freely; the angular
/// velocity of one in contact changes evenly.
struct Segment {
  FreeFlight flight;
  Vec3 angular_acceleration_radps2 = Vec3::Zero();  ///< 0 in flight
  MotionMode mode = MotionMode::free;
};

/// Whether a body stays on static geometry.
inline bool in_contact(const Segment& segment) {
  return segment.mode == MotionMode::sliding || segment.mode == MotionMode::rolling;
}

/// From the body's frame to the world's, at a tick of the segment. In contact, where the angular
/// velocity is w + a s, by Magnus' expansion to its second term (W. Magnus, Comm. Pure Appl. Math.
/// 7, 1954) over equal parts of the time since the segment began, short enough for 1e-6 rad: exact
/// but for rounding if the axis doesn't turn.
/// REQUIRES, cost: as for orientation_at of rotation_track.h.
Quat orientation_of(const Segment& segment, const Inertia& inertia, Tick tick);

/// In the world's frame. REQUIRES: the same.
Twist twist_of(const Segment& segment, const Inertia& inertia, Tick tick);

/// Without a look at its turn.
inline Twist twist_at_begin(const Segment& segment) {
  return {.velocity_mps = segment.flight.velocity_mps,
          .angular_velocity_radps = segment.flight.angular_velocity_radps};
}

/// Of a segment in contact, of a body that is no sphere, while it lasts.
RotationBounds contact_rotation_bounds(const Segment& segment);

}  // namespace sleight::physics
