#include "worker/physics/motion/segment.h"

#include <algorithm>
#include <cmath>

#include "common/math/elementary.h"
#include "common/math/vector.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {
namespace {

/// Maximum rotation by the second term of a Magnus step. The step's error is about this rotation
/// times the angle of the step.
constexpr double k_second_term_rad = 1e-6;
/// Maximum number of steps. A ball that needs more steps has no predictable orientation.
constexpr double k_steps_max = 100'000;

Quat turned_unevenly(const Segment& segment, double s) {
  const Vec3& w = segment.flight.angular_velocity_radps;
  const Vec3& a = segment.angular_acceleration_radps2;
  // `turn_of_axis` is the same at every step, because a x (w + a s) = a x w.
  const Vec3 turn_of_axis = math::cross(a, w);
  const double size = math::norm(turn_of_axis);
  // If the axis turns by less than rounding, one step covers the whole time.
  const double straight = 0x1p-40 * math::norm(a) * math::norm(w);
  double steps = 1;
  if (size > straight) {
    const double step_s = math::pow(12 * k_second_term_rad / size, 1.0 / 3);
    steps = std::clamp(std::ceil(s / step_s), 1.0, k_steps_max);
  }
  const double h = s / steps;
  const Vec3 second = (h * h * h / 12) * turn_of_axis;
  Quat orientation = segment.flight.orientation;
  for (double step = 0; step < steps; ++step) {
    const Vec3 middle = w + ((step + 0.5) * h) * a;
    orientation =
        math::composed(math::quaternion_of_rotation_vector(h * middle + second), orientation);
  }
  return math::normalized(orientation);
}

}  // namespace

Quat orientation_of(const Segment& segment, const Inertia& inertia, Tick tick) {
  if (segment.mode == MotionMode::resting || tick == segment.flight.begin)
    return segment.flight.orientation;
  if (in_contact(segment)) return turned_unevenly(segment, seconds(tick - segment.flight.begin));
  return orientation_at(segment.flight, inertia, tick);
}

RotationBounds contact_rotation_bounds(const Segment& segment) {
  constexpr double k_more = 1 + 0x1p-30;
  const double change_radps2 = math::norm(segment.angular_acceleration_radps2) * k_more;
  const double fastest_radps = math::norm(segment.flight.angular_velocity_radps) * k_more +
                               change_radps2 * seconds(k_turning_contact_span);
  return {.angular_speed_radps = fastest_radps,
          .angular_acceleration_radps2 = change_radps2,
          .phase_rate_radps = fastest_radps};
}

Twist twist_of(const Segment& segment, const Inertia& inertia, Tick tick) {
  Twist twist{.velocity_mps = velocity_at(segment.flight, tick),
              .angular_velocity_radps = segment.flight.angular_velocity_radps};
  if (in_contact(segment)) {
    twist.angular_velocity_radps +=
        seconds(tick - segment.flight.begin) * segment.angular_acceleration_radps2;
  } else if (segment.mode == MotionMode::free) {
    twist.angular_velocity_radps = angular_velocity_at(segment.flight, inertia, tick);
  }
  return twist;
}

}  // namespace sleight::physics
