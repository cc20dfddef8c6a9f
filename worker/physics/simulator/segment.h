// A piece of a body's motion between two events that change it: a closed function of time.
//
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>

#include "worker/physics/motion/free_flight.h"

namespace sleight::physics {

enum class MotionMode : std::uint8_t {
  free,     ///< flight: gravity alone acts
  sliding,  ///< a sphere on static geometry whose surface slips
  rolling,  ///< the same without slip
  resting   ///< doesn't move until it is woken
};

/// The centre of mass moves on a parabola in every mode. A body in flight turns freely; a sphere in
/// contact turns with a constant angular acceleration.
struct Segment {
  FreeFlight flight;
  Vec3 angular_acceleration_radps2 = Vec3::Zero();  ///< 0 in flight
  MotionMode mode = MotionMode::free;
};

}  // namespace sleight::physics
