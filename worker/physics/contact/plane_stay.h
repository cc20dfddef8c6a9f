// Bodies that are no spheres and stay on a plane that doesn't move: when they begin to, and until
// when. How they move there: response/plane_motion.h. contact_events.h says who asks.
//
// Idea. What bounces on a plane by micrometres, with all that carries it near the plane, stays on
// it in the pose that it has: it is turned no more towards the plane and hangs above it by a
// bounce's height at most, as what rests does. Its motion is projected on what the plane allows.
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

/// A point of a body that is so near to a plane may carry it: what such a bounce rises to.
inline double near_plane_m(const SlowContacts& slow, const Vec3& gravity_mps2) {
  return k_settling_bounces * k_settling_bounces * bounce_m(slow, gravity_mps2);
}

/// How a body stays on a plane.
struct PlaneStay {
  Segment segment;
  Tick end = k_never;  ///< then all this is to be asked for again
  bool stands = false;
  bool brakes = false;     ///< it slides, and is going to stand or to roll
  std::uint32_t face = 0;  ///< of a static polyhedron, for who asked
};

/// What a body may stay on: a plane, or the face of a polyhedron.
struct Flat {
  Vec3 normal = Vec3::UnitZ();  ///< unit, outward
  double offset_m = 0;
  std::span<const Side> sides;       ///< of a face
  const FrictionMap* map = nullptr;  ///< of a plane that has one
};
/// REQUIRES: a plane or a static polyhedron or triangle; of a plane any face.
Flat flat_at(const StaticGeometry& statics, StaticId met, std::uint32_t face);
/// Which face of these has a normal; of a plane 0.
std::optional<std::uint32_t> face_met(const StaticGeometry& statics, StaticId met,
                                      const Vec3& normal);
/// Whether a point lies over it.
bool is_over(const Flat& flat, const Vec3& place_m);

/// A body that touches what is flat, from a tick on; nothing if it doesn't stay there. `now`: its
/// flight from then on, if it were free. REQUIRES: the body's supports are over the flat.
std::optional<PlaneStay> stay_on_plane(const BodyOnPlane& body, const FreeFlight& now,
                                       const Flat& flat, const SlowContacts& slow,
                                       const Vec3& gravity_mps2);

}  // namespace sleight::physics
