#include "worker/physics/response/plane_rolling.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/math/elementary.h"
#include "common/math/vector.h"
#include "worker/physics/event/tick.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/response/contact_motion.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

bool carries(const ContactLine& line, double place_m) {
  return place_m >= line.least_m && place_m <= line.most_m;
}

/// Returns the motion of a body whose axis is parallel to the plane.
PlaneMotion cylinder_motion(const BodyOnPlane& body, const ContactLine& line, const Twist& twist,
                            const Vec3& gravity_mps2) {
  const double load_mps2 = -dot(gravity_mps2, body.normal);
  const double along_mps2 = dot(gravity_mps2, line.along);
  if (!carries(line, line.depth_m * along_mps2 / load_mps2)) return {};
  const double moment = dot(body.axis, math::product(body.inertia_kgm2, body.axis));
  const RoundBody round{.radius_m = line.depth_m,
                        .gyration = moment / (body.mass_kg * line.depth_m * line.depth_m),
                        .stick_mps = body.stick_mps};
  const LastingContact contact{
      .normal = body.normal, .friction = line.friction, .rolling_friction = body.rolling_friction};
  const Twist across{
      .velocity_mps = dot(twist.velocity_mps, line.across) * line.across,
      .angular_velocity_radps = dot(twist.angular_velocity_radps, body.axis) * line.along};
  const Vec3 pull_mps2 = gravity_mps2 - along_mps2 * line.along;
  const ContactMotion motion = contact_motion(round, {&contact, 1}, across, pull_mps2);
  if (motion.pressed == 0) return {};
  // If the body rolls, friction must also keep it from sliding along its axis.
  const Vec3 friction_mps2 =
      motion.acceleration_mps2 - (pull_mps2 + load_mps2 * body.normal) - along_mps2 * line.along;
  const bool holds = motion.rolls && norm(friction_mps2) <= line.friction * load_mps2;
  if (!holds && std::fabs(along_mps2) > k_level_pull * load_mps2) return {};
  PlaneMotion result{
      .carried = true,
      .brakes = !motion.rolls && line.friction > 0,
      .on_line = true,
      .mode = motion.rolls ? MotionMode::rolling : MotionMode::sliding,
      .start = {.velocity_mps = motion.start.velocity_mps,
                .angular_velocity_radps =
                    dot(motion.start.angular_velocity_radps, line.along) * body.axis},
      .acceleration_mps2 = motion.acceleration_mps2,
      .angular_acceleration_radps2 =
          dot(motion.angular_acceleration_radps2, line.along) * body.axis,
      .lasts_s = motion.lasts_s};
  if (motion.rolls && norm(result.start.velocity_mps) <= body.stick_mps &&
      norm(result.acceleration_mps2) <= k_level_pull * load_mps2) {
    result.stands = true;
    result.start = {};
    result.acceleration_mps2 = result.angular_acceleration_radps2 = Vec3::Zero();
    result.lasts_s = k_forever_s;
  }
  return result;
}

/// Returns the motion of a body with an inclined axis, which rolls in a circle on a level plane.
PlaneMotion cone_motion(const BodyOnPlane& body, const ContactLine& line, const Twist& twist,
                        const Vec3& gravity_mps2) {
  const Vec3& n = body.normal;
  const double load_mps2 = -dot(gravity_mps2, n);
  if (norm(gravity_mps2 + load_mps2 * n) > k_level_pull * load_mps2 || line.friction == 0)
    return {};
  // If the body rolls at a rate w about the line, its centre moves at -w depth_m along `across`.
  const Vec3 momentum_of_turn = math::product(body.inertia_kgm2, line.along);
  const double moment = dot(line.along, momentum_of_turn);
  const double whole = body.mass_kg * line.depth_m * line.depth_m + moment;
  double rate_radps = (dot(twist.angular_velocity_radps, momentum_of_turn) -
                       body.mass_kg * line.depth_m * dot(twist.velocity_mps, line.across)) /
                      whole;
  PlaneMotion result{.carried = true, .on_line = true, .mode = MotionMode::rolling};
  // Interpolated velocities are smaller than the velocities at the ends: on average, by a share of
  // angle^2 / 12.
  constexpr double k_mean = 1 - k_cone_piece_rad * k_cone_piece_rad / 12;
  const double circles = -dot(body.axis, n) / dot(body.axis, line.along);
  const double lasts_s = k_cone_piece_rad / (k_mean * std::fabs(circles * rate_radps));
  // Rolling resistance reduces the rate once, at the piece's start. If the rate changed during the
  // piece, the axis could not follow it.
  const double brake_radps2 =
      body.rolling_friction * body.mass_kg * load_mps2 * line.depth_m / whole;
  const double left_radps = std::fabs(rate_radps) - brake_radps2 * lasts_s;
  if (!(left_radps * line.depth_m > body.stick_mps)) {
    result.stands = true;
    if (!carries(line, 0)) result.carried = false;
    return result;
  }
  rate_radps = std::copysign(left_radps, rate_radps);
  const double circling_radps = circles * rate_radps;
  // Compute the centripetal acceleration, and the gyroscopic moment divided by the weight.
  const double inwards_mps2 = rate_radps * line.depth_m * circling_radps;
  const double gyration_m = circling_radps * rate_radps * moment / (body.mass_kg * load_mps2);
  if (std::fabs(inwards_mps2) > line.friction * load_mps2 ||
      !carries(line, -gyration_m - line.depth_m * inwards_mps2 / load_mps2))
    return {.carried = false};
  const math::SinCos turn = math::sincos(k_mean * circling_radps * lasts_s);
  result.start = {.velocity_mps = -(rate_radps * line.depth_m) * line.across,
                  .angular_velocity_radps = rate_radps * line.along};
  const auto change_of = [&](const Vec3& v) {
    return Vec3(((turn.cos - 1) * v + turn.sin * cross(n, v)) / lasts_s);
  };
  result.acceleration_mps2 = change_of(result.start.velocity_mps);
  result.angular_acceleration_radps2 = change_of(result.start.angular_velocity_radps);
  result.lasts_s = lasts_s;
  return result;
}

}  // namespace

std::optional<ContactLine> line_of(const BodyOnPlane& body) {
  const Vec3& n = body.normal;
  const Vec3 level = body.axis - dot(body.axis, n) * n;
  const double lies = norm(level);
  if (!(lies > k_line_sine_min)) return std::nullopt;
  ContactLine line{.along = level / lies};
  line.across = cross(n, line.along);
  line.least_m = line.friction = std::numeric_limits<double>::infinity();
  line.most_m = -std::numeric_limits<double>::infinity();
  for (const PlaneSupport& support : body.supports) {
    const Vec3& arm_m = support.arm_m;
    if (std::fabs(dot(line.across, arm_m)) > k_line_width * norm(arm_m)) return std::nullopt;
    const double place_m = dot(line.along, arm_m);
    line.least_m = std::min(line.least_m, place_m);
    line.most_m = std::max(line.most_m, place_m);
    line.depth_m = std::max(line.depth_m, -dot(n, arm_m));
    line.friction = std::min(line.friction, support.friction);
  }
  if (!(line.depth_m > 0) || !(line.most_m > line.least_m)) return std::nullopt;
  return line;
}

PlaneMotion rolling_motion(const BodyOnPlane& body, const ContactLine& line, const Twist& twist,
                           const Vec3& gravity_mps2) {
  return std::fabs(dot(body.axis, body.normal)) < k_cylinder_rise_max
             ? cylinder_motion(body, line, twist, gravity_mps2)
             : cone_motion(body, line, twist, gravity_mps2);
}

}  // namespace sleight::physics
