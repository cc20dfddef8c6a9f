// A piece of a body's motion, between two events that change the motion: a closed function of time.
//
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>

#include "worker/physics/motion/free_flight.h"
#include "worker/physics/motion/rotation_bounds.h"
#include "worker/physics/motion/rotation_track.h"

namespace sleight::physics {

enum class MotionMode : std::uint8_t {
  free,     ///< flight: only gravity acts
  sliding,  ///< slips on static geometry
  rolling,  ///< rolls on static geometry without slip
  resting   ///< at rest until woken
};

/// The centre of mass follows a parabola in every mode. A body in flight turns freely. In contact,
/// the angular velocity changes linearly.
struct Segment {
  FreeFlight flight;
  Vec3 angular_acceleration_radps2 = Vec3::Zero();  ///< 0 in flight
  MotionMode mode = MotionMode::free;
};

/// Returns whether the body stays on static geometry.
inline bool in_contact(const Segment& segment) {
  return segment.mode == MotionMode::sliding || segment.mode == MotionMode::rolling;
}

/// Returns the rotation from the body's frame to the world's, at a tick of the segment. In contact,
/// the angular velocity is w + a s, and the rotation is computed by two terms of Magnus' expansion
/// (Magnus, Communications on Pure and Applied Mathematics 7, 1954). The time since the segment
/// began is divided into equal steps. In each step, the second term turns the body by at most 1e-6
/// rad. If the axis doesn't turn, the result is exact up to rounding. REQUIRES and cost: as for
/// orientation_at() in rotation_track.h.
Quat orientation_of(const Segment& segment, const Inertia& inertia, Tick tick);

/// Returns the twist in the world's frame. REQUIRES: as for orientation_of.
Twist twist_of(const Segment& segment, const Inertia& inertia, Tick tick);

/// Doesn't evaluate the rotation.
inline Twist twist_at_begin(const Segment& segment) {
  return {.velocity_mps = segment.flight.velocity_mps,
          .angular_velocity_radps = segment.flight.angular_velocity_radps};
}

/// Returns bounds for a segment in contact, valid while it lasts. REQUIRES: the body isn't a
/// sphere.
RotationBounds contact_rotation_bounds(const Segment& segment);

}  // namespace sleight::physics
