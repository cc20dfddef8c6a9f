#include "common/motion/segment.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "common/math/elementary.h"
#include "common/motion/fields.h"

namespace sleight::motion {
namespace {

using math::Quat;
using math::Vec3;

/// A step is so short that the second term of Magnus' expansion rotates by at most this. The
/// neglected terms are about this value times the step's angle.
constexpr double k_second_term_rad = 1e-6;
/// If the axis' relative turn is smaller than this, the axis counts as fixed. Rounding errors
/// exceed so small a turn.
constexpr double k_straight = 0x1p-40;

Quat turned(const Quat& orientation, const Vec3& w, const Vec3& a, double s) {
  // The turn is equal at every step, because a x (w + a s) does not depend on s.
  const Vec3 turn_of_axis = math::cross(a, w);
  const double size = math::norm(turn_of_axis);
  double steps = 1;
  if (size > k_straight * math::norm(a) * math::norm(w)) {
    const double step_s = math::pow(12 * k_second_term_rad / size, 1.0 / 3);
    steps = std::clamp(std::ceil(s / step_s), 1.0, k_turn_steps_max);
  }
  const double h = s / steps;
  const Vec3 second = (h * h * h / 12) * turn_of_axis;
  Quat q = orientation;
  for (double step = 0; step < steps; ++step) {
    const Vec3 middle = w + ((step + 0.5) * h) * a;
    q = math::composed(math::quaternion_of_rotation_vector(h * middle + second), q);
  }
  return math::normalized(q);
}

}  // namespace

bool operator==(const Segment& a, const Segment& b) {
  const auto is_same = [&](const auto& field) {
    return elements_of(a.*field.member) == elements_of(b.*field.member);
  };
  return std::apply([&](const auto&... fields) { return (is_same(fields) && ...); }, k_fields);
}

Vec3 position_at(const Segment& segment, double t_s) {
  const double s = t_s - segment.start_s;
  return segment.position_m + s * segment.velocity_mps + (0.5 * s * s) * segment.acceleration_mps2;
}

Vec3 velocity_at(const Segment& segment, double t_s) {
  return segment.velocity_mps + (t_s - segment.start_s) * segment.acceleration_mps2;
}

Quat orientation_at(const Segment& segment, double t_s) {
  const double s = t_s - segment.start_s;
  if (s == 0 || segment.mode == Mode::resting) return segment.orientation;
  return turned(segment.orientation, segment.angular_velocity_radps,
                segment.angular_acceleration_radps2, s);
}

double bow_m(const Segment& segment, double duration_s) {
  return math::norm(segment.acceleration_mps2) * duration_s * duration_s / 8;
}

}  // namespace sleight::motion
