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
  std::vector<std::uint32_t>& changed() { return world_.changed_; }
  Resting& resting() { return world_.resting_; }
  const StaticGeometry& statics() const { return world_.statics_; }
  const SlowContacts& slow() const { return world_.scene_.slow; }
  const Vec3& gravity_mps2() const { return world_.scene_.gravity_mps2; }
  TickCount alone_for() const { return world_.alone_for_; }

  bool is_resting(std::uint32_t body) const { return world_.is_resting(body); }
  bool is_round(std::uint32_t body) const { return constants(body).is_sphere; }
  Vec3 place_m(std::uint32_t body) const {
    return position_at(world_.segments_[body].flight, tick());
  }
  Twist twist(std::uint32_t body) { return world_.twist_at(body, tick()); }
  Pose place_of_rest(std::uint32_t body) {
    return is_round(body) ? Pose{place_m(body), Quat::Identity()} : world_.pose_at(body, tick());
  }
  double reach_m(std::uint32_t body) const { return constants(body).reach_m; }
  double mass_kg(std::uint32_t body) const { return constants(body).inertia.mass_kg; }
  double fastest_point_mps(std::uint32_t body, const Twist& twist) const {
    return physics::fastest_point_mps(reach_m(body), twist);
  }

  RoundBody round_body(std::uint32_t body) const { return world_.round_body(body); }
  bool may_stay(std::uint32_t body) const {
    return is_round(body) && !world_.supports_.empty() &&
           constants(body).inertia.symmetry == InertiaSymmetry::spherical;
  }
  bool may_lie(std::uint32_t body, std::uint32_t index) const {
    return !is_round(body) && !world_.supports_.empty() && index < statics().piece_count();
  }
  std::optional<std::uint32_t> face_met(std::uint32_t index, const Vec3& normal) const {
    return world_.face_met(index, normal);
  }
  std::optional<PlaneStay> lying(std::uint32_t body, std::uint32_t index, std::uint32_t face,
                                 const Twist& twist) {
    return world_.stay_of(body, index, face, twist, tick());
  }
  Twist lifted(std::uint32_t body, const Twist& twist) {
    const Vec3& normal =
        world_.flat_of(supports(body).features[0], supports(body).features[1]).normal;
    RigidImpactBody leaver = world_.rigid_body(body, tick());
    leaver.twist = twist;
    return rigid_hop(leaver, leaver.pose.position_m - reach_m(body) * normal, normal,
                     contact::hop_speed_mps(slow()));
  }
  bool stays(std::uint32_t body) const { return world_.stays_on_faces(body); }
  Supports& supports(std::uint32_t body) { return world_.supports_[body]; }
  LastingContact lasting_contact(std::uint32_t body, std::uint32_t feature) const {
    const SurfaceLaw& law = world_.scene_.contacts.between(constants(body).material,
                                                           statics().material_of_feature(feature));
    return {.normal = normal_at(statics().feature(feature), place_m(body)),
            .friction = statics().friction_at(feature, place_m(body), law.friction),
            .rolling_friction = law.rolling_friction};
  }
  bool stands(std::uint32_t body, std::span<const LastingContact> contacts) const {
    return stands_on(round_body(body), contacts, gravity_mps2());
  }
  Tick slow_from(std::uint32_t body, const Segment& segment, Tick end) const {
    return physics::slow_from(segment, reach_m(body), constants(body).inertia, slow(), end);
  }

  FreeFlight flight_after(std::uint32_t body, const Twist& twist) {
    return world_.segment_after(body, tick(), place_m(body), twist).flight;
  }
  void begin_segment(std::uint32_t body, const Segment& segment) {
    world_.begin_segment(body, segment, event_);
    world_.changed_.push_back(body);
  }
  void begin_after(std::uint32_t body, const Twist& twist) {
    begin_segment(body, {.flight = flight_after(body, twist)});
  }
  void begin_rest(std::uint32_t body) {
    Segment segment{.flight = flight_after(body, {}), .mode = MotionMode::resting};
    segment.flight.acceleration_mps2 = Vec3::Zero();
    begin_segment(body, segment);
  }

  std::uint32_t count(std::uint32_t body) { return world_.count_at(body, tick()); }
  void meets(std::uint32_t a, std::uint32_t b, double gap_m) {
    world_.recent_.note(a, b, tick(), gap_m);
    if (world_.history_builder_) world_.history_builder_->meet(gap_m);
    if (world_.supports_.empty()) return;
    supports(a).met_body = tick();
    supports(b).met_body = tick();
  }
  void touches(std::uint32_t body, const TouchRecord& touch, bool slowly) {
    world_.note_touch(body, touch, slowly);
  }
  ImpactOutput impact(std::uint32_t a, std::uint32_t b, const PieceContact& contact,
                      const ContactLaw& law, bool a_fixed, bool b_fixed) {
    if (is_round(a) && is_round(b)) {
      return sphere_impact({.mass_a = a_fixed ? SphereMass{} : constants(a).sphere_mass,
                            .mass_b = b_fixed ? SphereMass{} : constants(b).sphere_mass,
                            .a = twist(a),
                            .b = twist(b),
                            .normal = contact.normal,
                            .law = law});
    }
    return rigid_impact({.a = a_fixed ? RigidImpactBody{} : world_.rigid_body(a, tick()),
                         .b = b_fixed ? RigidImpactBody{} : world_.rigid_body(b, tick()),
                         .contact_m = contact.point_m,
                         .normal = contact.normal,
                         .law = law});
  }
  Twist impact_on_static(std::uint32_t body, const Twist& before, const PieceContact& contact,
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
                         .b = world_.rigid_body(body, tick()),
                         .contact_m = contact.point_m,
                         .normal = contact.normal,
                         .law = law})
        .b;
  }

  Twist leaving(std::uint32_t body, const PieceContact& contact, const Twist& twist) {
    const double speed_mps = contact::hop_speed_mps(slow());
    if (is_round(body)) return hop(round_body(body), contact.normal, twist, speed_mps);
    if (!constants(body).has_round_parts) return twist;
    RigidImpactBody leaver = world_.rigid_body(body, tick());
    leaver.twist = twist;
    return rigid_hop(leaver, contact.point_m, contact.normal, speed_mps);
  }

  void notes_corners(std::uint32_t body) {
    if (is_round(body)) return;
    if (stays(body)) world_.note_plane_supports(body, tick());
    world_.note_near_corners(body, tick());
  }
  void learns(std::uint32_t body) { world_.note_contact_state(body); }
  /// Its partners are asked next, and it may come to rest on them.
  void is_asked(std::uint32_t member, std::uint32_t /*asker*/) {
    learns(member);
    resting().for_each_partner(member, tick(), [&](std::uint32_t partner) {
      world_.make_live(partner);
      if (world_.history_builder_) world_.history_builder_->takes_part(partner);
    });
  }
  void is_read(std::uint32_t member, std::uint32_t /*asker*/) {
    if (world_.history_builder_) world_.history_builder_->takes_part(member);
  }
  void wakes(std::uint32_t body, std::uint32_t /*from*/, bool /*rested*/) {
    world_.make_live(body);
    learns(body);
  }

 private:
  const BodyConstants& constants(std::uint32_t body) const { return world_.constants_[body]; }

  World& world_;
  const EventKey& event_;
};

}  // namespace sleight::physics
