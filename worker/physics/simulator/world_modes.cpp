// Spheres that stay on static geometry: when they do, how they move, and when that ends.
//
// A sphere loses its bounce on a face where that would be slower than separation_speed_mps, and
// stays there if gravity presses it on: on a face, in a valley of two, in a corner of three. Over
// edges and vertices, on which it moves in no closed form, it hops (contact_motion.h). Too slow for
// that, it takes them for faces as long as it doesn't move by more than some micrometres: so it
// comes to rest between a face and an edge.
//
// Only a sphere that has met no other body for some bounces stays. One that leans on another body
// goes on bouncing from both: if it stayed on the face, nothing would be left to part it from the
// other body, and the two would collide without time passing.
#include <algorithm>
#include <bit>
#include <cmath>

#include "worker/physics/simulator/world.h"

namespace sleight::physics {
namespace {

/// A sphere that accelerates into a face by less than this doesn't press on it: over an hour, less
/// than gravity in a tick.
constexpr double k_press_mps2 = 1e-12;

/// A sphere that is too slow to hop over an edge or a vertex goes straight on until it is so far
/// above it, as a part of the height of its slowest bounces, and falls back.
constexpr double k_rise_bounces = 0.5;

/// A slip is over when it is slower than this part of its slowest bounces.
constexpr double k_stick_bounces = 0.1;

/// Over an edge or a vertex it hops if it is faster than so many times its slowest bounces.
constexpr double k_edge_speeds = 16;

/// Least h > 0 at which distance + rate h + curvature h^2 / 2 falls below 0; infinite if never.
/// REQUIRES: distance >= 0.
double first_fall_s(double distance, double rate, double curvature) {
  const double discriminant = rate * rate - 2 * curvature * distance;
  if (!(discriminant >= 0)) return std::numeric_limits<double>::infinity();
  const double root = std::sqrt(discriminant);
  if (rate < 0) return 2 * distance / (root - rate);
  return curvature < 0 ? (rate + root) / -curvature : std::numeric_limits<double>::infinity();
}

/// A tick so much later, at least the next one.
Tick after(Tick tick, double span_s) {
  if (!(span_s < seconds(k_tick_max - tick))) return k_never;
  return tick + std::max<TickCount>(1, ticks_after(span_s));
}

}  // namespace

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
  const BodyConstants& constants = constants_[body];
  const double radius_m = constants.reach_m;
  return {.radius_m = radius_m,
          .gyration = constants.inertia.principal_kgm2.x() /
                      (constants.inertia.mass_kg * radius_m * radius_m),
          .stick_mps = std::max(k_stick_mps, k_stick_bounces * scene_.slow.separation_speed_mps)};
}

LastingContact World::lasting_contact(std::uint32_t body, std::uint32_t feature, Tick tick) const {
  const SurfaceLaw& law =
      scene_.contacts.between(constants_[body].material, statics_.material_of_feature(feature));
  return {.normal = normal_at(statics_.feature(feature), position_at(segments_[body].flight, tick)),
          .friction = law.friction,
          .rolling_friction = law.rolling_friction};
}

Tick World::leaves_region(const Segment& segment, std::uint32_t feature) const {
  double leaves_s = std::numeric_limits<double>::infinity();
  const FreeFlight& flight = segment.flight;
  for (const RegionSide& side : statics_.sides(statics_.feature(feature))) {
    const double inside_m = math::dot(side.space.normal, flight.position_m) - side.space.offset_m;
    leaves_s =
        std::min(leaves_s, first_fall_s(std::max(0.0, inside_m),
                                        math::dot(side.space.normal, flight.velocity_mps),
                                        math::dot(side.space.normal, flight.acceleration_mps2)));
  }
  return after(flight.begin, leaves_s);
}

void World::begin_on_faces(std::uint32_t body, std::span<const std::uint32_t> features,
                           const Twist& twist, const EventKey& event) {
  std::array<LastingContact, 3> contacts;
  for (std::size_t i = 0; i < features.size(); ++i)
    contacts[i] = lasting_contact(body, features[i], event.tick);
  const RoundBody round = round_body(body);
  // The most faces that all carry it, while it does not press on the others.
  for (std::size_t count = features.size(); count > 0; --count) {
    for (std::uint32_t subset = 1; subset < std::uint32_t{1} << features.size(); ++subset) {
      if (static_cast<std::size_t>(std::popcount(subset)) != count) continue;
      Supports supports;
      std::array<LastingContact, 3> chosen;
      for (std::size_t i = 0; i < features.size(); ++i) {
        if ((subset >> i & 1U) == 0) continue;
        chosen[supports.count] = contacts[i];
        supports.features[supports.count++] = features[i];
      }
      if (count == 2 && !is_valley(chosen[0].normal, chosen[1].normal)) continue;
      const ContactMotion motion =
          contact_motion(round, std::span(chosen).first(count), twist, scene_.gravity_mps2);
      bool holds = motion.pressed == (std::uint32_t{1} << count) - 1;
      for (std::size_t i = 0; i < features.size() && holds; ++i) {
        const bool out = (subset >> i & 1U) == 0;
        holds = !out || math::dot(motion.acceleration_mps2, contacts[i].normal) > -k_press_mps2;
      }
      if (!holds) continue;
      begin_staying(body, supports, motion, event);
      return;
    }
  }
  resting_.flies(body, event.tick);
  begin_after(body, twist, event);
}

void World::begin_staying(std::uint32_t body, const Supports& supports, const ContactMotion& motion,
                          const EventKey& event) {
  const Vec3 place_m = position_at(segments_[body].flight, event.tick);
  Segment segment = segment_after(body, event.tick, place_m, motion.start);
  segment.flight.acceleration_mps2 = motion.acceleration_mps2;
  segment.angular_acceleration_radps2 = motion.angular_acceleration_radps2;
  segment.mode = motion.rolls ? MotionMode::rolling : MotionMode::sliding;
  begin_segment(body, segment, event);
  changed_.push_back(body);
  Supports& kept = supports_[body];
  kept.features = supports.features;
  kept.count = supports.count;
  kept.leaves = Supports::k_none;
  kept.end = after(event.tick, motion.lasts_s);
  for (const std::uint32_t feature : supports.all()) {
    if (statics_.feature(feature).kind != FeatureKind::face) {
      // Straight on from an edge, it leaves that.
      const double slow_mps = scene_.slow.separation_speed_mps;
      const double bounce_m = 0.5 * slow_mps * slow_mps / math::norm(scene_.gravity_mps2);
      const double way_m = std::sqrt(2 * k_rise_bounces * bounce_m * constants_[body].reach_m);
      const double speed_mps = math::norm(segment.flight.velocity_mps);
      const double pull = math::norm(segment.flight.acceleration_mps2);
      const double rate = speed_mps + std::sqrt(speed_mps * speed_mps + 2 * pull * way_m);
      const Tick rises = rate > 0 ? after(event.tick, 2 * way_m / rate) : k_never;
      if (rises < kept.end) {
        kept.end = rises;
        kept.leaves = feature;
      }
    }
    const Tick leaves = leaves_region(segment, feature);
    if (leaves > kept.end) continue;
    kept.end = leaves;
    kept.leaves = leaves != k_never ? feature : Supports::k_none;
  }
  resting_.stays(body, event.tick, slow_from(body, segment, kept.end));
}

void World::begin_caught(std::uint32_t body, std::uint32_t feature, const Twist& twist,
                         const EventKey& event) {
  // On what it stayed before it stays as well, unless it is fast across that: then it rolls up the
  // new face.
  std::array<std::uint32_t, 3> features{feature};
  std::array<LastingContact, 3> contacts{lasting_contact(body, feature, event.tick)};
  std::size_t count = 1;
  for (const std::uint32_t other : supports_[body].all()) {
    if (other == feature || count == features.size()) continue;
    contacts[count] = lasting_contact(body, other, event.tick);
    features[count++] = other;
  }
  Twist along = twist;
  const bool plain =
      count == 1 || (count == 2 && !is_valley(contacts[0].normal, contacts[1].normal));
  if (!plain)
    along.velocity_mps = along_faces(std::span(contacts).first(count), twist.velocity_mps);
  if (plain ||
      math::norm(along.velocity_mps - twist.velocity_mps) >= scene_.slow.separation_speed_mps) {
    begin_on_faces(body, std::span(features).first(1), twist, event);
  } else {
    begin_on_faces(body, std::span(features).first(count), along, event);
  }
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
  begin_on_faces(body, std::span(features).first(count), twist, event);
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
  const FreeFlight& flight = segment.flight;
  const auto fastest_mps = [&](Tick tick) {
    return fastest_point_mps(body, twist_of(segment, constants_[body].inertia, tick));
  };
  const double limit_mps = scene_.slow.rest_speed_mps;
  if (fastest_mps(flight.begin) < limit_mps) return flight.begin;
  // The speed is convex in time. Where one of its two parts is least, or at the end, it may be
  // slow.
  Tick slow = k_never;
  const auto offer = [&](const Vec3& start, const Vec3& rate) {
    const double square = math::dot(rate, rate);
    const double least_s = square > 0 ? std::max(0.0, -math::dot(start, rate) / square) : 0;
    const Tick least = std::min(after(flight.begin, least_s), end);
    if (least < slow && fastest_mps(least) < limit_mps) slow = least;
  };
  offer(flight.velocity_mps, flight.acceleration_mps2);
  offer(flight.angular_velocity_radps, segment.angular_acceleration_radps2);
  if (end != k_never && end < slow && fastest_mps(end) < limit_mps) slow = end;
  if (slow == k_never) return k_never;
  Tick fast = flight.begin;
  while (slow - fast > 1) {
    const Tick middle = fast + (slow - fast) / 2;
    (fastest_mps(middle) < limit_mps ? slow : fast) = middle;
  }
  return slow;
}

}  // namespace sleight::physics
