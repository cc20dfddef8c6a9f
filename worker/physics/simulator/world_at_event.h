// The world's bodies at an event, in the form that contact_events.h uses.
//
// Only the sources of World include this header. Thread safety: none.
#pragma once

#include "worker/physics/contact/contact_events.h"
#include "worker/physics/simulator/world.h"

namespace sleight::physics {

class World::AtEvent : public contact::Event {
 public:
  AtEvent(World& world, const EventKey& event)
      : Event{.tick = event.tick,
              .changed = world.changed_,
              .resting = world.resting_,
              .scene = {.statics = world.statics_.geometry(),
                        .slow = world.scene().slow,
                        .gravity_mps2 = world.scene().gravity_mps2},
              .contacts = world.scene().contacts,
              .may_stay = world.bodies_.may_stay(),
              .alone_for = world.alone_for_},
        world_(world),
        event_(event) {}

  const BodyConstants& body(BodyId body) const { return world_.bodies_.constants(body); }
  RoundBody round_body(BodyId body) const { return world_.bodies_.round_body(body); }

  MotionMode mode(BodyId body) const { return world_.bodies_.mode(body); }
  Vec3 place_m(BodyId body) const { return world_.bodies_.position_at(body, tick); }
  Twist twist(BodyId body) { return world_.bodies_.twist_at(body, tick); }
  RigidImpactBody rigid_body(BodyId body) { return world_.bodies_.rigid_body(body, tick); }
  Supports& supports(BodyId body) { return world_.bodies_.supports_of(body); }
  bool stands(BodyId body, std::span<const LastingContact> on) const {
    return stands_on(round_body(body), on, scene.gravity_mps2);
  }
  std::optional<PlaneStay> lying(BodyId body, StaticId met, std::uint32_t face,
                                 const Twist& twist) {
    return world_.stay_of(body, met, face, twist, tick);
  }

  FreeFlight flight_after(BodyId body, const Twist& twist) {
    return world_.bodies_.segment_after(body, tick, place_m(body), twist).flight;
  }
  void begin_after(BodyId body, const Twist& twist) {
    begin_segment(body, {.flight = flight_after(body, twist)});
  }
  void begin_segment(BodyId body, const Segment& segment) {
    world_.begin_segment(body, segment, event_);
    changed.push_back(body);
  }

  const CollisionCount& count(BodyId body) { return world_.count_at(body, tick); }
  void meets(BodyId a, BodyId b, double gap_m) {
    world_.predictions_.have_collided(a, b, tick, gap_m);
    world_.recorder_.meets(gap_m);
  }
  void touches(BodyId body, const TouchRecord& touch, bool slowly) {
    resting.touched(body, touch, slowly);
    world_.recorder_.touches(body, touch, slowly);
  }
  void notes_corners(BodyId body) {
    if (world_.bodies_.stays_on_faces(body)) world_.note_plane_supports(body, tick);
    world_.note_near_corners(body, tick);
  }

  std::optional<ImpactNoise> take_noise() { return world_.take_noise(); }

  void goes_live(BodyId body) { world_.replayed_.make_live(body); }
  void reads(BodyId /*body*/, BodyId other) { world_.recorder_.takes_part(other); }
  void learns(BodyId body) { world_.recorder_.learns(body); }

 private:
  World& world_;
  const EventKey& event_;
};

}  // namespace sleight::physics
