// Defines what contact_events.h requires of a table of bodies at an event.
//
// An engine wraps its table and the event in one object: an Event with the operations of
// SpheresAtEvent. If some bodies may not be spheres, the object also has those of AnyAtEvent.
// World::AtEvent has all operations (world_at_event.h). Marbles::AtEvent has the operations for
// spheres (marbles_contacts.cpp).
//
// Thread safety: none.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "worker/physics/contact/contact_state.h"
#include "worker/physics/contact/impact_noise.h"
#include "worker/physics/contact/lasting_contact.h"
#include "worker/physics/contact/plane_stay.h"
#include "worker/physics/contact/resting.h"
#include "worker/physics/response/contact_motion.h"
#include "worker/physics/response/rigid_impact.h"
#include "worker/physics/response/sphere_impact.h"
#include "worker/physics/scene/surface_law.h"

namespace sleight::physics::contact {

struct Event {
  Tick tick{};
  std::vector<BodyId>& changed;  ///< bodies that began a segment at the event
  Resting& resting;
  ContactScene scene;
  const ContactTable& contacts;
  bool may_stay = false;    ///< whether contact with static geometry can last
  TickCount alone_for = 0;  ///< a body stays only if it has met no other body for this long
};

/// A table of bodies at an event. All operations refer to body `b` at the event's tick.
template <class T>
concept SpheresAtEvent = std::derived_from<T, Event> &&
    requires(T& at, BodyId b, BodyId other, const Twist& twist, const Segment& segment,
             const TouchRecord& touch, std::span<const LastingContact> contacts, double gap_m) {
  // Constant properties of a body.
  { at.body(b).reach_m } -> std::convertible_to<double>;
  { at.body(b).inertia } -> std::convertible_to<const Inertia&>;
  { at.body(b).sphere_mass } -> std::convertible_to<const SphereMass&>;
  { at.body(b).material } -> std::convertible_to<MaterialId>;
  { at.round_body(b) } -> std::convertible_to<RoundBody>;

  // The current motion, and the supports of a body that stays on static geometry.
  { at.mode(b) } -> std::same_as<MotionMode>;
  { at.place_m(b) } -> std::convertible_to<Vec3>;
  { at.twist(b) } -> std::same_as<Twist>;
  { at.supports(b) } -> std::same_as<Supports&>;
  // Whether a sphere that stands still on the contacts stays at rest (stands_on()).
  { at.stands(b, contacts) } -> std::same_as<bool>;

  // The next motion. flight_after() returns the free flight that begins with the twist.
  // begin_after() and begin_segment() add the body to `changed` and clear its supports.
  { at.flight_after(b, twist) } -> std::same_as<FreeFlight>;
  at.begin_after(b, twist);
  at.begin_segment(b, segment);

  { at.count(b) } -> std::same_as<const CollisionCount&>;
  // Records the gap of a colliding pair.
  at.meets(b, other, gap_m);
  // Records a touch of b for rest decisions.
  at.touches(b, touch, bool{});

  // goes_live() notes that causes outside b's history may change b from now on.
  at.goes_live(b);
  // For histories, reads() notes that the event's result for b depends on the other body's state.
  at.reads(b, other);
  // For histories, learns() notes that b's contact state changes, and not only by a touch.
  at.learns(b);
};

/// A table in which some bodies may not be spheres, or may be fixed.
template <class T>
concept AnyAtEvent = SpheresAtEvent<T> &&
    requires(T& at, BodyId b, StaticId met, std::uint32_t face, const Twist& twist) {
  { at.body(b).is_sphere } -> std::convertible_to<bool>;
  { at.body(b).has_round_parts } -> std::convertible_to<bool>;
  { at.body(b).fixed } -> std::convertible_to<bool>;
  { at.rigid_body(b) } -> std::same_as<RigidImpactBody>;
  // How a body with this twist would stay on a face of static geometry. Empty: it doesn't stay.
  { at.lying(b, met, face, twist) } -> std::same_as<std::optional<PlaneStay>>;
  // Returns the noise of the impact that the event is, and counts it. Empty: it has none.
  { at.take_noise() } -> std::same_as<std::optional<ImpactNoise>>;
  // Records all corners that carry the body, not only those that collided (Resting::still_touches).
  at.notes_corners(b);
};

// ---- what follows from it -----------------------------------------------------------------------

template <SpheresAtEvent At>
bool is_round(At& at, BodyId body) {
  if constexpr (AnyAtEvent<At>) return at.body(body).is_sphere;
  return true;
}

template <SpheresAtEvent At>
bool is_resting(At& at, BodyId body) {
  return at.mode(body) == MotionMode::resting;
}

template <SpheresAtEvent At>
bool is_fixed(At& at, BodyId body) {
  if constexpr (AnyAtEvent<At>) return at.body(body).fixed;
  return false;
}

template <SpheresAtEvent At>
double fastest_point_mps(At& at, BodyId body, const Twist& twist) {
  return physics::fastest_point_mps(at.body(body).reach_m, twist);
}

/// Returns the pose of a body on which others may rest. For a sphere, the orientation doesn't
/// matter: it is the identity.
template <SpheresAtEvent At>
Pose place_of_rest(At& at, BodyId body) {
  if constexpr (AnyAtEvent<At>) {
    if (!is_round(at, body)) return at.rigid_body(body).pose;
  }
  return {at.place_m(body), Quat::Identity()};
}

template <SpheresAtEvent At>
LastingContact lasting_contact(At& at, BodyId body, FeatureId feature) {
  const StaticGeometry& statics = at.scene.statics;
  const SurfaceLaw& law =
      at.contacts.between(at.body(body).material, statics.material_of_feature(feature));
  const auto& place_m = at.place_m(body);
  return {.normal = normal_at(statics.feature(feature), place_m),
          .friction = statics.friction_at({feature}, place_m, law.friction),
          .rolling_friction = law.rolling_friction};
}

/// Returns the first tick at which a body in lasting contact is slow enough for rest.
template <SpheresAtEvent At>
Tick slow_from(At& at, BodyId body, const Segment& segment, Tick end) {
  return physics::slow_from(segment, at.body(body).reach_m, at.body(body).inertia, at.scene.slow,
                            end);
}

template <SpheresAtEvent At>
void begin_rest(At& at, BodyId body) {
  Segment segment{.flight = at.flight_after(body, {}), .mode = MotionMode::resting};
  segment.flight.acceleration_mps2 = Vec3::Zero();
  at.begin_segment(body, segment);
  at.resting.rests_at(body, at.place_m(body));
}

}  // namespace sleight::physics::contact
