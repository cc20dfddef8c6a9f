// Applies the rules of contact_events.h to marbles: collisions, lasting contacts and rest.
#include <fmt/format.h>

#include <algorithm>

#include "worker/physics/contact/contact_events.h"
#include "worker/physics/marbles/marbles.h"

namespace sleight::physics {

// ---- motion -------------------------------------------------------------------------------------

Twist Marbles::twist_at(BodyId ball, Tick tick) const {
  const Segment& segment = balls_[ball].segment;
  const Vec3& half_way = balls_[ball].supports.half_way;
  if (in_contact(segment) && !is_zero(half_way))
    return twist_over_edge(round_, segment, half_way, scene_->gravity_mps2, tick);
  Twist twist{.velocity_mps = velocity_at(segment.flight, tick),
              .angular_velocity_radps = segment.flight.angular_velocity_radps};
  if (in_contact(segment)) {
    twist.angular_velocity_radps +=
        seconds(tick - segment.flight.begin) * segment.angular_acceleration_radps2;
  }
  return twist;
}

void Marbles::begin_segment(BodyId ball, const Segment& segment) {
  balls_[ball].segment = segment;
  segment_begun(ball);
}

void Marbles::segment_begun(BodyId index) {
  Marble& ball = balls_[index];
  ball.supports.count = 0;
  ball.supports.end = k_never;
  ball.stance = Marble::Stance::unknown;
  last_event_[index] = ball.segment.flight.begin;
  changed_.push_back(index);
}

const CollisionCount& Marbles::count_at(BodyId ball, Tick tick) {
  CollisionCount& collided = balls_[ball].collided;
  collided.add(tick);
  if (collided.is_too_much()) {
    fail(SceneError::Kind::too_many_collisions,
         fmt::format("{}: {} at tick {} ({:.9g} s)", name(ball), words_of_too_much(collided, true),
                     tick.value, seconds(tick - Tick{})));
  }
  return collided;
}

// ---- the functions that contact_events.h requires -----------------------------------------------

class Marbles::AtEvent : public contact::Event {
 public:
  AtEvent(Marbles& marbles, Tick now)
      : Event{.tick = now,
              .changed = marbles.changed_,
              .resting = marbles.resting_,
              .scene = {.statics = *marbles.statics_,
                        .slow = marbles.scene_->slow,
                        .gravity_mps2 = marbles.scene_->gravity_mps2},
              .contacts = marbles.scene_->contacts,
              .may_stay = marbles.contacts_last_,
              .alone_for = marbles.alone_for_},
        marbles_(marbles) {}

  /// All balls have the same properties.
  struct Ball {
    double reach_m;
    const Inertia& inertia;
    const SphereMass& sphere_mass;
    MaterialId material;
  };
  Ball body(BodyId /*ball*/) const {
    return {.reach_m = marbles_.radius_m_,
            .inertia = marbles_.inertia_,
            .sphere_mass = marbles_.mass_,
            .material = marbles_.material_};
  }
  const RoundBody& round_body(BodyId /*ball*/) const { return marbles_.round_; }

  MotionMode mode(BodyId ball) const { return marbles_.balls_[ball].segment.mode; }
  /// Cached, since an event uses its ball's position several times.
  const Vec3& place_m(BodyId ball) {
    if (ball != placed_) {
      placed_ = ball;
      place_m_ = marbles_.place_at(ball, tick);
    }
    return place_m_;
  }
  Twist twist(BodyId ball) const { return marbles_.twist_at(ball, tick); }
  Supports& supports(BodyId ball) { return marbles_.balls_[ball].supports; }
  /// Cached. The motion from rest depends only on normals and friction. Both are constant on faces
  /// without friction maps.
  bool stands(BodyId ball, std::span<const LastingContact> on) {
    Marble& own = marbles_.balls_[ball];
    const bool same =
        own.stance_tick == tick || std::ranges::all_of(own.supports.all(), [&](StaticId met) {
          return scene.statics.feature({met}).kind == FeatureKind::face &&
                 scene.statics.friction_map(met) == nullptr;
        });
    if (own.stance == Marble::Stance::unknown || !same) {
      own.stance_tick = tick;
      own.stance = stands_on(marbles_.round_, on, scene.gravity_mps2) ? Marble::Stance::stands
                                                                      : Marble::Stance::moves;
    }
    return own.stance == Marble::Stance::stands;
  }

  FreeFlight flight_after(BodyId ball, const Twist& twist) {
    return {.begin = tick,
            .position_m = place_m(ball),
            .velocity_mps = twist.velocity_mps,
            .acceleration_mps2 = scene.gravity_mps2,
            .orientation = marbles_.balls_[ball].segment.flight.orientation,
            .angular_velocity_radps = twist.angular_velocity_radps};
  }
  void begin_after(BodyId ball, const Twist& twist) {
    Segment& segment = marbles_.balls_[ball].segment;
    // The orientation stays.
    segment.flight.position_m = place_m(ball);
    segment.flight.begin = tick;
    segment.flight.velocity_mps = twist.velocity_mps;
    segment.flight.acceleration_mps2 = scene.gravity_mps2;
    segment.flight.angular_velocity_radps = twist.angular_velocity_radps;
    segment.angular_acceleration_radps2 = Vec3::Zero();
    segment.mode = MotionMode::free;
    marbles_.segment_begun(ball);
  }
  void begin_segment(BodyId ball, const Segment& segment) {
    placed_ = k_none;
    marbles_.begin_segment(ball, segment);
  }

  const CollisionCount& count(BodyId ball) { return marbles_.count_at(ball, tick); }
  void meets(BodyId a, BodyId b, double gap_m) {
    marbles_.recent_.note(a, b, tick, gap_m);
    reads(a, b);
  }
  void touches(BodyId ball, const TouchRecord& touch, bool slowly) {
    resting.touched(ball, touch, slowly);
  }

  void goes_live(BodyId /*ball*/) {}
  void reads(BodyId ball, BodyId other) {
    if (marbles_.records_ && ball != other) marbles_.keep_meeting(ball, other);
  }
  void learns(BodyId /*ball*/) {}

 private:
  Marbles& marbles_;
  BodyId placed_ = k_none;
  Vec3 place_m_;  ///< position of placed_
};

// ---- what happens -------------------------------------------------------------------------------

void Marbles::collide(BodyId a, BodyId b, Tick tick) {
  static_assert(contact::SpheresAtEvent<AtEvent> && !contact::AnyAtEvent<AtEvent>);
  const Vec3 place_a_m = place_at(a, tick);
  const Vec3 between_m = place_at(b, tick) - place_a_m;
  AtEvent at(*this, tick);
  contact::collide(at, a, b, contact_of_spheres(place_a_m, between_m, radius_m_, radius_m_),
                   scene_->contacts.between(material_, material_));
}

void Marbles::collide_static(BodyId ball, FeatureId feature, Tick tick) {
  balls_[ball].last_feature = feature;
  const Vec3 place_m = place_at(ball, tick);
  const Vec3 normal = normal_at(statics_->feature(feature), place_m);
  const SurfaceLaw& law =
      scene_->contacts.between(material_, statics_->material_of_feature(feature));
  const bool plastic = count_at(ball, tick).at_tick > k_elastic_at_a_tick;
  AtEvent at(*this, tick);
  contact::collide_static(
      at, ball, {feature}, {.normal = normal, .point_m = place_m - radius_m_ * normal},
      contact::law_of_impact(law.restitution,
                             statics_->friction_at({feature}, place_m, law.friction), scene_->slow,
                             plastic),
      resting_.enabled());
}

void Marbles::change_mode(BodyId ball, Tick tick) {
  AtEvent at(*this, tick);
  contact::change_mode(at, ball);
}

std::size_t Marbles::rest(BodyId ball, Tick tick) {
  AtEvent at(*this, tick);
  return contact::rest(at, ball);
}

}  // namespace sleight::physics
