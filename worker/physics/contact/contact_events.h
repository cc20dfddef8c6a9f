// What collisions, lasting contact and rest do to bodies: the rules of contact, over any table of
// bodies.
//
// Idea. Two engines have bodies in tables of their own (world.h, marbles.h). What happens to the
// bodies at an event is the same, so it stands here once, as functions over either table
// (bodies_at_event.h).
//
// Everything is a function of the table's state at the event, so both engines do the same, bit for
// bit. Their tests compare what they do with physics and with kept hashes.
// Thread safety: none.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/contact/bodies_at_event.h"
#include "worker/physics/contact/contact_state.h"
#include "worker/physics/contact/lasting_contact.h"
#include "worker/physics/contact/plane_stay.h"
#include "worker/physics/contact/resting.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/response/contact_motion.h"
#include "worker/physics/response/rigid_impact.h"
#include "worker/physics/response/sphere_impact.h"

namespace sleight::physics::contact {

// ---- laws ---------------------------------------------------------------------------------------

/// The law of an impact of two materials: plastic after too many at one tick.
inline ContactLaw law_of_impact(double restitution, double friction, const SlowContacts& slow,
                                bool plastic) {
  if (plastic) return {.restitution = 0, .friction = friction};
  return {.restitution = restitution,
          .friction = friction,
          .separation_speed_floor_mps = slow.separation_speed_mps};
}

/// How fast the two sides of a contact part, at arms from the bodies' centres.
inline double parting_mps(const Vec3& normal, const Vec3& arm_a_m, const Twist& a,
                          const Vec3& arm_b_m, const Twist& b) {
  const Vec3 of_a = a.velocity_mps + math::cross(a.angular_velocity_radps, arm_a_m);
  const Vec3 of_b = b.velocity_mps + math::cross(b.angular_velocity_radps, arm_b_m);
  return math::dot(normal, of_b - of_a);
}

/// What a sphere that rolls leaves an edge or a resting body with.
inline double hop_speed_mps(const SlowContacts& slow) {
  return k_hop_share * slow.separation_speed_mps;
}

// ---- impacts ------------------------------------------------------------------------------------

/// Two bodies collide; what is fixed counts as static geometry.
template <SpheresAtEvent At>
ImpactOutput impact(At& at, BodyId a, BodyId b, const PieceContact& contact, const ContactLaw& law,
                    bool a_fixed, bool b_fixed) {
  if constexpr (AnyAtEvent<At>) {
    if (!is_round(at, a) || !is_round(at, b)) {
      return rigid_impact({.a = a_fixed ? RigidImpactBody{} : at.rigid_body(a),
                           .b = b_fixed ? RigidImpactBody{} : at.rigid_body(b),
                           .contact_m = contact.point_m,
                           .normal = contact.normal,
                           .law = law});
    }
  }
  return sphere_impact({.mass_a = a_fixed ? SphereMass{} : at.body(a).sphere_mass,
                        .mass_b = b_fixed ? SphereMass{} : at.body(b).sphere_mass,
                        .a = at.twist(a),
                        .b = at.twist(b),
                        .normal = contact.normal,
                        .law = law});
}

/// A body's twist after it collides with static geometry.
template <SpheresAtEvent At>
Twist impact_on_static(At& at, BodyId body, const Twist& before, const PieceContact& contact,
                       const ContactLaw& law) {
  if constexpr (AnyAtEvent<At>) {
    if (!is_round(at, body)) {
      return rigid_impact({.a = {},
                           .b = at.rigid_body(body),
                           .contact_m = contact.point_m,
                           .normal = contact.normal,
                           .law = law})
          .b;
    }
  }
  return sphere_impact({.mass_a = {},
                        .mass_b = at.body(body).sphere_mass,
                        .a = {},
                        .b = before,
                        .normal = contact.normal,
                        .law = law})
      .b;
}

/// As a body leaves what doesn't move: what is round and rolls hops, as it has no slip to pay its
/// bounces from.
template <SpheresAtEvent At>
Twist leaving(At& at, BodyId body, const PieceContact& contact, const Twist& twist) {
  const double speed_mps = hop_speed_mps(at.scene.slow);
  if constexpr (AnyAtEvent<At>) {
    if (!is_round(at, body)) {
      if (!at.body(body).has_round_parts) return twist;
      RigidImpactBody leaver = at.rigid_body(body);
      leaver.twist = twist;
      return rigid_hop(leaver, contact.point_m, contact.normal, speed_mps);
    }
  }
  return hop(at.round_body(body), contact.normal, twist, speed_mps);
}

// ---- who wakes ----------------------------------------------------------------------------------

/// A resting body wakes where it is, because of another one.
template <SpheresAtEvent At>
void wake_in_place(At& at, BodyId body, BodyId because) {
  at.goes_live(body);
  at.reads(because, body);
  at.learns(body);
  at.begin_after(body, {});
  at.resting.woke(body, at.tick, place_of_rest(at, body));
}

/// A body moves: what rested on it wakes.
template <SpheresAtEvent At>
void wake_dependents(At& at, BodyId body) {
  for (const BodyId dependent : at.resting.wake(body)) {
    if (is_resting(at, dependent)) {
      wake_in_place(at, dependent, body);
    } else {
      at.goes_live(dependent);
      at.learns(dependent);
    }
  }
}

/// Whether a body that woke without a blow has left the place in which others rest on it.
template <SpheresAtEvent At>
bool has_left(At& at, BodyId body) {
  if (!at.resting.in_place(body)) return false;
  return at.resting.has_left(body, place_of_rest(at, body),
                             fastest_point_mps(at, body, at.twist(body)));
}

/// What rested on those whose motion has changed, and that have left their places, wakes.
template <SpheresAtEvent At>
void wake_on_those_that_left(At& at) {
  // The list grows by the bodies that wake; these are still in their places.
  for (std::size_t i = 0; i < at.changed.size(); ++i) {
    const BodyId body = at.changed[i];
    if (is_resting(at, body) || !has_left(at, body)) continue;
    at.learns(body);
    at.resting.leave(body);
    wake_dependents(at, body);
  }
  if (at.changed.size() > 1) std::sort(at.changed.begin(), at.changed.end());
}

// ---- lasting contact of spheres -----------------------------------------------------------------

// A sphere loses its bounce on a face where that would be slower than separation_speed_mps, and
// stays there if gravity presses it on: on a face, in a valley of two, in a corner of three. Over
// an edge it hops while it is fast (contact_motion.h), and then goes round it piece by piece
// (edge_motion.h). Vertices, and edges beside something else, it takes for faces as long as it
// doesn't move by more than some micrometres: so it comes to rest between a face and an edge.
//
// Only a sphere that has met no other body for some bounces stays. One that leans on another body
// goes on bouncing from both: if it stayed on the face, nothing would be left to part it from the
// other body, and the two would collide without time passing.

/// Up to three features, and a sphere's contacts with them.
struct FewContacts {
  std::array<FeatureId, 3> features{};
  std::array<LastingContact, 3> contacts;
  std::size_t count = 0;
  void add(FeatureId feature, const LastingContact& contact) {
    contacts[count] = contact;
    features[count++] = feature;
  }
  std::span<const LastingContact> all() const { return std::span(contacts).first(count); }
  MayStayOn first(std::size_t some, bool rolled) const {
    return {.features = std::span(features).first(some),
            .contacts = std::span(contacts).first(some),
            .rolled = rolled};
  }
};

/// Whether a sphere that meets something so slowly loses its bounce there, and may stay.
template <SpheresAtEvent At>
bool is_caught(At& at, BodyId body, StaticId met, double approach_mps, double restitution,
               const Twist& twist) {
  if (!at.may_stay || !is_round(at, body) ||
      at.body(body).inertia.symmetry != InertiaSymmetry::spherical)
    return false;
  const double slow_mps = at.scene.slow.separation_speed_mps;
  if (restitution * approach_mps >= slow_mps || at.tick - at.supports(body).met_body < at.alone_for)
    return false;
  return at.scene.statics.feature({met}).kind == FeatureKind::face ||
         math::norm(twist.velocity_mps) < k_edge_speeds * slow_mps;
}

/// A sphere with such a twist goes on from what it touches: it stays on those that carry it, if any
/// do, or flies with the other one.
template <SpheresAtEvent At>
void begin_on_faces(At& at, BodyId body, const MayStayOn& on, const Twist& twist,
                    const Twist& otherwise) {
  const auto stay = stay_on(at.round_body(body), on, at.flight_after(body, twist), at.scene);
  at.learns(body);
  if (!stay) {
    at.resting.flies(body, at.tick);
    at.begin_after(body, otherwise);
    return;
  }
  at.begin_segment(body, stay->segment);
  Supports& kept = at.supports(body);
  for (std::size_t i = 0; i < on.features.size(); ++i) {
    if ((stay->subset >> i & 1U) != 0) kept.features[kept.count++] = {on.features[i]};
  }
  kept.end = stay->end;
  kept.leaves = stay->leaves;
  kept.half_way = stay->half_way;
  if (at.resting.enabled())
    at.resting.stays(body, at.tick, slow_from(at, body, stay->segment, kept.end));
}

/// The same when it has just lost its bounce on `feature`.
template <SpheresAtEvent At>
void begin_caught(At& at, BodyId body, FeatureId feature, const Twist& twist) {
  FewContacts few;
  few.add(feature, lasting_contact(at, body, feature));
  for (const StaticId met : at.supports(body).all()) {
    const FeatureId other{met};
    if (other != feature && few.count < few.features.size())
      few.add(other, lasting_contact(at, body, other));
  }
  const Caught caught = caught_by(at.round_body(body), few.all(), twist, at.scene.slow);
  begin_on_faces(at, body, few.first(caught.count, false), caught.twist, caught.otherwise);
}

// ---- lasting contact of other bodies ------------------------------------------------------------

// What is no sphere stays on what is flat when what carries it bounces there by no more than slow
// bounces do (plane_stay.h), under the same conditions: its own bounce would be slower than
// separation_speed_mps, and it has met no other body for some bounces, nor two static pieces one
// soon after the other: what leans on both would be pressed into one while it stays on the other.

/// A body begins to stay on what is flat, or goes on to.
template <AnyAtEvent At>
void begin_lying(At& at, BodyId body, StaticId index, const PlaneStay& stay) {
  at.learns(body);
  at.begin_segment(body, stay.segment);
  Supports& kept = at.supports(body);
  kept.features[0] = index;
  kept.face = stay.face;
  kept.count = 1;
  kept.end = stay.end;
  kept.leaves = Stay::k_none;
  kept.half_way = Vec3::Zero();
  if (!at.resting.enabled()) return;
  // What friction brakes comes to a stop by itself.
  const Tick slow = stay.brakes ? k_never : slow_from(at, body, stay.segment, stay.end);
  at.resting.stays(body, at.tick, slow);
}

/// How a body that collides with what is flat stays there, if it does.
template <AnyAtEvent At>
std::optional<PlaneStay> settling(At& at, BodyId body, StaticId index, const PieceContact& contact,
                                  double restitution, const Twist& twist) {
  if (is_round(at, body) || !at.may_stay || index >= at.scene.statics.piece_count())
    return std::nullopt;
  Supports& supports = at.supports(body);
  supports.hits(index, at.tick, at.alone_for);
  if (restitution * -contact.rate_mps >= at.scene.slow.separation_speed_mps ||
      at.tick - supports.met_body < at.alone_for || at.tick - supports.hit_both < at.alone_for)
    return std::nullopt;
  const auto face = face_met(at.scene.statics, index, contact.normal);
  return face ? at.lying(body, index, *face, twist) : std::nullopt;
}

/// Its mode event: it goes on otherwise, or is carried no more.
template <AnyAtEvent At>
void change_lying(At& at, BodyId body) {
  const Twist twist = at.twist(body);
  const StaticId index = at.supports(body).features[0];
  const std::uint32_t face = at.supports(body).face;
  if (const auto stay = at.lying(body, index, face, twist)) {
    begin_lying(at, body, index, *stay);
    return;
  }
  at.learns(body);
  at.resting.flies(body, at.tick);
  // Not from rest at the touch, or the next bounces would come at every tick.
  const Vec3 normal = flat_at(at.scene.statics, index, face).normal;
  RigidImpactBody leaver = at.rigid_body(body);
  leaver.twist = twist;
  const Vec3 lowest_m = leaver.pose.position_m - at.body(body).reach_m * normal;
  at.begin_after(body, rigid_hop(leaver, lowest_m, normal, hop_speed_mps(at.scene.slow)));
}

// ---- mode events --------------------------------------------------------------------------------

/// A body's contact with static geometry changes.
template <SpheresAtEvent At>
void change_mode(At& at, BodyId body) {
  at.changed.clear();
  if constexpr (AnyAtEvent<At>) {
    if (!is_round(at, body)) {
      change_lying(at, body);
      wake_on_those_that_left(at);
      return;
    }
  }
  const bool rolled = at.mode(body) == MotionMode::rolling;
  const Twist twist = at.twist(body);
  // Over the border of one: what lies there is met as anything else, at once if it goes on level.
  FewContacts few;
  for (const StaticId met : at.supports(body).all()) {
    const FeatureId feature{met};
    if (feature != at.supports(body).leaves) few.add(feature, lasting_contact(at, body, feature));
  }
  begin_on_faces(at, body, few.first(few.count, rolled), twist, twist);
  wake_on_those_that_left(at);
}

// ---- collisions ---------------------------------------------------------------------------------

/// Whether a blow wakes a resting body: by itself, or as one of many that push it on and on, each
/// of which it could take. As if all in the window were like this one.
template <SpheresAtEvent At>
bool is_woken(At& at, BodyId body, const CollisionCount& collided, double jump_mps) {
  const double wake_mps = at.resting.wake_speed_mps();
  if (jump_mps > wake_mps) return true;
  // Balls that jam collide hundreds of times in a window without being pushed far: of them each
  // blow counts alone.
  if (is_round(at, body)) return false;
  const double borne_mps =
      k_bears_gravities * math::norm(at.scene.gravity_mps2) * seconds(k_window);
  return collided.in_window * jump_mps > wake_mps + borne_mps;
}

/// Two bodies collide. Whether the impact could be resolved.
template <SpheresAtEvent At>
bool collide(At& at, BodyId a, BodyId b, const PieceContact& contact, const SurfaceLaw& surfaces) {
  at.changed.clear();
  const CollisionCount& of_a = at.count(a);
  const CollisionCount& of_b = at.count(b);
  const bool plastic = std::max(of_a.at_tick, of_b.at_tick) > k_elastic_at_a_tick;
  const ContactLaw law =
      law_of_impact(surfaces.restitution, surfaces.friction, at.scene.slow, plastic);
  at.meets(a, b, contact.gap_m);
  if (at.may_stay) at.supports(a).met_body = at.supports(b).met_body = at.tick;
  bool a_rests = is_resting(at, a);
  bool b_rests = is_resting(at, b);
  ImpactOutput after = impact(at, a, b, contact, law, a_rests, b_rests);
  if (a_rests || b_rests) {
    // A blow that is hard enough wakes the resting one, which then takes part.
    const BodyId sleeper = a_rests ? a : b;
    const double jump_mps = math::norm(after.impulse_ns) / at.body(sleeper).inertia.mass_kg;
    if (is_woken(at, sleeper, a_rests ? of_a : of_b, jump_mps)) {
      a_rests = false;
      b_rests = false;
      after = impact(at, a, b, contact, law, false, false);
      wake_dependents(at, sleeper);
    }
  }
  if (a_rests != b_rests) {
    PieceContact of_mover = contact;
    if (b_rests) of_mover.normal = -contact.normal;
    Twist& twist = a_rests ? after.b : after.a;
    twist = leaving(at, a_rests ? b : a, of_mover, twist);
  }
  if (at.resting.enabled()) {
    const Vec3 arm_a_m = contact.point_m - at.place_m(a);
    const Vec3 arm_b_m = contact.point_m - at.place_m(b);
    const double parting = parting_mps(contact.normal, arm_a_m, after.a, arm_b_m, after.b);
    const auto note = [&](BodyId body, BodyId partner, const Vec3& outwards, const Vec3& arm_m,
                          const Twist& then) {
      at.touches(body,
                 {.tick = at.tick,
                  .partner = partner,
                  .friction = law.friction,
                  .normal = outwards,
                  .arm_m = arm_m},
                 at.resting.is_slow(fastest_point_mps(at, body, at.twist(body)),
                                    fastest_point_mps(at, body, then), parting));
    };
    if (!a_rests) note(a, b, -contact.normal, arm_a_m, after.a);
    if (!b_rests) note(b, a, contact.normal, arm_b_m, after.b);
  }
  if (!a_rests) at.begin_after(a, after.a);
  if (!b_rests) at.begin_after(b, after.b);
  wake_on_those_that_left(at);
  return after.regime != ImpactRegime::unresolved;
}

/// A body collides with static geometry, by such a law of the impact (law_of_impact).
/// `touched`: whether it is noted that the body touches it.
template <SpheresAtEvent At>
void collide_static(At& at, BodyId body, StaticId index, const PieceContact& contact,
                    ContactLaw law, bool touched) {
  at.changed.clear();
  const Twist before = at.twist(body);
  const double approach_mps = -math::dot(contact.normal, before.velocity_mps);
  const bool caught = is_caught(at, body, index, approach_mps, law.restitution, before);
  if (caught) law = {.restitution = 0, .friction = law.friction};
  std::optional<PlaneStay> lies;
  if constexpr (AnyAtEvent<At>) lies = settling(at, body, index, contact, law.restitution, before);
  Twist after =
      lies ? twist_at_begin(lies->segment) : impact_on_static(at, body, before, contact, law);
  if (!caught && !lies && at.scene.slow.separation_speed_mps > 0)
    after = leaving(at, body, contact, after);
  if (touched) {
    const Vec3 arm_m = contact.point_m - at.place_m(body);
    at.touches(
        body,
        {.tick = at.tick,
         .partner = k_static_partner,
         .feature = index,
         .friction = law.friction,
         .normal = contact.normal,
         .arm_m = arm_m},
        at.resting.is_slow(fastest_point_mps(at, body, before), fastest_point_mps(at, body, after),
                           parting_mps(contact.normal, Vec3::Zero(), {}, arm_m, after)));
  }
  if (caught) {
    begin_caught(at, body, {index}, after);
  } else if (!lies) {
    at.begin_after(body, after);
  } else if constexpr (AnyAtEvent<At>) {
    begin_lying(at, body, index, *lies);
  }
  wake_on_those_that_left(at);
}

// ---- rest ---------------------------------------------------------------------------------------

/// What a decision about rest needs to know of a body; what carries it all the time is noted as
/// touched.
template <SpheresAtEvent At>
RestDecision::Present present_of(At& at, BodyId body) {
  const bool stays = at.mode(body) == MotionMode::sliding || at.mode(body) == MotionMode::rolling;
  RestDecision::Present present{.speed_mps = fastest_point_mps(at, body, at.twist(body)),
                                .centre_m = at.place_m(body),
                                .stays = stays,
                                .stays_on = {}};
  if (stays) present.stays_on = at.supports(body).all();
  if constexpr (AnyAtEvent<At>) {
    if (!is_round(at, body)) {
      at.notes_corners(body);
      if (!stays) return present;
      const auto still = at.lying(body, present.stays_on.front(), at.supports(body).face, {});
      present.stands = still && still->stands;
      return present;
    }
  }
  FewContacts few;
  for (const StaticId met : present.stays_on) {
    const FeatureId feature{met};
    few.add(feature, lasting_contact(at, body, feature));
    const LastingContact& contact = few.contacts[few.count - 1];
    at.resting.still_touches(body, {.tick = at.tick,
                                    .partner = k_static_partner,
                                    .feature = met,
                                    .friction = contact.friction,
                                    .normal = contact.normal,
                                    .arm_m = -at.body(body).reach_m * contact.normal});
  }
  present.stands = stays && at.stands(body, few.all());
  return present;
}

/// A body's rest event: it and those it leans on go to rest, if they may. How many did.
template <SpheresAtEvent At>
std::size_t rest(At& at, BodyId body) {
  at.changed.clear();
  RestDecision& decision = at.resting.decide(body, at.tick);
  while (const auto member = decision.asks()) {
    at.reads(body, *member);
    at.learns(*member);
    // Its partners are asked about next, and it may come to rest on them.
    for (const TouchRecord& touch : at.resting.touches(*member)) {
      if (touch.partner == k_static_partner || at.tick - touch.tick > at.resting.rest_span())
        continue;
      at.goes_live(touch.partner);
      at.reads(*member, touch.partner);
    }
    decision.tell(*member, present_of(at, *member));
  }
  const RestDecision::Outcome outcome = decision.decide();
  for (const BodyId member : outcome.read)
    at.reads(body, member);
  for (const BodyId member : outcome.rest)
    begin_rest(at, member);
  for (const BodyId member : outcome.wake)
    wake_in_place(at, member, body);
  if (outcome.rest.empty() && has_left(at, body)) {
    at.resting.leave(body);
    wake_dependents(at, body);
  }
  return outcome.rest.size();
}

}  // namespace sleight::physics::contact
