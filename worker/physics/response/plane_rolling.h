// Bodies of revolution that lie on a line of a plane and roll about it.
//
// Internal to worker/physics/response. Thread safety: pure functions.
#pragma once

#include <optional>

#include "worker/physics/response/plane_motion.h"

namespace sleight::physics {

/// The line on which a body of revolution lies.
struct ContactLine {
  Vec3 along = Vec3::UnitX();   ///< unit: the axis's direction along the plane
  Vec3 across = Vec3::UnitY();  ///< n x along: that way it rolls
  double depth_m = 0;           ///< of the line below the centre
  double least_m = 0;           ///< its ends, along it from the centre's foot
  double most_m = 0;
  double friction = 0;  ///< the least of its supports
};

/// None if it doesn't lie so.
std::optional<ContactLine> line_of(const BodyOnPlane& body);

PlaneMotion rolling_motion(const BodyOnPlane& body, const ContactLine& line, const Twist& twist,
                           const Vec3& gravity_mps2);

}  // namespace sleight::physics
