// What collisions, lasting contacts and rest do to marbles: as World does it (world_collisions.cpp,
// world_modes.cpp, world_rest.cpp), for equal balls.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "worker/physics/marbles/marbles.h"

namespace sleight::physics {
namespace {

/// How fast the two sides of a contact part.
double parting_mps(const Vec3& normal, const Vec3& arm_a_m, const Twist& a, const Vec3& arm_b_m,
                   const Twist& b) {
  const Vec3 of_a = a.velocity_mps + math::cross(a.angular_velocity_radps, arm_a_m);
  const Vec3 of_b = b.velocity_mps + math::cross(b.angular_velocity_radps, arm_b_m);
  return math::dot(normal, of_b - of_a);
}

}  // namespace

// ---- motion -------------------------------------------------------------------------------------

Twist Marbles::twist_at(std::uint32_t ball, Tick tick) const {
  const Segment& segment = balls_[ball].segment;
  if (in_contact(segment) && !is_zero(balls_[ball].half_way))
    return twist_over_edge(round_, segment, balls_[ball].half_way, scene_->gravity_mps2, tick);
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
  ball.support_count = 0;
  ball.stance = Marble::Stance::unknown;
  ball.mode_end = k_never;
  last_event_[index] = segment.flight.begin;
  changed_.push_back(index);
}

/// A ball flies on from an event with another twist.
void Marbles::begin_after(std::uint32_t ball, const Vec3& place_m, const Twist& twist, Tick tick) {
  begin_segment(ball, {.flight = {.begin = tick,
                                  .position_m = place_m,
                                  .velocity_mps = twist.velocity_mps,
                                  .acceleration_mps2 = scene_->gravity_mps2,
                                  .orientation = balls_[ball].segment.flight.orientation,
                                  .angular_velocity_radps = twist.angular_velocity_radps}});
}

// ---- collisions ---------------------------------------------------------------------------------

ContactLaw Marbles::law_of(MaterialId other, bool plastic) const {
  const SurfaceLaw& law = scene_->contacts.between(material_, other);
  if (plastic) return {.restitution = 0, .friction = law.friction};
  return {.restitution = law.restitution,
          .friction = law.friction,
          .separation_speed_floor_mps = scene_->slow.separation_speed_mps};
}

std::uint32_t Marbles::count_at(std::uint32_t index, Tick tick) {
  Marble& ball = balls_[index];
  ball.at_tick_count = ball.at_tick == tick ? ball.at_tick_count + 1 : 1;
  ball.at_tick = tick;
  const auto note = [&](std::string what) {
    fail(SceneError::Kind::too_many_collisions,
         fmt::format("{}: {} at tick {} ({:.9g} s)", name(index), what, tick.value,
                     seconds(tick - Tick{})));
  };
  if (ball.at_tick_count > k_events_at_a_tick_max)
    note(fmt::format("it collides more than {} times at one tick", k_events_at_a_tick_max));
  if (tick - ball.window > k_window) {
    ball.window = tick;
    ball.window_count = 0;
  }
  if (++ball.window_count > k_collisions_in_window_max) {
    note(
        fmt::format("it collides more than {} times in a millisecond; a much heavier body squeezes "
                    "it, or it is wedged",
                    k_collisions_in_window_max));
  }
  return ball.at_tick_count;
}

void Marbles::collide(std::uint32_t a, std::uint32_t b, Tick tick) {
  changed_.clear();
  const Vec3 place_a_m = place_at(a, tick);
  const Vec3 place_b_m = place_at(b, tick);
  const Vec3 between_m = place_b_m - place_a_m;
  const double distance_m = math::norm(between_m);
  const double gap_m = distance_m - (radius_m_ + radius_m_);
  const Vec3 normal = between_m / distance_m;
  const Vec3 point_m = place_a_m + radius_m_ * normal;
  const bool plastic = std::max(count_at(a, tick), count_at(b, tick)) > k_elastic_at_a_tick;
  const ContactLaw law = law_of(material_, plastic);
  recent_.note(a, b, tick, gap_m);
  if (records_) keep_meeting(a, b);
  if (contacts_last_) balls_[a].met_body = balls_[b].met_body = tick;
  bool a_rests = is_resting(a);
  bool b_rests = is_resting(b);
  const Twist before_a = twist_at(a, tick);
  const Twist before_b = twist_at(b, tick);
  const auto impact = [&](bool a_fixed, bool b_fixed) {
    return sphere_impact({.mass_a = a_fixed ? SphereMass{} : mass_,
                          .mass_b = b_fixed ? SphereMass{} : mass_,
                          .a = before_a,
                          .b = before_b,
                          .normal = normal,
                          .law = law});
  };
  ImpactOutput after = impact(a_rests, b_rests);
  if (a_rests || b_rests) {
    // A blow that is hard enough wakes the resting one, which then takes part.
    const std::uint32_t sleeper = a_rests ? a : b;
    const double jump_mps = math::norm(after.impulse_ns) / inertia_.mass_kg;
    if (jump_mps > resting_.wake_speed_mps()) {
      a_rests = false;
      b_rests = false;
      after = impact(false, false);
      wake_dependents(sleeper, tick);
    }
  }
  // What rolls along a resting body has no slip to pay its bounces from.
  if (a_rests != b_rests) {
    Twist& twist = a_rests ? after.b : after.a;
    twist = hop(round_, a_rests ? normal : Vec3(-normal), twist, hop_speed_mps());
  }
  if (resting_.enabled()) {
    const Vec3 arm_a_m = point_m - place_a_m;
    const Vec3 arm_b_m = point_m - place_b_m;
    const double parting = parting_mps(normal, arm_a_m, after.a, arm_b_m, after.b);
    const auto note = [&](std::uint32_t ball, std::uint32_t partner, const Vec3& outwards,
                          const Vec3& arm_m, const Twist& before, const Twist& then) {
      resting_.touched(ball,
                       {.tick = tick,
                        .partner = partner,
                        .friction = law.friction,
                        .normal = outwards,
                        .arm_m = arm_m},
                       fastest_point_mps(radius_m_, before), fastest_point_mps(radius_m_, then),
                       parting);
    };
    if (!a_rests) note(a, b, -normal, arm_a_m, before_a, after.a);
    if (!b_rests) note(b, a, normal, arm_b_m, before_b, after.b);
  }
  if (!a_rests) begin_after(a, place_a_m, after.a, tick);
  if (!b_rests) begin_after(b, place_b_m, after.b, tick);
  wake_on_those_that_left(tick);
}

void Marbles::collide_static(std::uint32_t ball, std::uint32_t feature, Tick tick) {
  changed_.clear();
  balls_[ball].last_feature = feature;
  const Vec3 place_m = place_at(ball, tick);
  const Vec3 normal = normal_at(statics_->feature(feature), place_m);
  ContactLaw law =
      law_of(statics_->material_of_feature(feature), count_at(ball, tick) > k_elastic_at_a_tick);
  const Twist before = twist_at(ball, tick);
  const double approach_mps = -math::dot(normal, before.velocity_mps);
  const bool caught = is_caught(ball, feature, approach_mps, law.restitution, before, tick);
  if (caught) law = {.restitution = 0, .friction = law.friction};
  ImpactOutput after = sphere_impact(
      {.mass_a = {}, .mass_b = mass_, .a = {}, .b = before, .normal = normal, .law = law});
  if (!caught) after.b = hop(round_, normal, after.b, hop_speed_mps());
  if (resting_.enabled()) {
    const Vec3 point_m = place_m - radius_m_ * normal;
    const Vec3 arm_m = point_m - place_m;
    resting_.touched(ball,
                     {.tick = tick,
                      .partner = k_static_partner,
                      .feature = feature,
                      .friction = law.friction,
                      .normal = normal,
                      .arm_m = arm_m},
                     fastest_point_mps(radius_m_, before), fastest_point_mps(radius_m_, after.b),
                     parting_mps(normal, point_m, {}, arm_m, after.b));
  }
  if (caught) {
    begin_caught(ball, feature, place_m, after.b, tick);
  } else {
    begin_after(ball, place_m, after.b, tick);
  }
  wake_on_those_that_left(tick);
}

// ---- lasting contact ----------------------------------------------------------------------------

bool Marbles::is_caught(std::uint32_t ball, std::uint32_t feature, double approach_mps,
                        double restitution, const Twist& twist, Tick tick) const {
  if (!contacts_last_) return false;
  const double slow_mps = scene_->slow.separation_speed_mps;
  if (restitution * approach_mps >= slow_mps || tick - balls_[ball].met_body < alone_for_)
    return false;
  return statics_->feature(feature).kind == FeatureKind::face ||
         math::norm(twist.velocity_mps) < k_edge_speeds * slow_mps;
}

LastingContact Marbles::lasting_contact(std::uint32_t feature, const Vec3& place_m) const {
  const SurfaceLaw& law =
      scene_->contacts.between(material_, statics_->material_of_feature(feature));
  return {.normal = normal_at(statics_->feature(feature), place_m),
          .friction = law.friction,
          .rolling_friction = law.rolling_friction};
}

void Marbles::begin_on_faces(std::uint32_t index, const MayStayOn& on, const Vec3& place_m,
                             const Begun& with, Tick tick) {
  const FreeFlight now{.begin = tick,
                       .position_m = place_m,
                       .velocity_mps = with.twist.velocity_mps,
                       .acceleration_mps2 = scene_->gravity_mps2,
                       .orientation = balls_[index].segment.flight.orientation,
                       .angular_velocity_radps = with.twist.angular_velocity_radps};
  const auto stay =
      stay_on(round_, on, now,
              {.statics = *statics_, .slow = scene_->slow, .gravity_mps2 = scene_->gravity_mps2});
  if (!stay) {
    resting_.flies(index, tick);
    begin_after(index, place_m, with.otherwise, tick);
    return;
  }
  begin_segment(index, stay->segment);
  Marble& ball = balls_[index];
  for (std::size_t i = 0; i < on.features.size(); ++i) {
    if ((stay->subset >> i & 1U) != 0) ball.supports[ball.support_count++] = on.features[i];
  }
  ball.mode_end = stay->end;
  ball.leaves = stay->leaves;
  ball.half_way = stay->half_way;
  if (!resting_.enabled()) return;
  resting_.stays(index, tick,
                 slow_from(ball.segment, radius_m_, inertia_, scene_->slow, ball.mode_end));
}

void Marbles::begin_caught(std::uint32_t index, std::uint32_t feature, const Vec3& place_m,
                           const Twist& twist, Tick tick) {
  std::array<std::uint32_t, 3> features{feature};
  std::array<LastingContact, 3> contacts{lasting_contact(feature, place_m)};
  std::size_t count = 1;
  for (const std::uint32_t other : balls_[index].all_supports()) {
    if (other == feature || count == features.size()) continue;
    contacts[count] = lasting_contact(other, place_m);
    features[count++] = other;
  }
  const Caught caught = caught_by(round_, std::span(contacts).first(count), twist, scene_->slow);
  begin_on_faces(index,
                 {.features = std::span(features).first(caught.count),
                  .contacts = std::span(contacts).first(caught.count)},
                 place_m, {.twist = caught.twist, .otherwise = caught.otherwise}, tick);
}

void Marbles::change_mode(std::uint32_t index, Tick tick) {
  changed_.clear();
  const Marble& ball = balls_[index];
  const bool rolled = ball.segment.mode == MotionMode::rolling;
  const Twist twist = twist_at(index, tick);
  const Vec3 place_m = place_at(index, tick);
  // Over the border of one: what lies there is met as anything else, at once if it goes on level.
  std::array<std::uint32_t, 3> features{};
  std::array<LastingContact, 3> contacts;
  std::size_t count = 0;
  for (const std::uint32_t feature : ball.all_supports()) {
    if (feature == ball.leaves) continue;
    contacts[count] = lasting_contact(feature, place_m);
    features[count++] = feature;
  }
  begin_on_faces(index,
                 {.features = std::span(features).first(count),
                  .contacts = std::span(contacts).first(count),
                  .rolled = rolled},
                 place_m, {.twist = twist, .otherwise = twist}, tick);
  wake_on_those_that_left(tick);
}

// ---- rest ---------------------------------------------------------------------------------------

std::size_t Marbles::rest(std::uint32_t index, Tick tick) {
  changed_.clear();
  const auto present = [&](std::uint32_t member) {
    if (records_) {
      if (member != index) keep_meeting(index, member);
      resting_.for_each_partner(member, tick,
                                [&](std::uint32_t partner) { keep_meeting(member, partner); });
    }
    Marble& ball = balls_[member];
    Resting::Present state{.speed_mps = fastest_point_mps(radius_m_, twist_at(member, tick)),
                           .weight_n = inertia_.mass_kg * scene_->gravity_mps2,
                           .reach_m = radius_m_,
                           .centre_m = place_at(member, tick),
                           .round = true};
    if (!in_contact(ball.segment)) return state;
    const Vec3 place_m = place_at(member, tick);
    std::array<LastingContact, 3> contacts;
    for (std::uint32_t i = 0; i < ball.support_count; ++i) {
      contacts[i] = lasting_contact(ball.supports[i], place_m);
      resting_.still_touches(member, {.tick = tick,
                                      .partner = k_static_partner,
                                      .feature = ball.supports[i],
                                      .friction = contacts[i].friction,
                                      .normal = contacts[i].normal,
                                      .arm_m = -radius_m_ * contacts[i].normal});
    }
    // How it would move from rest hangs on the normals alone, and those of faces stay as they are.
    const bool same = ball.stance_tick == tick ||
                      std::ranges::all_of(ball.all_supports(), [&](std::uint32_t feature) {
                        return statics_->feature(feature).kind == FeatureKind::face;
                      });
    if (ball.stance == Marble::Stance::unknown || !same) {
      ball.stance_tick = tick;
      const bool stands =
          stands_on(round_, std::span(contacts).first(ball.support_count), scene_->gravity_mps2);
      ball.stance = stands ? Marble::Stance::stands : Marble::Stance::moves;
    }
    if (ball.stance == Marble::Stance::stands) {
      state.stance = Resting::Stance::holds;
    } else if (resting_.touched_only(member, tick, ball.all_supports())) {
      state.stance = Resting::Stance::slides;
    }
    return state;
  };
  for (const std::uint32_t member : resting_.decide(index, tick, present)) {
    begin_segment(member, {.flight = {.begin = tick,
                                      .position_m = place_at(member, tick),
                                      .orientation = balls_[member].segment.flight.orientation},
                           .mode = MotionMode::resting});
  }
  const std::size_t count = changed_.size();
  if (count == 0 && has_left(index, tick)) {
    resting_.leave(index);
    wake_dependents(index, tick);
  }
  return count;
}

void Marbles::wake_dependents(std::uint32_t ball, Tick tick) {
  for (const std::uint32_t dependent : resting_.wake(ball)) {
    if (!is_resting(dependent)) continue;
    if (records_) keep_meeting(ball, dependent);
    begin_after(dependent, place_at(dependent, tick), {}, tick);
    resting_.woke(dependent, tick, {place_at(dependent, tick), Quat::Identity()});
  }
}

bool Marbles::has_left(std::uint32_t ball, Tick tick) {
  if (!resting_.in_place(ball)) return false;
  return resting_.has_left(ball, {place_at(ball, tick), Quat::Identity()},
                           fastest_point_mps(radius_m_, twist_at(ball, tick)), radius_m_);
}

void Marbles::wake_on_those_that_left(Tick tick) {
  // The list grows by the balls that wake; these are still in their places.
  for (std::size_t i = 0; i < changed_.size(); ++i) {
    const std::uint32_t ball = changed_[i];
    if (is_resting(ball) || !has_left(ball, tick)) continue;
    resting_.leave(ball);
    wake_dependents(ball, tick);
  }
  std::sort(changed_.begin(), changed_.end());
}

}  // namespace sleight::physics
