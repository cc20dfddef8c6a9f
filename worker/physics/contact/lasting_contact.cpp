#include "worker/physics/contact/lasting_contact.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "worker/physics/contact/resting.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/response/edge_motion.h"

namespace sleight::physics {
Tick tick_after(Tick tick, double span_s) {
  if (!(span_s < seconds(k_tick_max - tick))) return k_never;
  return tick + std::max<TickCount>(1, ticks_after(span_s));
}

double bounce_m(const SlowContacts& slow, const Vec3& gravity_mps2) {
  return 0.5 * slow.separation_speed_mps * slow.separation_speed_mps / math::norm(gravity_mps2);
}

Tick meets_border(const FrictionMap& map, const MapPath& path, Tick from, Tick end) {
  const double most_s = seconds(std::min(end, k_tick_max) - from);
  const double border_s = map.border_s(path, most_s);
  if (!(border_s < most_s)) return k_never;
  return std::max(tick_after(from, border_s), from + k_border_ticks);
}

namespace {

/// Returns the tick at which the centre leaves a feature's region, if it moves along `flight`'s
/// parabola.
Tick leaves_region(const FreeFlight& flight, std::span<const RegionSide> sides) {
  double leaves_s = std::numeric_limits<double>::infinity();
  for (const RegionSide& side : sides) {
    const double inside_m = math::dot(side.space.normal, flight.position_m) - side.space.offset_m;
    leaves_s =
        std::min(leaves_s, first_fall_s(std::max(0.0, inside_m),
                                        math::dot(side.space.normal, flight.velocity_mps),
                                        math::dot(side.space.normal, flight.acceleration_mps2)));
  }
  return tick_after(flight.begin, leaves_s);
}

/// Returns the tick at which a sphere has left an edge or a vertex, if the sphere moves straight
/// on.
Tick leaves_edge(const FreeFlight& flight, const SphereFeature& feature, double radius_m,
                 const SlowContacts& slow, const Vec3& gravity_mps2) {
  const double way_m = std::sqrt(2 * k_rise_bounces * bounce_m(slow, gravity_mps2) * radius_m);
  // Motion along an edge doesn't leave the edge.
  const auto across = [&](const Vec3& v) {
    return feature.kind == FeatureKind::edge
               ? math::norm(v - math::dot(feature.direction, v) * feature.direction)
               : math::norm(v);
  };
  const double speed_mps = across(flight.velocity_mps);
  const double pull = across(flight.acceleration_mps2);
  const double rate = speed_mps + std::sqrt(speed_mps * speed_mps + 2 * pull * way_m);
  return rate > 0 ? tick_after(flight.begin, 2 * way_m / rate) : k_never;
}

/// A subset (as bits) of up to three contacts, and the motion of a sphere that stays on the subset.
struct Carried {
  std::uint32_t subset = 0;
  ContactMotion motion{};
};

/// Returns the largest set of contacts that all carry the sphere while it presses on no other
/// contact.
std::optional<Carried> carried_by(const RoundBody& round, std::span<const LastingContact> contacts,
                                  const Twist& twist, const Vec3& gravity_mps2) {
  for (std::size_t count = contacts.size(); count > 0; --count) {
    for (std::uint32_t subset = 1; subset < std::uint32_t{1} << contacts.size(); ++subset) {
      if (static_cast<std::size_t>(std::popcount(subset)) != count) continue;
      std::array<LastingContact, 3> chosen;
      std::size_t taken = 0;
      for (std::size_t i = 0; i < contacts.size(); ++i) {
        if ((subset >> i & 1U) != 0) chosen[taken++] = contacts[i];
      }
      if (count == 2 && !is_valley(chosen[0].normal, chosen[1].normal)) continue;
      Carried carried{
          .subset = subset,
          .motion = contact_motion(round, std::span(chosen).first(count), twist, gravity_mps2)};
      bool holds = carried.motion.pressed == (std::uint32_t{1} << count) - 1;
      for (std::size_t i = 0; i < contacts.size() && holds; ++i) {
        const bool out = (subset >> i & 1U) == 0;
        holds =
            !out || math::dot(carried.motion.acceleration_mps2, contacts[i].normal) > -k_press_mps2;
      }
      if (holds) return carried;
    }
  }
  return std::nullopt;
}

/// Returns the sphere's next piece of motion over an edge, if there is one.
std::optional<Stay> stay_on_edge(const RoundBody& round, const MayStayOn& on, const FreeFlight& now,
                                 const ContactScene& scene) {
  const FeatureId index = on.features.front();
  const LastingContact& contact = on.contacts.front();
  const SphereFeature& edge = scene.statics.feature(index);
  if (edge.kind != FeatureKind::edge) return std::nullopt;
  const double distance_m = math::dot(contact.normal, now.position_m - edge.point_m);
  const auto piece = edge_piece(
      round, contact, {.direction = edge.direction, .distance_m = distance_m},
      {.velocity_mps = now.velocity_mps, .angular_velocity_radps = now.angular_velocity_radps},
      on.rolled, scene.gravity_mps2, k_rise_bounces * bounce_m(scene.slow, scene.gravity_mps2));
  if (!piece) return std::nullopt;
  Stay stay{.subset = 1,
            .segment = {.flight = now,
                        .angular_acceleration_radps2 = piece->angular_acceleration_radps2,
                        .mode = piece->rolls ? MotionMode::rolling : MotionMode::sliding}};
  FreeFlight& flight = stay.segment.flight;
  flight.velocity_mps = piece->start.velocity_mps;
  flight.angular_velocity_radps = piece->start.angular_velocity_radps;
  flight.acceleration_mps2 = piece->acceleration_mps2;
  stay.half_way = piece->half_way;
  stay.end = tick_after(now.begin, piece->lasts_s);
  const Tick leaves = leaves_region(flight, scene.statics.sides(edge));
  if (leaves < stay.end) {
    stay.end = leaves;
    stay.leaves = index;
  }
  return stay;
}

}  // namespace

RoundBody round_body(double radius_m, const Inertia& inertia, const SlowContacts& slow) {
  return {.radius_m = radius_m,
          .gyration = inertia.principal_kgm2.x() / (inertia.mass_kg * radius_m * radius_m),
          .stick_mps = std::max(k_stick_mps, k_stick_bounces * slow.separation_speed_mps)};
}

Tick slow_from(const Segment& segment, double radius_m, const Inertia& inertia,
               const SlowContacts& slow_contacts, Tick end) {
  const FreeFlight& flight = segment.flight;
  const auto fastest_mps = [&](Tick tick) {
    return fastest_point_mps(radius_m, twist_of(segment, inertia, tick));
  };
  const double limit_mps = slow_contacts.rest_speed_mps;
  if (fastest_mps(flight.begin) < limit_mps) return flight.begin;
  // The speed is convex in time. Test the minimum of each of the speed's two parts, and the end.
  Tick slow = k_never;
  const auto offer = [&](const Vec3& start, const Vec3& rate) {
    const double square = math::dot(rate, rate);
    const double least_s = square > 0 ? std::max(0.0, -math::dot(start, rate) / square) : 0;
    const Tick least = std::min(tick_after(flight.begin, least_s), end);
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

std::optional<Stay> stay_on(const RoundBody& round, const MayStayOn& on, const FreeFlight& now,
                            const ContactScene& scene) {
  if (on.features.size() == 1) {
    if (const auto over = stay_on_edge(round, on, now, scene)) return over;
  }
  const auto carried = carried_by(
      round, on.contacts,
      {.velocity_mps = now.velocity_mps, .angular_velocity_radps = now.angular_velocity_radps},
      scene.gravity_mps2);
  if (!carried) return std::nullopt;
  const ContactMotion& motion = carried->motion;
  Stay stay{.subset = carried->subset,
            .segment = {.flight = now,
                        .angular_acceleration_radps2 = motion.angular_acceleration_radps2,
                        .mode = motion.rolls ? MotionMode::rolling : MotionMode::sliding}};
  FreeFlight& flight = stay.segment.flight;
  flight.velocity_mps = motion.start.velocity_mps;
  flight.angular_velocity_radps = motion.start.angular_velocity_radps;
  flight.acceleration_mps2 = motion.acceleration_mps2;
  stay.end = tick_after(now.begin, motion.lasts_s);
  for (std::size_t i = 0; i < on.features.size(); ++i) {
    if ((stay.subset >> i & 1U) == 0) continue;
    const SphereFeature& feature = scene.statics.feature(on.features[i]);
    if (const FrictionMap* map = scene.statics.friction_map({on.features[i]})) {
      // The centre is directly above the contact and has the same map coordinates.
      const Tick border = meets_border(*map,
                                       {.place_m = flight.position_m,
                                        .velocity_mps = flight.velocity_mps,
                                        .acceleration_mps2 = flight.acceleration_mps2},
                                       flight.begin, stay.end);
      if (border < stay.end) {
        stay.end = border;
        stay.leaves = Stay::k_none;
      }
    }
    if (feature.kind != FeatureKind::face) {
      // The sphere leaves an edge or vertex when it moves straight on.
      const Tick rises =
          leaves_edge(flight, feature, round.radius_m, scene.slow, scene.gravity_mps2);
      if (rises < stay.end) {
        stay.end = rises;
        stay.leaves = on.features[i];
      }
    }
    const Tick leaves = leaves_region(flight, scene.statics.sides(feature));
    if (leaves > stay.end) continue;
    stay.end = leaves;
    stay.leaves = leaves != k_never ? on.features[i] : Stay::k_none;
  }
  return stay;
}

Caught caught_by(const RoundBody& round, std::span<const LastingContact> contacts,
                 const Twist& twist, const SlowContacts& slow) {
  Caught alone{.count = 1, .twist = twist, .otherwise = twist};
  if (contacts.size() == 1) return alone;
  alone.otherwise = hop(round, contacts[0].normal, twist, k_hop_share * slow.separation_speed_mps);
  if (contacts.size() == 2 && !is_valley(contacts[0].normal, contacts[1].normal)) return alone;
  Caught all = alone;
  all.count = contacts.size();
  all.twist.velocity_mps = along_faces(contacts, twist.velocity_mps);
  const bool fast =
      math::norm(all.twist.velocity_mps - twist.velocity_mps) >= slow.separation_speed_mps;
  return fast ? alone : all;
}

Twist twist_over_edge(const RoundBody& round, const Segment& segment, const Vec3& half_way,
                      const Vec3& gravity_mps2, Tick tick) {
  const FreeFlight& flight = segment.flight;
  const Twist start{.velocity_mps = flight.velocity_mps,
                    .angular_velocity_radps = flight.angular_velocity_radps};
  const Twist now{
      .velocity_mps = velocity_at(flight, tick),
      .angular_velocity_radps = flight.angular_velocity_radps +
                                seconds(tick - flight.begin) * segment.angular_acceleration_radps2};
  return without_lift(
      round, {.start = start, .acceleration_mps2 = flight.acceleration_mps2, .half_way = half_way},
      gravity_mps2, position_at(flight, tick) - flight.position_m, now);
}

bool stands_on(const RoundBody& round, std::span<const LastingContact> contacts,
               const Vec3& gravity_mps2) {
  const ContactMotion still = contact_motion(round, contacts, {}, gravity_mps2);
  const double allowed_mps2 = k_balance_tolerance * math::norm(gravity_mps2);
  const double turning_mps2 = round.radius_m * math::norm(still.angular_acceleration_radps2);
  return std::popcount(still.pressed) == static_cast<int>(contacts.size()) &&
         math::norm(still.acceleration_mps2) + turning_mps2 <= allowed_mps2;
}

}  // namespace sleight::physics
