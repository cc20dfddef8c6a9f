// Applies the rules of contact: what collisions, lasting contact and rest do to bodies.
//
// Idea. Two engines store bodies in different tables (world.h, marbles.h), but apply the same rules
// at events. So the rules are written once, as functions over either table (bodies_at_event.h).
//
// The results depend only on the table's state at the event, so both engines produce the same bits.
// Tests of the engines compare the results with physical laws and with stored hashes. Thread
// safety: none.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/contact/bodies_at_event.h"
#include "worker/physics/contact/contact_state.h"
#include "worker/physics/contact/impact_noise.h"
#include "worker/physics/contact/lasting_contact.h"
#include "worker/physics/contact/plane_stay.h"
#include "worker/physics/contact/resting.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/response/contact_motion.h"
#include "worker/physics/response/rigid_impact.h"
#include "worker/physics/response/sphere_impact.h"

namespace sleight::physics::contact {

// ---- laws ---------------------------------------------------------------------------------------

/// `plastic`: a body has had too many collisions at this tick, so the law has no restitution.
inline ContactLaw law_of_impact(double restitution, double friction, const SlowContacts& slow,
                                bool plastic) {
  if (plastic) return {.restitution = 0, .friction = friction};
  return {.restitution = restitution,
          .friction = friction,
          .separation_speed_floor_mps = slow.separation_speed_mps};
}

/// Returns a contact's separation speed. The arms lead from the bodies' centres to the contact.
inline double parting_mps(const Vec3& normal, const Vec3& arm_a_m, const Twist& a,
                          const Vec3& arm_b_m, const Twist& b) {
  const Vec3 of_a = a.velocity_mps + math::cross(a.angular_velocity_radps, arm_a_m);
  const Vec3 of_b = b.velocity_mps + math::cross(b.angular_velocity_radps, arm_b_m);
  return math::dot(normal, of_b - of_a);
}

/// Speed with which a rolling sphere hops off an edge or a resting body.
inline double hop_speed_mps(const SlowContacts& slow) {
  return k_hop_share * slow.separation_speed_mps;
}

// ---- impacts ------------------------------------------------------------------------------------

template <AnyAtEvent At>
RigidImpactBody rigid_body(At& at, BodyId body, const Twist& twist) {
  RigidImpactBody rigid = at.rigid_body(body);
  rigid.twist = twist;
  return rigid;
}

/// A body of an impact. A body that rests is treated as static geometry.
struct Impinging {
  BodyId body{};
  Twist twist;
  bool rests = false;
};

template <SpheresAtEvent At>
ImpactOutput impact(At& at, const Impinging& a, const Impinging& b, const PieceContact& contact,
                    const ContactLaw& law) {
  if constexpr (AnyAtEvent<At>) {
    if (!is_round(at, a.body) || !is_round(at, b.body)) {
      return rigid_impact({.a = a.rests ? RigidImpactBody{} : rigid_body(at, a.body, a.twist),
                           .b = b.rests ? RigidImpactBody{} : rigid_body(at, b.body, b.twist),
                           .contact_m = contact.point_m,
                           .normal = contact.normal,
                           .law = law});
    }
  }
  return sphere_impact({.mass_a = a.rests ? SphereMass{} : at.body(a.body).sphere_mass,
                        .mass_b = b.rests ? SphereMass{} : at.body(b.body).sphere_mass,
                        .a = a.twist,
                        .b = b.twist,
                        .normal = contact.normal,
                        .law = law});
}

template <SpheresAtEvent At>
Twist impact_on_static(At& at, BodyId body, const Twist& before, const PieceContact& contact,
                       const ContactLaw& law) {
  if constexpr (AnyAtEvent<At>) {
    if (!is_round(at, body)) {
      return rigid_impact({.a = {},
                           .b = rigid_body(at, body, before),
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

/// An impact with noise, and the impact that follows if the contact still approaches
/// (contact_noise.h).
struct NoisedImpact {
  NoisedImpact(const ImpactNoise& noise, const PieceContact& contact, const ContactLaw& law)
      : tilted(contact), noised(law), dead(law) {
    tilted.normal = noise.tilted(contact.normal);
    noised.restitution = noise.noised(law.restitution);
    dead.restitution = 0;
  }
  PieceContact tilted;
  ContactLaw noised;
  ContactLaw dead;
};

/// Equals impact() if there is no noise.
template <SpheresAtEvent At>
ImpactOutput impact(At& at, Impinging a, Impinging b, const PieceContact& contact,
                    const ContactLaw& law, const std::optional<ImpactNoise>& noise) {
  if (!noise) return impact(at, a, b, contact, law);
  const NoisedImpact with(*noise, contact, law);
  const ImpactOutput first = impact(at, a, b, with.tilted, with.noised);
  const auto arm_m = [&](BodyId body) { return Vec3(contact.point_m - at.place_m(body)); };
  if (first.regime == ImpactRegime::unresolved ||
      !(parting_mps(contact.normal, arm_m(a.body), first.a, arm_m(b.body), first.b) < 0))
    return first;
  a.twist = first.a;
  b.twist = first.b;
  ImpactOutput both = impact(at, a, b, contact, with.dead);
  both.impulse_ns += first.impulse_ns;
  both.normal_impulse_ns += first.normal_impulse_ns;
  return both;
}

/// Equals impact_on_static() if there is no noise.
template <SpheresAtEvent At>
Twist impact_on_static(At& at, BodyId body, const Twist& before, const PieceContact& contact,
                       const ContactLaw& law, const std::optional<ImpactNoise>& noise) {
  if (!noise) return impact_on_static(at, body, before, contact, law);
  const NoisedImpact with(*noise, contact, law);
  const Twist after = impact_on_static(at, body, before, with.tilted, with.noised);
  const Vec3 arm_m = contact.point_m - at.place_m(body);
  if (!(parting_mps(contact.normal, Vec3::Zero(), {}, arm_m, after) < 0)) return after;
  return impact_on_static(at, body, after, contact, with.dead);
}

/// Returns the twist with which a body leaves an obstacle at rest. A rolling round body hops: it
/// doesn't slip, so no slip energy keeps its bounces going.
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

/// Wakes a resting body in its place. The body `because` is the cause.
template <SpheresAtEvent At>
void wake_in_place(At& at, BodyId body, BodyId because) {
  at.goes_live(body);
  at.reads(because, body);
  at.learns(body);
  at.begin_after(body, {});
  at.resting.woke(body, at.tick, place_of_rest(at, body));
}

/// Wakes the bodies that rested on a body that now moves.
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

/// A body may wake without an impact while others rest on it. Returns whether it has left the place
/// in which they rest on it.
template <SpheresAtEvent At>
bool has_left(At& at, BodyId body) {
  if (!at.resting.in_place(body)) return false;
  return at.resting.has_left(body, place_of_rest(at, body),
                             fastest_point_mps(at, body, at.twist(body)));
}

/// If a changed body has left its place, wakes the bodies that rested on it.
template <SpheresAtEvent At>
void wake_on_those_that_left(At& at) {
  // The loop appends woken bodies to the list. Woken bodies are still in their places.
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

// A sphere loses its bounce on a face if the bounce would be slower than separation_speed_mps. The
// sphere then stays if gravity presses it onto one face, into a valley between two faces, or into a
// corner of three faces. At an edge, a fast sphere hops (contact_motion.h), and a slow sphere moves
// round the edge piece by piece (edge_motion.h). As long as the sphere moves by no more than a few
// micrometres, a vertex counts as a face, and so does an edge together with another feature. So a
// sphere can come to rest between a face and an edge.
//
// A sphere stays only if it has met no other body for the duration of some bounces. A sphere that
// leans on another body bounces off both the face and the body. If the sphere stayed on the face
// instead, nothing would separate it from the other body. The two would collide again and again
// without time passing.

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

/// Returns whether a sphere hits static geometry so slowly that it loses its bounce and may stay.
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

/// Begins a sphere's next segment at a contact. If features can carry the sphere at `twist`, the
/// sphere stays on them. If not, it flies with the twist `otherwise`.
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

/// Calls begin_on_faces after a sphere has lost its bounce on a feature.
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

// A body that isn't a sphere stays on a flat surface if the points that carry it bounce there no
// faster than slow bounces do (plane_stay.h). As for spheres, the body's own bounce must be slower
// than separation_speed_mps, and the body must have met no other body for the duration of some
// bounces. The body must also not have hit two static pieces shortly after each other, because
// staying on one piece would press the body into the other.

/// Begins a segment in which a body stays on a flat surface.
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
  // If friction brakes the body, the body needs no tick for rest: it stops by itself.
  const Tick slow = stay.brakes ? k_never : slow_from(at, body, stay.segment, stay.end);
  at.resting.stays(body, at.tick, slow);
}

/// Returns how a body that hits a flat surface stays there. Empty: the body doesn't stay.
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

/// Handles a body's mode event on a flat surface. The body begins another stay or leaves.
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
  // Make the body hop. A body at rest at the touch distance would bounce at every tick.
  const Vec3 normal = flat_at(at.scene.statics, index, face).normal;
  RigidImpactBody leaver = at.rigid_body(body);
  leaver.twist = twist;
  const Vec3 lowest_m = leaver.pose.position_m - at.body(body).reach_m * normal;
  at.begin_after(body, rigid_hop(leaver, lowest_m, normal, hop_speed_mps(at.scene.slow)));
}

// ---- mode events --------------------------------------------------------------------------------

/// Handles a body's mode event, at which its contact with static geometry changes.
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
  // Drop the feature whose border the centre crossed. The sphere then collides with the feature
  // beyond the border. If the surface continues level, this happens at once.
  FewContacts few;
  for (const StaticId met : at.supports(body).all()) {
    const FeatureId feature{met};
    if (feature != at.supports(body).leaves) few.add(feature, lasting_contact(at, body, feature));
  }
  begin_on_faces(at, body, few.first(few.count, rolled), twist, twist);
  wake_on_those_that_left(at);
}

// ---- collisions ---------------------------------------------------------------------------------

/// Returns whether an impact wakes a resting body. One hard impact is enough. Many weak impacts in
/// the window are also enough; the test assumes that all are equal.
template <SpheresAtEvent At>
bool is_woken(At& at, BodyId body, const CollisionCount& collided, double jump_mps) {
  if (is_fixed(at, body)) return false;
  const double wake_mps = at.resting.wake_speed_mps();
  if (jump_mps > wake_mps) return true;
  // For a ball, judge each impact alone: jammed balls collide hundreds of times in a window, but
  // are not pushed far.
  if (is_round(at, body)) return false;
  const double borne_mps =
      k_bears_gravities * math::norm(at.scene.gravity_mps2) * seconds(k_window);
  return collided.in_window * jump_mps > wake_mps + borne_mps;
}

/// Returns whether the impact was resolved.
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
  std::optional<ImpactNoise> noise;
  if constexpr (AnyAtEvent<At>) noise = at.take_noise();
  const auto resolve = [&] {
    return impact(at, {a, at.twist(a), a_rests}, {b, at.twist(b), b_rests}, contact, law, noise);
  };
  ImpactOutput after = resolve();
  if (a_rests || b_rests) {
    // If the impact wakes the resting body, resolve it again with both bodies free.
    const BodyId sleeper = a_rests ? a : b;
    const double jump_mps = math::norm(after.impulse_ns) / at.body(sleeper).inertia.mass_kg;
    if (is_woken(at, sleeper, a_rests ? of_a : of_b, jump_mps)) {
      a_rests = false;
      b_rests = false;
      after = resolve();
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

/// `law`: see law_of_impact. `touched`: whether to record the touch.
template <SpheresAtEvent At>
void collide_static(At& at, BodyId body, StaticId index, const PieceContact& contact,
                    ContactLaw law, bool touched) {
  at.changed.clear();
  const Twist before = at.twist(body);
  const double approach_mps = -math::dot(contact.normal, before.velocity_mps);
  const bool caught = is_caught(at, body, index, approach_mps, law.restitution, before);
  if (caught) law = {.restitution = 0, .friction = law.friction};
  std::optional<PlaneStay> lies;
  std::optional<ImpactNoise> noise;
  if constexpr (AnyAtEvent<At>) {
    lies = settling(at, body, index, contact, law.restitution, before);
    if (!caught && !lies) noise = at.take_noise();
  }
  Twist after = lies ? twist_at_begin(lies->segment)
                     : impact_on_static(at, body, before, contact, law, noise);
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

/// Returns a body's state for a rest decision. Records lasting contacts as touches.
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

/// Processes a body's rest event. If the rules allow, puts the body to rest, together with the
/// bodies that it leans on. Returns the number of bodies that went to rest.
template <SpheresAtEvent At>
std::size_t rest(At& at, BodyId body) {
  at.changed.clear();
  RestDecision& decision = at.resting.decide(body, at.tick);
  while (const auto member = decision.asks()) {
    at.reads(body, *member);
    at.learns(*member);
    // The member may come to rest on its partners, so the decision continues with them.
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
