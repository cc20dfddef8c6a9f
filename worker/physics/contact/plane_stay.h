// Computes when a body that isn't a sphere begins to stay on a fixed plane, and when the stay ends.
// response/plane_motion.h computes the body's motion, and contact_events.h has the rules.
//
// Idea. If a body's bounces on a plane are only micrometres high and all points that carry the body
// are near the plane, the body stays in its current pose. The body isn't turned towards the plane,
// and hovers above the plane by at most the height of a bounce, as resting bodies do. The body's
// motion is projected onto the motions that the plane allows.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "worker/physics/contact/lasting_contact.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/response/plane_motion.h"
#include "worker/physics/shape/convex_polyhedron.h"

namespace sleight::physics {

/// A point of a body may carry the body if the point is within this distance of a plane. The
/// distance is the height of a bounce at k_settling_bounces times the slowest bounce's speed.
inline double near_plane_m(const SlowContacts& slow, const Vec3& gravity_mps2) {
  return k_settling_bounces * k_settling_bounces * bounce_m(slow, gravity_mps2);
}

struct PlaneStay {
  Segment segment;
  Tick end = k_never;  ///< the stay must be recomputed then
  bool stands = false;
  bool brakes = false;     ///< the body slides, and will stand or roll at `end`
  std::uint32_t face = 0;  ///< face of a static polyhedron, set by the caller
};

/// A plane, or the face of a polyhedron.
struct Flat {
  Vec3 normal = Vec3::UnitZ();  ///< unit, outward
  double offset_m = 0;
  std::span<const Side> sides;       ///< borders, if a face
  const FrictionMap* map = nullptr;  ///< friction map of a plane, if any
};
/// REQUIRES: `met` is a plane, a static polyhedron or a triangle. For a plane, `face` is ignored.
Flat flat_at(const StaticGeometry& statics, StaticId met, std::uint32_t face);
/// Returns the face that has this normal. For a plane, returns 0.
std::optional<std::uint32_t> face_met(const StaticGeometry& statics, StaticId met,
                                      const Vec3& normal);
/// Returns whether a point is above or below the flat surface, inside its borders.
bool is_over(const Flat& flat, const Vec3& place_m);

/// Returns how a body that touches a flat surface stays on it. Empty: the body doesn't stay. `now`
/// is the body's free flight from this tick on. REQUIRES: the body's supports are over the surface.
std::optional<PlaneStay> stay_on_plane(const BodyOnPlane& body, const FreeFlight& now,
                                       const Flat& flat, const SlowContacts& slow,
                                       const Vec3& gravity_mps2);

}  // namespace sleight::physics
