// What collisions, lasting contacts and rest do to marbles: the rules of contact_events.h over
// their table.
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

std::uint32_t Marbles::count_at(BodyId ball, Tick tick) {
  CollisionCount& collided = balls_[ball].collided;
  const std::uint32_t count = collided.add(tick);
  if (collided.is_too_much()) {
    fail(SceneError::Kind::too_many_collisions,
         fmt::format("{}: {} at tick {} ({:.9g} s)", name(ball), words_of_too_much(collided, true),
                     tick.value, seconds(tick - Tick{})));
  }
  return count;
}

// ---- as contact_events.h asks for them ----------------------------------------------------------

class Marbles::AtEvent {
 public:
  AtEvent(Marbles& marbles, Tick tick) : marbles_(marbles), tick_(tick) {}

  Tick tick() const { return tick_; }
  std::vector<BodyId>& changed() { return marbles_.changed_; }
  Resting& resting() { return marbles_.resting_; }
  const StaticGeometry& statics() const { return *marbles_.statics_; }
  const SlowContacts& slow() const { return marbles_.scene_->slow; }
  const Vec3& gravity_mps2() const { return marbles_.scene_->gravity_mps2; }
  TickCount alone_for() const { return marbles_.alone_for_; }

  bool is_resting(BodyId ball) const { return marbles_.is_resting(ball); }
  bool is_round(BodyId /*ball*/) const { return true; }
  /// Kept, as an event asks several times where its ball is.
  const Vec3& place_m(BodyId ball) {
    if (ball != placed_) {
      placed_ = ball;
      place_m_ = marbles_.place_at(ball, tick_);
    }
    return place_m_;
  }
  Twist twist(BodyId ball) const { return marbles_.twist_at(ball, tick_); }
  Pose place_of_rest(BodyId ball) { return {place_m(ball), Quat::Identity()}; }
  double reach_m(BodyId /*ball*/) const { return marbles_.radius_m_; }
  double mass_kg(BodyId /*ball*/) const { return marbles_.inertia_.mass_kg; }
  double fastest_point_mps(BodyId /*ball*/, const Twist& twist) const {
    return physics::fastest_point_mps(marbles_.radius_m_, twist);
  }

  const RoundBody& round_body(BodyId /*ball*/) const { return marbles_.round_; }
  bool may_stay(BodyId /*ball*/) const { return marbles_.contacts_last_; }
  bool may_lie(BodyId /*ball*/, StaticId /*feature*/) const { return false; }
  std::optional<std::uint32_t> face_met(StaticId /*feature*/, const Vec3& /*normal*/) const {
    return std::nullopt;
  }
  std::optional<PlaneStay> lying(BodyId /*ball*/, StaticId /*feature*/, std::uint32_t /*face*/,
                                 const Twist& /*twist*/) const {
    return std::nullopt;
  }
  Twist lifted(BodyId /*ball*/, const Twist& twist) const { return twist; }
  bool stays(BodyId ball) const { return in_contact(marbles_.balls_[ball].segment); }
  Supports& supports(BodyId ball) { return marbles_.balls_[ball].supports; }
  LastingContact lasting_contact(BodyId ball, FeatureId feature) {
    const SurfaceLaw& law = marbles_.scene_->contacts.between(
        marbles_.material_, statics().material_of_feature(feature));
    return {.normal = normal_at(statics().feature(feature), place_m(ball)),
            .friction = statics().friction_at({feature}, place_m(ball), law.friction),
            .rolling_friction = law.rolling_friction};
  }
  /// How it would move from rest hangs on normals and friction, and those of faces stay as they
  /// are.
  bool stands(BodyId ball, std::span<const LastingContact> contacts) {
    Marble& own = marbles_.balls_[ball];
    const bool same =
        own.stance_tick == tick_ || std::ranges::all_of(own.supports.all(), [&](StaticId met) {
          return statics().feature({met}).kind == FeatureKind::face &&
                 statics().friction_map(met) == nullptr;
        });
    if (own.stance == Marble::Stance::unknown || !same) {
      own.stance_tick = tick_;
      own.stance = stands_on(marbles_.round_, contacts, gravity_mps2()) ? Marble::Stance::stands
                                                                        : Marble::Stance::moves;
    }
    return own.stance == Marble::Stance::stands;
  }
  Tick slow_from(BodyId /*ball*/, const Segment& segment, Tick end) const {
    return physics::slow_from(segment, marbles_.radius_m_, marbles_.inertia_, slow(), end);
  }

  FreeFlight flight_after(BodyId ball, const Twist& twist) {
    return {.begin = tick_,
            .position_m = place_m(ball),
            .velocity_mps = twist.velocity_mps,
            .acceleration_mps2 = gravity_mps2(),
            .orientation = marbles_.balls_[ball].segment.flight.orientation,
            .angular_velocity_radps = twist.angular_velocity_radps};
  }
  void begin_segment(BodyId ball, const Segment& segment) {
    placed_ = k_none;
    marbles_.begin_segment(ball, segment);
  }
  void begin_after(BodyId ball, const Twist& twist) {
    Segment& segment = marbles_.balls_[ball].segment;
    // Its orientation stays.
    segment.flight.position_m = place_m(ball);
    segment.flight.begin = tick_;
    segment.flight.velocity_mps = twist.velocity_mps;
    segment.flight.acceleration_mps2 = gravity_mps2();
    segment.flight.angular_velocity_radps = twist.angular_velocity_radps;
    segment.angular_acceleration_radps2 = Vec3::Zero();
    segment.mode = MotionMode::free;
    marbles_.segment_begun(ball);
  }
  void begin_rest(BodyId ball) {
    Segment segment{.flight = flight_after(ball, {}), .mode = MotionMode::resting};
    segment.flight.acceleration_mps2 = Vec3::Zero();
    begin_segment(ball, segment);
  }

  std::uint32_t count(BodyId ball) { return marbles_.count_at(ball, tick_); }
  const CollisionCount& collided(BodyId ball) const { return marbles_.balls_[ball].collided; }
  void meets(BodyId a, BodyId b, double gap_m) {
    marbles_.recent_.note(a, b, tick_, gap_m);
    if (marbles_.records_) marbles_.keep_meeting(a, b);
    if (marbles_.contacts_last_) supports(a).met_body = supports(b).met_body = tick_;
  }
  void touches(BodyId ball, const TouchRecord& touch, bool slowly) {
    resting().touched(ball, touch, slowly);
  }
  ImpactOutput impact(BodyId a, BodyId b, const PieceContact& contact, const ContactLaw& law,
                      bool a_fixed, bool b_fixed) const {
    return sphere_impact({.mass_a = a_fixed ? SphereMass{} : marbles_.mass_,
                          .mass_b = b_fixed ? SphereMass{} : marbles_.mass_,
                          .a = twist(a),
                          .b = twist(b),
                          .normal = contact.normal,
                          .law = law});
  }
  Twist impact_on_static(BodyId /*ball*/, const Twist& before, const PieceContact& contact,
                         const ContactLaw& law) const {
    return sphere_impact({.mass_a = {},
                          .mass_b = marbles_.mass_,
                          .a = {},
                          .b = before,
                          .normal = contact.normal,
                          .law = law})
        .b;
  }
  Twist leaving(BodyId /*ball*/, const PieceContact& contact, const Twist& twist) const {
    return hop(marbles_.round_, contact.normal, twist, contact::hop_speed_mps(slow()));
  }

  void notes_corners(BodyId /*ball*/) {}
  void goes_live(BodyId /*ball*/) {}
  void reads(BodyId ball, BodyId other) {
    if (marbles_.records_ && ball != other) marbles_.keep_meeting(ball, other);
  }
  void learns(BodyId /*ball*/) {}

 private:
  Marbles& marbles_;
  Tick tick_;
  BodyId placed_ = k_none;
  Vec3 place_m_;  ///< of that one
};

// ---- what happens -------------------------------------------------------------------------------

void Marbles::collide(BodyId a, BodyId b, Tick tick) {
  static_assert(contact::BodiesAtEvent<AtEvent>);
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
  const bool plastic = count_at(ball, tick) > k_elastic_at_a_tick;
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
  contact::change_mode(at, ball, balls_[ball].segment.mode == MotionMode::rolling);
}

std::size_t Marbles::rest(BodyId ball, Tick tick) {
  AtEvent at(*this, tick);
  return contact::rest(at, ball);
}

}  // namespace sleight::physics
