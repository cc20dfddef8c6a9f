// Bodies of revolution that lie on a line of a plane and roll about this line.
//
// Internal to worker/physics/response. Thread safety: pure functions.
#pragma once

#include <optional>

#include "worker/physics/response/plane_motion.h"

namespace sleight::physics {

struct ContactLine {
  Vec3 along = Vec3::UnitX();   ///< unit: the axis's direction along the plane
  Vec3 across = Vec3::UnitY();  ///< n x along: the rolling direction
  double depth_m = 0;           ///< of the line below the centre
  double least_m = 0;           ///< ends of the line, along it from the foot of the centre
  double most_m = 0;
  double friction = 0;  ///< minimum over the line's supports
};

/// Returns the line, or nothing if the body doesn't lie on a line.
std::optional<ContactLine> line_of(const BodyOnPlane& body);

PlaneMotion rolling_motion(const BodyOnPlane& body, const ContactLine& line, const Twist& twist,
                           const Vec3& gravity_mps2);

}  // namespace sleight::physics
