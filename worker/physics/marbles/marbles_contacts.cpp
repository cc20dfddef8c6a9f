// What collisions, lasting contacts and rest do to marbles: the rules of contact_events.h over
// their table.
#include <fmt/format.h>

#include <algorithm>

#include "worker/physics/contact/contact_events.h"
#include "worker/physics/marbles/marbles.h"

namespace sleight::physics {

// ---- motion -------------------------------------------------------------------------------------

Twist Marbles::twist_at(std::uint32_t ball, Tick tick) const {
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

void Marbles::begin_segment(std::uint32_t index, const Segment& segment) {
  Marble& ball = balls_[index];
  ball.segment = segment;
  ball.supports.count = 0;
  ball.supports.end = k_never;
  ball.stance = Marble::Stance::unknown;
  last_event_[index] = segment.flight.begin;
  changed_.push_back(index);
}

std::uint32_t Marbles::count_at(std::uint32_t ball, Tick tick) {
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
  std::vector<std::uint32_t>& changed() { return marbles_.changed_; }
  Resting& resting() { return marbles_.resting_; }
  const StaticGeometry& statics() const { return *marbles_.statics_; }
  const SlowContacts& slow() const { return marbles_.scene_->slow; }
  const Vec3& gravity_mps2() const { return marbles_.scene_->gravity_mps2; }
  TickCount alone_for() const { return marbles_.alone_for_; }

  bool is_resting(std::uint32_t ball) const { return marbles_.is_resting(ball); }
  bool is_round(std::uint32_t /*ball*/) const { return true; }
  Vec3 place_m(std::uint32_t ball) const { return marbles_.place_at(ball, tick_); }
  Twist twist(std::uint32_t ball) const { return marbles_.twist_at(ball, tick_); }
  Pose place_of_rest(std::uint32_t ball) const { return {place_m(ball), Quat::Identity()}; }
  double reach_m(std::uint32_t /*ball*/) const { return marbles_.radius_m_; }
  double mass_kg(std::uint32_t /*ball*/) const { return marbles_.inertia_.mass_kg; }
  double fastest_point_mps(std::uint32_t /*ball*/, const Twist& twist) const {
    return physics::fastest_point_mps(marbles_.radius_m_, twist);
  }

  const RoundBody& round_body(std::uint32_t /*ball*/) const { return marbles_.round_; }
  bool may_stay(std::uint32_t /*ball*/) const { return marbles_.contacts_last_; }
  bool may_lie(std::uint32_t /*ball*/, std::uint32_t /*feature*/) const { return false; }
  std::optional<std::uint32_t> face_met(std::uint32_t /*feature*/, const Vec3& /*normal*/) const {
    return std::nullopt;
  }
  std::optional<PlaneStay> lying(std::uint32_t /*ball*/, std::uint32_t /*feature*/,
                                 std::uint32_t /*face*/, const Twist& /*twist*/) const {
    return std::nullopt;
  }
  Twist lifted(std::uint32_t /*ball*/, const Twist& twist) const { return twist; }
  bool stays(std::uint32_t ball) const { return in_contact(marbles_.balls_[ball].segment); }
  Supports& supports(std::uint32_t ball) { return marbles_.balls_[ball].supports; }
  LastingContact lasting_contact(std::uint32_t ball, std::uint32_t feature) const {
    const SurfaceLaw& law = marbles_.scene_->contacts.between(
        marbles_.material_, statics().material_of_feature(feature));
    return {.normal = normal_at(statics().feature(feature), place_m(ball)),
            .friction = statics().friction_at(feature, place_m(ball), law.friction),
            .rolling_friction = law.rolling_friction};
  }
  /// How it would move from rest hangs on normals and friction, and those of faces stay as they
  /// are.
  bool stands(std::uint32_t ball, std::span<const LastingContact> contacts) {
    Marble& own = marbles_.balls_[ball];
    const bool same = own.stance_tick == tick_ ||
                      std::ranges::all_of(own.supports.all(), [&](std::uint32_t feature) {
                        return statics().feature(feature).kind == FeatureKind::face &&
                               statics().friction_map(feature) == nullptr;
                      });
    if (own.stance == Marble::Stance::unknown || !same) {
      own.stance_tick = tick_;
      own.stance = stands_on(marbles_.round_, contacts, gravity_mps2()) ? Marble::Stance::stands
                                                                        : Marble::Stance::moves;
    }
    return own.stance == Marble::Stance::stands;
  }
  Tick slow_from(std::uint32_t /*ball*/, const Segment& segment, Tick end) const {
    return physics::slow_from(segment, marbles_.radius_m_, marbles_.inertia_, slow(), end);
  }

  FreeFlight flight_after(std::uint32_t ball, const Twist& twist) const {
    return {.begin = tick_,
            .position_m = place_m(ball),
            .velocity_mps = twist.velocity_mps,
            .acceleration_mps2 = gravity_mps2(),
            .orientation = marbles_.balls_[ball].segment.flight.orientation,
            .angular_velocity_radps = twist.angular_velocity_radps};
  }
  void begin_segment(std::uint32_t ball, const Segment& segment) {
    marbles_.begin_segment(ball, segment);
  }
  void begin_after(std::uint32_t ball, const Twist& twist) {
    begin_segment(ball, {.flight = flight_after(ball, twist)});
  }
  void begin_rest(std::uint32_t ball) {
    Segment segment{.flight = flight_after(ball, {}), .mode = MotionMode::resting};
    segment.flight.acceleration_mps2 = Vec3::Zero();
    begin_segment(ball, segment);
  }

  std::uint32_t count(std::uint32_t ball) { return marbles_.count_at(ball, tick_); }
  void meets(std::uint32_t a, std::uint32_t b, double gap_m) {
    marbles_.recent_.note(a, b, tick_, gap_m);
    if (marbles_.records_) marbles_.keep_meeting(a, b);
    if (marbles_.contacts_last_) supports(a).met_body = supports(b).met_body = tick_;
  }
  void touches(std::uint32_t ball, const TouchRecord& touch, bool slowly) {
    resting().touched(ball, touch, slowly);
  }
  ImpactOutput impact(std::uint32_t a, std::uint32_t b, const PieceContact& contact,
                      const ContactLaw& law, bool a_fixed, bool b_fixed) const {
    return sphere_impact({.mass_a = a_fixed ? SphereMass{} : marbles_.mass_,
                          .mass_b = b_fixed ? SphereMass{} : marbles_.mass_,
                          .a = twist(a),
                          .b = twist(b),
                          .normal = contact.normal,
                          .law = law});
  }
  Twist impact_on_static(std::uint32_t /*ball*/, const Twist& before, const PieceContact& contact,
                         const ContactLaw& law) const {
    return sphere_impact({.mass_a = {},
                          .mass_b = marbles_.mass_,
                          .a = {},
                          .b = before,
                          .normal = contact.normal,
                          .law = law})
        .b;
  }
  Twist leaving(std::uint32_t /*ball*/, const PieceContact& contact, const Twist& twist) const {
    return hop(marbles_.round_, contact.normal, twist, contact::hop_speed_mps(slow()));
  }

  void notes_corners(std::uint32_t /*ball*/) {}
  void learns(std::uint32_t /*ball*/) {}
  void is_asked(std::uint32_t member, std::uint32_t asker) {
    if (!marbles_.records_) return;
    if (member != asker) marbles_.keep_meeting(asker, member);
    resting().for_each_partner(
        member, tick_, [&](std::uint32_t partner) { marbles_.keep_meeting(member, partner); });
  }
  void is_read(std::uint32_t member, std::uint32_t asker) {
    if (marbles_.records_ && member != asker) marbles_.keep_meeting(asker, member);
  }
  void wakes(std::uint32_t ball, std::uint32_t from, bool rested) {
    if (marbles_.records_ && rested) marbles_.keep_meeting(from, ball);
  }

 private:
  Marbles& marbles_;
  Tick tick_;
};

// ---- what happens -------------------------------------------------------------------------------

void Marbles::collide(std::uint32_t a, std::uint32_t b, Tick tick) {
  static_assert(contact::Bodies<AtEvent>);
  const Vec3 place_a_m = place_at(a, tick);
  const Vec3 between_m = place_at(b, tick) - place_a_m;
  AtEvent at(*this, tick);
  contact::collide(at, a, b, contact_of_spheres(place_a_m, between_m, radius_m_, radius_m_),
                   scene_->contacts.between(material_, material_));
}

void Marbles::collide_static(std::uint32_t ball, std::uint32_t feature, Tick tick) {
  balls_[ball].last_feature = feature;
  const Vec3 place_m = place_at(ball, tick);
  const Vec3 normal = normal_at(statics_->feature(feature), place_m);
  const SurfaceLaw& law =
      scene_->contacts.between(material_, statics_->material_of_feature(feature));
  const bool plastic = count_at(ball, tick) > k_elastic_at_a_tick;
  AtEvent at(*this, tick);
  contact::collide_static(
      at, ball, feature, {.normal = normal, .point_m = place_m - radius_m_ * normal},
      contact::law_of_impact(law.restitution, statics_->friction_at(feature, place_m, law.friction),
                             scene_->slow, plastic),
      resting_.enabled());
}

void Marbles::change_mode(std::uint32_t ball, Tick tick) {
  AtEvent at(*this, tick);
  contact::change_mode(at, ball, balls_[ball].segment.mode == MotionMode::rolling);
}

std::size_t Marbles::rest(std::uint32_t ball, Tick tick) {
  AtEvent at(*this, tick);
  return contact::rest(at, ball);
}

}  // namespace sleight::physics
