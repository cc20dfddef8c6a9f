// The world's bodies at an event, as contact_events.h asks for them.
//
// Internal to the sources of World. Thread safety: none.
#pragma once

#include "worker/physics/contact/contact_events.h"
#include "worker/physics/simulator/world.h"

namespace sleight::physics {

class World::AtEvent {
 public:
  /// Borrows both.
  AtEvent(World& world, const EventKey& event) : world_(world), event_(event) {}

  Tick tick() const { return event_.tick; }
  std::vector<BodyId>& changed() { return world_.changed_; }
  Resting& resting() { return world_.resting_; }
  const StaticGeometry& statics() const { return world_.statics_.geometry(); }
  const SlowContacts& slow() const { return world_.scene().slow; }
  const Vec3& gravity_mps2() const { return world_.scene().gravity_mps2; }
  TickCount alone_for() const { return world_.alone_for_; }

  bool is_resting(BodyId body) const { return world_.bodies_.is_resting(body); }
  bool is_round(BodyId body) const { return constants(body).is_sphere; }
  Vec3 place_m(BodyId body) const { return world_.bodies_.position_at(body, tick()); }
  Twist twist(BodyId body) { return world_.bodies_.twist_at(body, tick()); }
  Pose place_of_rest(BodyId body) {
    return is_round(body) ? Pose{place_m(body), Quat::Identity()}
                          : world_.bodies_.pose_at(body, tick());
  }
  double reach_m(BodyId body) const { return constants(body).reach_m; }
  double mass_kg(BodyId body) const { return constants(body).inertia.mass_kg; }
  double fastest_point_mps(BodyId body, const Twist& twist) const {
    return physics::fastest_point_mps(reach_m(body), twist);
  }

  RoundBody round_body(BodyId body) const { return world_.bodies_.round_body(body); }
  bool may_stay(BodyId body) const {
    return is_round(body) && world_.bodies_.may_stay() &&
           constants(body).inertia.symmetry == InertiaSymmetry::spherical;
  }
  bool may_lie(BodyId body, StaticId met) const {
    return !is_round(body) && world_.bodies_.may_stay() && met < statics().piece_count();
  }
  std::optional<std::uint32_t> face_met(StaticId met, const Vec3& normal) const {
    return world_.statics_.face_met(met, normal);
  }
  std::optional<PlaneStay> lying(BodyId body, StaticId met, std::uint32_t face,
                                 const Twist& twist) {
    return world_.stay_of(body, met, face, twist, tick());
  }
  Twist lifted(BodyId body, const Twist& twist) {
    const Vec3& normal =
        world_.statics_.flat(supports(body).features[0], supports(body).face).normal;
    RigidImpactBody leaver = world_.bodies_.rigid_body(body, tick());
    leaver.twist = twist;
    return rigid_hop(leaver, leaver.pose.position_m - reach_m(body) * normal, normal,
                     contact::hop_speed_mps(slow()));
  }
  bool stays(BodyId body) const { return world_.bodies_.stays_on_faces(body); }
  Supports& supports(BodyId body) { return world_.bodies_.supports_of(body); }
  LastingContact lasting_contact(BodyId body, FeatureId feature) const {
    const SurfaceLaw& law = world_.scene().contacts.between(constants(body).material,
                                                            statics().material_of_feature(feature));
    return {.normal = normal_at(statics().feature(feature), place_m(body)),
            .friction = statics().friction_at({feature}, place_m(body), law.friction),
            .rolling_friction = law.rolling_friction};
  }
  bool stands(BodyId body, std::span<const LastingContact> contacts) const {
    return stands_on(round_body(body), contacts, gravity_mps2());
  }
  Tick slow_from(BodyId body, const Segment& segment, Tick end) const {
    return physics::slow_from(segment, reach_m(body), constants(body).inertia, slow(), end);
  }

  FreeFlight flight_after(BodyId body, const Twist& twist) {
    return world_.bodies_.segment_after(body, tick(), place_m(body), twist).flight;
  }
  void begin_segment(BodyId body, const Segment& segment) {
    world_.begin_segment(body, segment, event_);
    world_.changed_.push_back(body);
  }
  void begin_after(BodyId body, const Twist& twist) {
    begin_segment(body, {.flight = flight_after(body, twist)});
  }
  void begin_rest(BodyId body) {
    Segment segment{.flight = flight_after(body, {}), .mode = MotionMode::resting};
    segment.flight.acceleration_mps2 = Vec3::Zero();
    begin_segment(body, segment);
  }

  std::uint32_t count(BodyId body) { return world_.count_at(body, tick()); }
  const CollisionCount& collided(BodyId body) const { return world_.collided_[body]; }
  void meets(BodyId a, BodyId b, double gap_m) {
    world_.predictions_.have_collided(a, b, tick(), gap_m);
    world_.recorder_.meets(gap_m);
    if (!world_.bodies_.may_stay()) return;
    supports(a).met_body = tick();
    supports(b).met_body = tick();
  }
  void touches(BodyId body, const TouchRecord& touch, bool slowly) {
    world_.note_touch(body, touch, slowly);
  }
  ImpactOutput impact(BodyId a, BodyId b, const PieceContact& contact, const ContactLaw& law,
                      bool a_fixed, bool b_fixed) {
    if (is_round(a) && is_round(b)) {
      return sphere_impact({.mass_a = a_fixed ? SphereMass{} : constants(a).sphere_mass,
                            .mass_b = b_fixed ? SphereMass{} : constants(b).sphere_mass,
                            .a = twist(a),
                            .b = twist(b),
                            .normal = contact.normal,
                            .law = law});
    }
    return rigid_impact({.a = a_fixed ? RigidImpactBody{} : world_.bodies_.rigid_body(a, tick()),
                         .b = b_fixed ? RigidImpactBody{} : world_.bodies_.rigid_body(b, tick()),
                         .contact_m = contact.point_m,
                         .normal = contact.normal,
                         .law = law});
  }
  Twist impact_on_static(BodyId body, const Twist& before, const PieceContact& contact,
                         const ContactLaw& law) {
    if (is_round(body)) {
      return sphere_impact({.mass_a = {},
                            .mass_b = constants(body).sphere_mass,
                            .a = {},
                            .b = before,
                            .normal = contact.normal,
                            .law = law})
          .b;
    }
    return rigid_impact({.a = {},
                         .b = world_.bodies_.rigid_body(body, tick()),
                         .contact_m = contact.point_m,
                         .normal = contact.normal,
                         .law = law})
        .b;
  }

  Twist leaving(BodyId body, const PieceContact& contact, const Twist& twist) {
    const double speed_mps = contact::hop_speed_mps(slow());
    if (is_round(body)) return hop(round_body(body), contact.normal, twist, speed_mps);
    if (!constants(body).has_round_parts) return twist;
    RigidImpactBody leaver = world_.bodies_.rigid_body(body, tick());
    leaver.twist = twist;
    return rigid_hop(leaver, contact.point_m, contact.normal, speed_mps);
  }

  void notes_corners(BodyId body) {
    if (is_round(body)) return;
    if (stays(body)) world_.note_plane_supports(body, tick());
    world_.note_near_corners(body, tick());
  }
  void goes_live(BodyId body) { world_.replayed_.make_live(body); }
  void reads(BodyId /*body*/, BodyId other) { world_.recorder_.takes_part(other); }
  void learns(BodyId body) { world_.recorder_.learns(body); }

 private:
  const BodyConstants& constants(BodyId body) const { return world_.bodies_.constants(body); }

  World& world_;
  const EventKey& event_;
};

}  // namespace sleight::physics
