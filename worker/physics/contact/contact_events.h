// What collisions, lasting contact and rest do to bodies: the rules of contact, over any table of
// bodies.
//
// Idea. Two engines have bodies in tables of their own (world.h, marbles.h). What happens to the
// bodies at an event is the same, so it stands here once, as functions over what both tables can
// be asked. An engine wraps its table and the event into one object, which has
//
//   tick()                         the event's
//   changed()                      the list of bodies that have begun a segment at it
//   resting(), statics(), slow(), gravity_mps2(), alone_for()
//   is_resting(b), is_round(b)     as its segment says; whether it is a sphere
//   place_m(b), twist(b)           of its present motion, now
//   place_of_rest(b)               where others may rest on it: its pose now, of a sphere without
//                                  its turn
//   reach_m(b), mass_kg(b), round_body(b), fastest_point_mps(b, twist)
//   may_stay(b)                    whether it is a sphere that may stay on static geometry
//   may_lie(b, i)                  whether it is no sphere, and i is flat: a plane or a polyhedron
//   face_met(i, normal)            which face of that has a normal
//   lying(b, i, face, twist)       how it would stay there (plane_stay.h), if it would
//   lifted(b, twist)               as it leaves what it lay on, which carries it no more
//   stays(b), supports(b)          whether it stays, and on what
//   lasting_contact(b, feature)    of such a sphere with static geometry
//   stands(b, contacts)            whether it would stay where it is, on these
//   slow_from(b, segment, end)     from when on it is slow enough for rest
//   flight_after(b, twist)         as it would fly on from here
//   begin_segment(b, segment), begin_after(b, twist)    append it to changed(), and forget what it
//                                  stayed on: supports(b) is empty then
//   begin_rest(b)                  the same, and the body stands still
//   count(b)                       one more collision: its number at this tick
//   collided(b)                    all that is counted of its collisions
//   meets(a, b, gap)               two bodies collide: for the refractory time, and for histories
//   touches(b, record, slowly)     a body's part in a collision, for the decision about rest
//   impact(a, b, contact, law, a_fixed, b_fixed)
//   impact_on_static(b, twist, contact, law)
//   leaving(b, contact, twist)     as it leaves what doesn't move: what is round and rolls hops, as
//                                  it has no slip to pay its bounces from
//   notes_corners(b)               corners that carry beside those that touched
// and says what happened to whoever keeps a history:
//   goes_live(b)                   from now on something other than its history may change it
//   reads(b, other)                what happens to b depends on the other one's state
//   learns(b)                      its contact state changes, beyond what it touches
//
// Everything is a function of the table's state at the event, so both engines do the same, bit for
// bit. What they do is held to physics, and to kept hashes, by the tests of either.
// Thread safety: none.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/contact/contact_state.h"
#include "worker/physics/contact/lasting_contact.h"
#include "worker/physics/contact/plane_stay.h"
#include "worker/physics/contact/resting.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/response/contact_motion.h"
#include "worker/physics/response/rigid_impact.h"
#include "worker/physics/scene/surface_law.h"

namespace sleight::physics::contact {

/// A table of bodies at an event, as above.
template <class T>
concept BodiesAtEvent = requires(T& at, BodyId body, StaticId met, FeatureId feature,
                                 const Twist& twist, const Segment& segment,
                                 const TouchRecord& touch, const PieceContact& contact,
                                 const ContactLaw& law, std::span<const LastingContact> contacts) {
  { at.tick() } -> std::same_as<Tick>;
  { at.changed() } -> std::same_as<std::vector<BodyId>&>;
  { at.resting() } -> std::same_as<Resting&>;
  { at.statics() } -> std::convertible_to<const StaticGeometry&>;
  { at.slow() } -> std::convertible_to<const SlowContacts&>;
  { at.gravity_mps2() } -> std::convertible_to<const Vec3&>;
  { at.alone_for() } -> std::same_as<TickCount>;
  { at.is_resting(body) } -> std::same_as<bool>;
  { at.is_round(body) } -> std::same_as<bool>;
  { at.place_m(body) } -> std::convertible_to<Vec3>;
  { at.twist(body) } -> std::same_as<Twist>;
  { at.place_of_rest(body) } -> std::same_as<Pose>;
  { at.reach_m(body) } -> std::same_as<double>;
  { at.mass_kg(body) } -> std::same_as<double>;
  { at.fastest_point_mps(body, twist) } -> std::same_as<double>;
  { at.round_body(body) } -> std::convertible_to<RoundBody>;
  { at.may_stay(body) } -> std::same_as<bool>;
  { at.may_lie(body, met) } -> std::same_as<bool>;
  { at.face_met(met, Vec3{}) } -> std::same_as<std::optional<std::uint32_t>>;
  { at.lying(body, met, std::uint32_t{}, twist) } -> std::same_as<std::optional<PlaneStay>>;
  { at.lifted(body, twist) } -> std::same_as<Twist>;
  { at.stays(body) } -> std::same_as<bool>;
  { at.supports(body) } -> std::same_as<Supports&>;
  { at.lasting_contact(body, feature) } -> std::same_as<LastingContact>;
  { at.stands(body, contacts) } -> std::same_as<bool>;
  { at.slow_from(body, segment, Tick{}) } -> std::same_as<Tick>;
  { at.flight_after(body, twist) } -> std::same_as<FreeFlight>;
  at.begin_segment(body, segment);
  at.begin_after(body, twist);
  at.begin_rest(body);
  { at.count(body) } -> std::same_as<std::uint32_t>;
  { at.collided(body) } -> std::same_as<const CollisionCount&>;
  at.meets(body, body, double{});
  at.touches(body, touch, bool{});
  { at.impact(body, body, contact, law, bool{}, bool{}) } -> std::same_as<ImpactOutput>;
  { at.impact_on_static(body, twist, contact, law) } -> std::same_as<Twist>;
  { at.leaving(body, contact, twist) } -> std::same_as<Twist>;
  at.notes_corners(body);
  at.goes_live(body);
  at.reads(body, body);
  at.learns(body);
};

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

// ---- who wakes ----------------------------------------------------------------------------------

/// A body moves: what rested on it wakes, each where it is.
template <BodiesAtEvent At>
void wake_dependents(At& at, BodyId body) {
  for (const BodyId dependent : at.resting().wake(body)) {
    const bool rested = at.is_resting(dependent);
    at.goes_live(dependent);
    if (rested) at.reads(body, dependent);
    at.learns(dependent);
    if (!rested) continue;
    at.begin_after(dependent, {});
    at.resting().woke(dependent, at.tick(), at.place_of_rest(dependent));
  }
}

/// Whether a body that woke without a blow has left the place in which others rest on it.
template <BodiesAtEvent At>
bool has_left(At& at, BodyId body) {
  if (!at.resting().in_place(body)) return false;
  return at.resting().has_left(body, at.place_of_rest(body),
                               at.fastest_point_mps(body, at.twist(body)));
}

/// What rested on those whose motion has changed, and that have left their places, wakes.
template <BodiesAtEvent At>
void wake_on_those_that_left(At& at) {
  // The list grows by the bodies that wake; these are still in their places.
  for (std::size_t i = 0; i < at.changed().size(); ++i) {
    const BodyId body = at.changed()[i];
    if (at.is_resting(body) || !has_left(at, body)) continue;
    at.learns(body);
    at.resting().leave(body);
    wake_dependents(at, body);
  }
  if (at.changed().size() > 1) std::sort(at.changed().begin(), at.changed().end());
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
template <BodiesAtEvent At>
bool is_caught(At& at, BodyId body, StaticId met, double approach_mps, double restitution,
               const Twist& twist) {
  if (!at.may_stay(body)) return false;
  const double slow_mps = at.slow().separation_speed_mps;
  if (restitution * approach_mps >= slow_mps ||
      at.tick() - at.supports(body).met_body < at.alone_for())
    return false;
  return at.statics().feature({met}).kind == FeatureKind::face ||
         math::norm(twist.velocity_mps) < k_edge_speeds * slow_mps;
}

/// A sphere with such a twist goes on from what it touches: it stays on those that carry it, if any
/// do, or flies with the other one.
template <BodiesAtEvent At>
void begin_on_faces(At& at, BodyId body, const MayStayOn& on, const Twist& twist,
                    const Twist& otherwise) {
  const auto stay =
      stay_on(at.round_body(body), on, at.flight_after(body, twist),
              {.statics = at.statics(), .slow = at.slow(), .gravity_mps2 = at.gravity_mps2()});
  at.learns(body);
  if (!stay) {
    at.resting().flies(body, at.tick());
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
  if (at.resting().enabled())
    at.resting().stays(body, at.tick(), at.slow_from(body, stay->segment, kept.end));
}

/// The same when it has just lost its bounce on `feature`.
template <BodiesAtEvent At>
void begin_caught(At& at, BodyId body, FeatureId feature, const Twist& twist) {
  FewContacts few;
  few.add(feature, at.lasting_contact(body, feature));
  for (const StaticId met : at.supports(body).all()) {
    const FeatureId other{met};
    if (other != feature && few.count < few.features.size())
      few.add(other, at.lasting_contact(body, other));
  }
  const Caught caught = caught_by(at.round_body(body), few.all(), twist, at.slow());
  begin_on_faces(at, body, few.first(caught.count, false), caught.twist, caught.otherwise);
}

// ---- lasting contact of other bodies ------------------------------------------------------------

// What is no sphere stays on what is flat when what carries it bounces there by no more than slow
// bounces do (plane_stay.h), under the same conditions: its own bounce would be slower than
// separation_speed_mps, and it has met no other body for some bounces, nor two static pieces one
// soon after the other: what leans on both would be pressed into one while it stays on the other.

/// A body begins to stay on what is flat, or goes on to.
template <BodiesAtEvent At>
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
  if (!at.resting().enabled()) return;
  // What friction brakes comes to a stop by itself.
  const Tick slow = stay.brakes ? k_never : at.slow_from(body, stay.segment, stay.end);
  at.resting().stays(body, at.tick(), slow);
}

/// How a body that collides with what is flat stays there, if it does.
template <BodiesAtEvent At>
std::optional<PlaneStay> settling(At& at, BodyId body, StaticId index, const PieceContact& contact,
                                  double restitution, const Twist& twist) {
  if (!at.may_lie(body, index)) return std::nullopt;
  Supports& supports = at.supports(body);
  supports.hits(index, at.tick(), at.alone_for());
  if (restitution * -contact.rate_mps >= at.slow().separation_speed_mps ||
      at.tick() - supports.met_body < at.alone_for() ||
      at.tick() - supports.hit_both < at.alone_for())
    return std::nullopt;
  const auto face = at.face_met(index, contact.normal);
  return face ? at.lying(body, index, *face, twist) : std::nullopt;
}

/// Its mode event: it goes on otherwise, or is carried no more.
template <BodiesAtEvent At>
void change_lying(At& at, BodyId body) {
  const Twist twist = at.twist(body);
  const StaticId index = at.supports(body).features[0];
  if (const auto stay = at.lying(body, index, at.supports(body).face, twist)) {
    begin_lying(at, body, index, *stay);
    return;
  }
  at.learns(body);
  at.resting().flies(body, at.tick());
  // Not from rest at the touch, or the next bounces would come at every tick.
  at.begin_after(body, at.lifted(body, twist));
}

// ---- mode events --------------------------------------------------------------------------------

/// A body's contact with static geometry changes.
template <BodiesAtEvent At>
void change_mode(At& at, BodyId body, bool rolled) {
  at.changed().clear();
  if (!at.is_round(body)) {
    change_lying(at, body);
    wake_on_those_that_left(at);
    return;
  }
  const Twist twist = at.twist(body);
  // Over the border of one: what lies there is met as anything else, at once if it goes on level.
  FewContacts few;
  for (const StaticId met : at.supports(body).all()) {
    const FeatureId feature{met};
    if (feature != at.supports(body).leaves) few.add(feature, at.lasting_contact(body, feature));
  }
  begin_on_faces(at, body, few.first(few.count, rolled), twist, twist);
  wake_on_those_that_left(at);
}

// ---- collisions ---------------------------------------------------------------------------------

/// Whether a blow wakes a resting body: by itself, or as one of many that push it on and on, each
/// of which it could take. As if all in the window were like this one.
template <BodiesAtEvent At>
bool is_woken(At& at, BodyId body, double jump_mps) {
  const double wake_mps = at.resting().wake_speed_mps();
  if (jump_mps > wake_mps) return true;
  // Balls that jam collide hundreds of times in a window without being pushed far: of them each
  // blow counts alone.
  if (at.is_round(body)) return false;
  const double borne_mps = k_bears_gravities * math::norm(at.gravity_mps2()) * seconds(k_window);
  return at.collided(body).in_window * jump_mps > wake_mps + borne_mps;
}

/// Two bodies collide. Whether the impact could be resolved.
template <BodiesAtEvent At>
bool collide(At& at, BodyId a, BodyId b, const PieceContact& contact, const SurfaceLaw& surfaces) {
  at.changed().clear();
  const bool plastic = std::max(at.count(a), at.count(b)) > k_elastic_at_a_tick;
  const ContactLaw law = law_of_impact(surfaces.restitution, surfaces.friction, at.slow(), plastic);
  at.meets(a, b, contact.gap_m);
  bool a_rests = at.is_resting(a);
  bool b_rests = at.is_resting(b);
  ImpactOutput after = at.impact(a, b, contact, law, a_rests, b_rests);
  if (a_rests || b_rests) {
    // A blow that is hard enough wakes the resting one, which then takes part.
    const BodyId sleeper = a_rests ? a : b;
    const double jump_mps = math::norm(after.impulse_ns) / at.mass_kg(sleeper);
    if (is_woken(at, sleeper, jump_mps)) {
      a_rests = false;
      b_rests = false;
      after = at.impact(a, b, contact, law, false, false);
      wake_dependents(at, sleeper);
    }
  }
  if (a_rests != b_rests) {
    PieceContact of_mover = contact;
    if (b_rests) of_mover.normal = -contact.normal;
    Twist& twist = a_rests ? after.b : after.a;
    twist = at.leaving(a_rests ? b : a, of_mover, twist);
  }
  if (at.resting().enabled()) {
    const Vec3 arm_a_m = contact.point_m - at.place_m(a);
    const Vec3 arm_b_m = contact.point_m - at.place_m(b);
    const double parting = parting_mps(contact.normal, arm_a_m, after.a, arm_b_m, after.b);
    const auto note = [&](BodyId body, BodyId partner, const Vec3& outwards, const Vec3& arm_m,
                          const Twist& then) {
      at.touches(body,
                 {.tick = at.tick(),
                  .partner = partner,
                  .friction = law.friction,
                  .normal = outwards,
                  .arm_m = arm_m},
                 at.resting().is_slow(at.fastest_point_mps(body, at.twist(body)),
                                      at.fastest_point_mps(body, then), parting));
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
template <BodiesAtEvent At>
void collide_static(At& at, BodyId body, StaticId index, const PieceContact& contact,
                    ContactLaw law, bool touched) {
  at.changed().clear();
  const Twist before = at.twist(body);
  const double approach_mps = -math::dot(contact.normal, before.velocity_mps);
  const bool caught = is_caught(at, body, index, approach_mps, law.restitution, before);
  if (caught) law = {.restitution = 0, .friction = law.friction};
  const auto lies = settling(at, body, index, contact, law.restitution, before);
  Twist after =
      lies ? twist_at_begin(lies->segment) : at.impact_on_static(body, before, contact, law);
  if (!caught && !lies && at.slow().separation_speed_mps > 0)
    after = at.leaving(body, contact, after);
  if (touched) {
    const Vec3 arm_m = contact.point_m - at.place_m(body);
    at.touches(
        body,
        {.tick = at.tick(),
         .partner = k_static_partner,
         .feature = index,
         .friction = law.friction,
         .normal = contact.normal,
         .arm_m = arm_m},
        at.resting().is_slow(at.fastest_point_mps(body, before), at.fastest_point_mps(body, after),
                             parting_mps(contact.normal, Vec3::Zero(), {}, arm_m, after)));
  }
  if (caught) {
    begin_caught(at, body, {index}, after);
  } else if (lies) {
    begin_lying(at, body, index, *lies);
  } else {
    at.begin_after(body, after);
  }
  wake_on_those_that_left(at);
}

// ---- rest ---------------------------------------------------------------------------------------

/// What a decision about rest needs to know of a body; what carries it all the time is noted as
/// touched.
template <BodiesAtEvent At>
RestDecision::Present present_of(At& at, BodyId body) {
  const std::span<const StaticId> features =
      at.stays(body) ? at.supports(body).all() : std::span<const StaticId>{};
  FewContacts few;
  for (const StaticId met : at.is_round(body) ? features : features.first(0)) {
    const FeatureId feature{met};
    few.add(feature, at.lasting_contact(body, feature));
    const LastingContact& contact = few.contacts[few.count - 1];
    at.resting().still_touches(body, {.tick = at.tick(),
                                      .partner = k_static_partner,
                                      .feature = met,
                                      .friction = contact.friction,
                                      .normal = contact.normal,
                                      .arm_m = -at.reach_m(body) * contact.normal});
  }
  at.notes_corners(body);
  RestDecision::Present present{.speed_mps = at.fastest_point_mps(body, at.twist(body)),
                                .centre_m = at.place_m(body),
                                .stays = at.stays(body),
                                .stays_on = features};
  if (!present.stays) return present;
  if (at.is_round(body)) {
    present.stands = at.stands(body, few.all());
  } else {
    const auto still = at.lying(body, features.front(), at.supports(body).face, {});
    present.stands = still && still->stands;
  }
  return present;
}

/// A body's rest event: it and those it leans on go to rest, if they may. How many did.
template <BodiesAtEvent At>
std::size_t rest(At& at, BodyId body) {
  at.changed().clear();
  RestDecision& decision = at.resting().decide(body, at.tick());
  while (const auto member = decision.asks()) {
    at.reads(body, *member);
    at.learns(*member);
    // Its partners are asked about next, and it may come to rest on them.
    for (const TouchRecord& touch : at.resting().touches(*member)) {
      if (touch.partner == k_static_partner || at.tick() - touch.tick > at.resting().rest_span())
        continue;
      at.goes_live(touch.partner);
      at.reads(*member, touch.partner);
    }
    decision.tell(*member, present_of(at, *member));
  }
  const RestDecision::Outcome outcome = decision.decide();
  for (const BodyId member : outcome.read)
    at.reads(body, member);
  for (const BodyId member : outcome.rest) {
    at.begin_rest(member);
    at.resting().rests_at(member, at.place_m(member));
  }
  for (const BodyId member : outcome.wake) {
    at.goes_live(member);
    at.reads(body, member);
    at.learns(member);
    at.begin_after(member, {});
    at.resting().woke(member, at.tick(), at.place_of_rest(member));
  }
  if (outcome.rest.empty() && has_left(at, body)) {
    at.resting().leave(body);
    wake_dependents(at, body);
  }
  return outcome.rest.size();
}

}  // namespace sleight::physics::contact
