#include <algorithm>

#include "worker/physics/contact/contact_events.h"
#include "worker/physics/simulator/world.h"
#include "worker/physics/simulator/world_at_event.h"

namespace sleight::physics {
namespace {

Vec3 on_path_m(const Path& path, Tick tick) {
  const double s = seconds(tick - path.begin);
  Vec3 place_m;
  for (int i = 0; i < 3; ++i)
    place_m[i] = parabola(path.position_m[i], path.velocity_mps[i], path.acceleration_mps2[i], s);
  return place_m;
}

}  // namespace

void World::note_too_much(BodyId body, Tick tick) {
  note_failure(SceneError::Kind::too_many_collisions,
               words_of_too_much(collided_[body], scene().slow.separation_speed_mps > 0), body,
               tick);
}

void World::begin_impact(const EventKey& event) {
  impact_ = {};
  if (!keeps_impacts_ && !recorder_.keeps_history() && !scene().noise.is_on()) return;
  impact_ = {.tick = event.tick,
             .lower = event.lower,
             .higher = partner_of(event),
             .approach_mps = std::max(0.0, predictions_.approach_mps(event))};
}

void World::end_impact() {
  recorder_.has_impact(impact_.approach_mps, impact_.noise_number);
  if (keeps_impacts_) impacts_.push_back(impact_);
}

std::uint32_t& World::noised(std::uint32_t lower, std::uint32_t higher) {
  std::vector<PairCount>& pairs = noised_[lower];
  const auto found = std::ranges::find(pairs, higher, &PairCount::higher);
  return found != pairs.end() ? found->count : pairs.emplace_back(PairCount{higher}).count;
}

std::optional<ImpactNoise> World::take_noise() {
  const ContactNoise& noise = scene().noise;
  if (!noise.is_on()) return std::nullopt;
  const double strength = noise.strength(impact_.approach_mps);
  const auto is_plastic = [&](std::uint32_t body) {
    return collided_[body].at_tick > k_elastic_at_a_tick;
  };
  const bool with_static = (impact_.higher & k_static) != 0;
  // Without restitution, a crowded body's collisions end. Noise would not let them.
  if (strength == 0 || is_plastic(impact_.lower) || (!with_static && is_plastic(impact_.higher)))
    return std::nullopt;
  impact_.noise_number = ++noised(impact_.lower, impact_.higher);
  const NoiseValue value = noise.values->at({impact_.lower, impact_.higher, impact_.noise_number});
  const double tilt = strength * noise.tilt_sd_rad;
  return ImpactNoise{.tilt_first = tilt * value[0],
                     .tilt_second = tilt * value[1],
                     .restitution = strength * noise.restitution_sd * value[2]};
}

void World::collide(BodyId a, BodyId b, const EventKey& event) {
  changed_.clear();
  begin_impact(event);
  replayed_.make_live(a);
  replayed_.make_live(b);
  if (!plain_inverse_masses_per_kg_.empty() && predictions_.free_spheres(a, b) &&
      !bodies_.turns(a) && !bodies_.turns(b)) {
    collide_plain(a, b, event);
    end_impact();
    return;
  }
  static_assert(contact::AnyAtEvent<AtEvent>);
  AtEvent at(*this, event);
  const bool resolved = contact::collide(
      at, a, b, predictions_.contact_at(a, b, event),
      scene().contacts.between(bodies_.constants(a).material, bodies_.constants(b).material));
  end_impact();
  if (!resolved)
    note_failure(SceneError::Kind::impact_unresolved, "the impact can't be resolved", a,
                 event.tick);
}

void World::collide_static(BodyId body, StaticId met, const EventKey& event) {
  begin_impact(event);
  const PieceContact contact = predictions_.static_contact_at(body, met, event);
  const bool plastic = count_at(body, event.tick).at_tick > k_elastic_at_a_tick;
  const SurfaceLaw law = statics_.law(body, met, contact.point_m);
  const bool surface = statics_.is_surface(body, met);
  if (surface) {
    const Vec3 place_m = bodies_.position_at(body, event.tick);
    note_surface(body, met, event.tick, place_m, contact.point_m - place_m);
  }
  AtEvent at(*this, event);
  contact::collide_static(
      at, body, met, contact,
      contact::law_of_impact(law.restitution, law.friction, scene().slow, plastic),
      resting_.enabled() || surface);
  end_impact();
}

void World::note_surface(BodyId body, StaticId met, Tick tick, const Vec3& centre_m,
                         const Vec3& arm_m) {
  surface_touches_.push_back({.tick = tick,
                              .body = body,
                              .surface = statics_.surface_number(met),
                              .point_m = centre_m + arm_m});
}

void World::apply(const Control& control, const EventKey& event) {
  changed_.clear();
  const BodyId body = control.body;
  replayed_.make_live(body);
  Twist twist = bodies_.twist_at(body, event.tick);
  twist.velocity_mps += control.velocity_change_mps;
  twist.angular_velocity_radps += control.angular_velocity_change_radps;
  AtEvent at(*this, event);
  contact::wake_dependents(at, body);
  recorder_.learns(body);
  resting_.disturbed(body);
  at.begin_after(body, twist);
  contact::wake_on_those_that_left(at);
}

void World::collide_plain(BodyId a, BodyId b, const EventKey& event) {
  const Tick tick = event.tick;
  const Path first = bodies_.path(a);
  const Path second = bodies_.path(b);
  const Vec3 place_a_m = on_path_m(first, tick);
  const Vec3 place_b_m = on_path_m(second, tick);
  Vec3 between_m = place_b_m - place_a_m;
  if (bodies_.periodic()) between_m = Vec3(between_m + bodies_.to_nearest_image(between_m));
  const Vec3 normal = between_m / math::norm(between_m);
  const bool plastic =
      std::max(count_at(a, tick).at_tick, count_at(b, tick).at_tick) > k_elastic_at_a_tick;
  Vec3 velocity_a_mps = first.velocity_mps + seconds(tick - first.begin) * first.acceleration_mps2;
  Vec3 velocity_b_mps =
      second.velocity_mps + seconds(tick - second.begin) * second.acceleration_mps2;
  frictionless_sphere_impact(normal, plain_inverse_masses_per_kg_[a],
                             plain_inverse_masses_per_kg_[b],
                             plastic ? 0 : scene().contacts.between({}, {}).restitution, 0,
                             velocity_a_mps, velocity_b_mps);
  const auto fly_on = [&](BodyId body, const Vec3& place_m, const Vec3& velocity_mps) {
    bodies_.fly_on(body, tick, place_m, velocity_mps);
    if (recorder_.is_used()) recorder_.begins(body, bodies_.segment(body), event);
    changed_.push_back(body);
  };
  fly_on(a, place_a_m, velocity_a_mps);
  fly_on(b, place_b_m, velocity_b_mps);
}

}  // namespace sleight::physics
