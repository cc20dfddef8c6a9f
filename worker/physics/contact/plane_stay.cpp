#include "worker/physics/contact/plane_stay.h"

#include <algorithm>
#include <cmath>

#include "common/math/vector.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

/// The plane removes a part of the body's motion. Returns whether this part is at most the motion
/// of a slow bounce. Tests the normal velocity at each support. If the body touches along a line,
/// also tests the slip along the line and the turn about the normal.
bool settles(const BodyOnPlane& body, const FreeFlight& now, const PlaneMotion& motion,
             double bounce_mps) {
  const Vec3 off_mps = now.velocity_mps - motion.start.velocity_mps;
  const Vec3 off_radps = now.angular_velocity_radps - motion.start.angular_velocity_radps;
  return std::ranges::all_of(body.supports, [&](const PlaneSupport& support) {
    const Vec3 off = off_mps + cross(off_radps, support.arm_m);
    const double up = dot(off, body.normal);
    return std::fabs(up) <= k_settling_bounces * bounce_mps &&
           (!motion.on_line || norm(off - up * body.normal) <= bounce_mps);
  });
}

}  // namespace

Flat flat_at(const StaticGeometry& statics, StaticId met, std::uint32_t face) {
  if (met < statics.plane_count()) {
    const HalfSpace& plane = statics.plane({met});
    return {.normal = plane.normal,
            .offset_m = plane.offset_m,
            .sides = {},
            .map = statics.friction_map(met)};
  }
  const ConvexView& view = *statics.piece({met}).view;
  const Face& one = view.faces[face];
  return {.normal = one.normal,
          .offset_m = one.offset_m,
          .sides = std::span(view.sides + one.first_side, one.side_count)};
}

std::optional<std::uint32_t> face_met(const StaticGeometry& statics, StaticId met,
                                      const Vec3& normal) {
  if (met < statics.plane_count()) return 0;
  constexpr double k_same_cosine = 1 - 1e-9;  // tolerance for rounding
  const ConvexView& view = *statics.piece({met}).view;
  for (std::uint32_t face = 0; face < view.face_count; ++face) {
    if (math::dot(view.faces[face].normal, normal) > k_same_cosine) return face;
  }
  return std::nullopt;
}

bool is_over(const Flat& flat, const Vec3& place_m) {
  return std::ranges::all_of(
      flat.sides, [&](const Side& side) { return dot(side.inward, place_m) - side.offset_m >= 0; });
}

std::optional<PlaneStay> stay_on_plane(const BodyOnPlane& body, const FreeFlight& now,
                                       const Flat& flat, const SlowContacts& slow,
                                       const Vec3& gravity_mps2) {
  const PlaneMotion motion = plane_motion(
      body,
      {.velocity_mps = now.velocity_mps, .angular_velocity_radps = now.angular_velocity_radps},
      gravity_mps2);
  if (!motion.carried || !settles(body, now, motion, slow.separation_speed_mps))
    return std::nullopt;
  PlaneStay stay{.segment = {.flight = now,
                             .angular_acceleration_radps2 = motion.angular_acceleration_radps2,
                             .mode = motion.mode},
                 .end = tick_after(now.begin, motion.lasts_s),
                 .stands = motion.stands,
                 .brakes = motion.brakes};
  FreeFlight& flight = stay.segment.flight;
  flight.velocity_mps = motion.start.velocity_mps;
  flight.angular_velocity_radps = motion.start.angular_velocity_radps;
  flight.acceleration_mps2 = motion.acceleration_mps2;
  if (!is_zero(motion.angular_acceleration_radps2))
    stay.end = std::min(stay.end, now.begin + k_turning_contact_span);
  if (motion.stands) return stay;
  // A rolling body's contact points change, but its whole line of contact moves with the centre.
  const bool turns = motion.mode == MotionMode::sliding;
  const Vec3 turn_radps = turns ? flight.angular_velocity_radps : Vec3(Vec3::Zero());
  const Vec3 turn_radps2 = turns ? motion.angular_acceleration_radps2 : Vec3(Vec3::Zero());
  for (const PlaneSupport& support : body.supports) {
    const Vec3 slip = cross(turn_radps, support.arm_m);
    const MapPath path{
        .place_m = flight.position_m + support.arm_m,
        .velocity_mps = flight.velocity_mps + slip,
        .acceleration_mps2 =
            flight.acceleration_mps2 + cross(turn_radps2, support.arm_m) + cross(turn_radps, slip)};
    if (flat.map != nullptr)
      stay.end = std::min(stay.end, meets_border(*flat.map, path, now.begin, stay.end));
    for (const Side& side : flat.sides) {
      const double leaves_s = first_fall_s(
          std::max(0.0, dot(side.inward, path.place_m) - side.offset_m),
          dot(side.inward, path.velocity_mps), dot(side.inward, path.acceleration_mps2));
      stay.end = std::min(stay.end, tick_after(now.begin, leaves_s));
    }
  }
  return stay;
}

}  // namespace sleight::physics
