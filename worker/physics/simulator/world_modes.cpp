// Spheres that stay on static geometry: when they do, how they move, and when that ends.
//
// A sphere loses its bounce on a face where that would be slower than separation_speed_mps, and
// stays there if gravity presses it on: on a face, in a valley of two, in a corner of three. Over
// an edge it hops while it is fast (contact_motion.h), and then goes round it piece by piece
// (edge_motion.h). Vertices, and edges beside something else, it takes for faces as long as it
// doesn't move by more than some micrometres: so it comes to rest between a face and an edge.
//
// Only a sphere that has met no other body for some bounces stays. One that leans on another body
// goes on bouncing from both: if it stayed on the face, nothing would be left to part it from the
// other body, and the two would collide without time passing.
#include <algorithm>
#include <cmath>

#include "worker/physics/simulator/world.h"

namespace sleight::physics {

bool World::is_caught(std::uint32_t body, std::uint32_t feature, double approach_mps,
                      double restitution, Tick tick) {
  if (!constants_[body].is_sphere || supports_.empty()) return false;
  const double slow_mps = scene_.slow.separation_speed_mps;
  if (constants_[body].inertia.symmetry != InertiaSymmetry::spherical ||
      restitution * approach_mps >= slow_mps || tick - supports_[body].met_body < alone_for_) {
    return false;
  }
  return statics_.feature(feature).kind == FeatureKind::face ||
         math::norm(twist_at(body, tick).velocity_mps) < k_edge_speeds * slow_mps;
}

RoundBody World::round_body(std::uint32_t body) const {
  return physics::round_body(constants_[body].reach_m, constants_[body].inertia, scene_.slow);
}

LastingContact World::lasting_contact(std::uint32_t body, std::uint32_t feature, Tick tick) const {
  const SurfaceLaw& law =
      scene_.contacts.between(constants_[body].material, statics_.material_of_feature(feature));
  return {.normal = normal_at(statics_.feature(feature), position_at(segments_[body].flight, tick)),
          .friction = law.friction,
          .rolling_friction = law.rolling_friction};
}

void World::begin_on_faces(std::uint32_t body, std::span<const std::uint32_t> features,
                           const Twist& twist, bool rolled, const Twist& otherwise,
                           const EventKey& event) {
  std::array<LastingContact, 3> contacts;
  for (std::size_t i = 0; i < features.size(); ++i)
    contacts[i] = lasting_contact(body, features[i], event.tick);
  const Vec3 place_m = position_at(segments_[body].flight, event.tick);
  const Segment now = segment_after(body, event.tick, place_m, twist);
  const auto stay = stay_on(
      round_body(body),
      {.features = features,
       .contacts = std::span(contacts).first(features.size()),
       .rolled = rolled},
      now.flight, {.statics = statics_, .slow = scene_.slow, .gravity_mps2 = scene_.gravity_mps2});
  note_contact_state(body);
  if (!stay) {
    resting_.flies(body, event.tick);
    begin_after(body, otherwise, event);
    return;
  }
  begin_segment(body, stay->segment, event);
  changed_.push_back(body);
  Supports& kept = supports_[body];
  kept.count = 0;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if ((stay->subset >> i & 1U) != 0) kept.features[kept.count++] = features[i];
  }
  kept.end = stay->end;
  kept.leaves = stay->leaves;
  kept.half_way = stay->half_way;
  resting_.stays(body, event.tick, slow_from(body, stay->segment, kept.end));
}

void World::begin_caught(std::uint32_t body, std::uint32_t feature, const Twist& twist,
                         const EventKey& event) {
  std::array<std::uint32_t, 3> features{feature};
  std::array<LastingContact, 3> contacts{lasting_contact(body, feature, event.tick)};
  std::size_t count = 1;
  for (const std::uint32_t other : supports_[body].all()) {
    if (other == feature || count == features.size()) continue;
    contacts[count] = lasting_contact(body, other, event.tick);
    features[count++] = other;
  }
  const Caught caught =
      caught_by(round_body(body), std::span(contacts).first(count), twist, scene_.slow);
  begin_on_faces(body, std::span(features).first(caught.count), caught.twist, false,
                 caught.otherwise, event);
}

void World::change_mode(std::uint32_t body, const EventKey& event) {
  changed_.clear();
  const Supports supports = supports_[body];
  const Twist twist = twist_at(body, event.tick);
  // Over the border of one: what lies there is met as anything else, at once if it goes on level.
  std::array<std::uint32_t, 3> features{};
  std::size_t count = 0;
  for (const std::uint32_t feature : supports.all()) {
    if (feature != supports.leaves) features[count++] = feature;
  }
  const bool rolled = segments_[body].mode == MotionMode::rolling;
  begin_on_faces(body, std::span(features).first(count), twist, rolled, twist, event);
  wake_on_those_that_left(event);
}

TouchRecord World::touch_of_support(std::uint32_t body, std::uint32_t feature, Tick tick) const {
  const LastingContact contact = lasting_contact(body, feature, tick);
  return {.tick = tick,
          .partner = k_static_partner,
          .feature = feature,
          .friction = contact.friction,
          .normal = contact.normal,
          .arm_m = -constants_[body].reach_m * contact.normal};
}

Tick World::slow_from(std::uint32_t body, const Segment& segment, Tick end) const {
  if (!resting_.enabled()) return k_never;
  return physics::slow_from(segment, constants_[body].reach_m, constants_[body].inertia,
                            scene_.slow, end);
}

}  // namespace sleight::physics
