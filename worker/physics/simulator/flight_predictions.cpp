// Predictions of spheres in flight, which are the main work in gases. The code here reads as little
// memory as possible: if there are many bodies, reading takes longer than computing.
#include <algorithm>
#include <array>

#include "worker/physics/simulator/lanes.h"
#include "worker/physics/simulator/predictions.h"

namespace sleight::physics {

Prediction Predictions::predict_free_spheres(BodyId a, BodyId b, Tick now) const {
  Vec3 shift_m = Vec3::Zero();
  if (bodies_.periodic()) {
    const Flight& first = bodies_.flight(a);
    const Flight& second = bodies_.flight(b);
    const double s = seconds(now - first.begin);
    const double t = seconds(now - second.begin);
    shift_m = bodies_.to_nearest_image((second.position_m + t * second.velocity_mps) -
                                       (first.position_m + s * first.velocity_mps));
  }
  return predict_free_spheres_at(a, b, shift_m);
}

Prediction Predictions::predict_free_spheres_at(BodyId a, BodyId b, const Vec3& shift_m) const {
  const Flight& first = bodies_.flight(a);
  const Flight& second = bodies_.flight(b);
  const Tick tick = collision_of_flights(first, second, bodies_.scene().gravity_mps2, shift_m,
                                         first.radius_m + second.radius_m);
  if (tick == k_never) return {};
  return {.tick = tick, .certain = true};
}

/// `k_fresh`: the body's flight begins at `now`. So all pairs are evaluated at that tick, and the
/// body's position is known.
template <bool k_fresh>
bool Predictions::predict_flight_from(BodyId body, const PairEdges& edges,
                                      std::span<const std::uint32_t> changes, Tick now) const {
  // First test a batch of pairs without branches, because the processor can't predict which pairs
  // collide. Then compute the colliding pairs.
  constexpr std::size_t k_batch = 32;
  std::array<double, k_batch> towards;
  std::array<double, k_batch> excess;
  std::array<double, k_batch> discriminant;
  std::array<TickCount, k_batch> begins;
  std::array<std::uint32_t, k_batch> places;

  const Flight* const flights = bodies_.flights().data();
  const Flight& own = flights[body];
  const Lanes own_place = Lanes::of(own.position_m);
  const Lanes own_velocity = Lanes::of(own.velocity_mps);
  const Lanes g = Lanes::of(bodies_.scene().gravity_mps2);
  const double own_s = k_fresh ? 0 : seconds(now - own.begin);
  const Lanes own_place_now = k_fresh ? own_place : own_place + Lanes::all(own_s) * own_velocity;
  const Images images = images_;
  bool all_free = true;
  for (std::size_t from = 0; from < edges.count; from += k_batch) {
    const PairEdges batch = edges.from(from, std::min(k_batch, edges.count - from));
    std::size_t count = 0;
    for (std::size_t i = 0; i < batch.count; ++i) {
      const Flight& other = flights[batch.others[i]];
      batch.ticks[i] = k_never;
      batch.other_changes[i] = changes[batch.others[i]];
      const Lanes place = Lanes::of(other.position_m);
      const Lanes velocity = Lanes::of(other.velocity_mps);

      // Shift to the second body's image that is nearest to the first body now. Usually rounding
      // can't decide whether the shift is one period or none; this case needs no branch.
      const LaneMask own_is_first = LaneMask::all(body < batch.others[i]);
      const Lanes place_now = place + Lanes::all(seconds(now - other.begin)) * velocity;
      const Lanes apart = choose(own_is_first, place_now, own_place_now) -
                          choose(own_is_first, own_place_now, place_now);
      Lanes shift = where(apart > images.half_m, -images.period_m) +
                    where(-images.half_m > apart, images.period_m);
      const LaneMask odd = (absolute(apart) > images.half_m) &
                           (absolute(absolute(apart) - images.middle_m) > images.sure_m);
      if (odd.any()) [[unlikely]] {
        shift = Lanes::of(bodies_.to_nearest_image({apart.xy[0], apart.xy[1], apart.z[0]}));
      }

      // Compute the relative motion from the start of the later flight on. Gravity cancels.
      const Tick begin = k_fresh ? now : std::max(own.begin, other.begin);
      const double s = k_fresh ? 0 : seconds(begin - own.begin);
      const double t = seconds(begin - other.begin);
      const auto place_after = [&](const Lanes& p, const Lanes& v, double span_s) {
        return p + (v + g * Lanes::all(0.5 * span_s)) * Lanes::all(span_s);
      };
      const Lanes own_then = k_fresh ? own_place : place_after(own_place, own_velocity, s);
      const Lanes then = place_after(place, velocity, t);
      const Lanes own_rate = k_fresh ? own_velocity : own_velocity + Lanes::all(s) * g;
      const Lanes rate = velocity + Lanes::all(t) * g;
      const Lanes between =
          (choose(own_is_first, then, own_then) + shift) - choose(own_is_first, own_then, then);
      const Lanes relative =
          choose(own_is_first, rate, own_rate) - choose(own_is_first, own_rate, rate);

      const SphereApproach approach =
          approach_of_free_spheres(dot(between, relative), dot(between, between),
                                   dot(relative, relative), own.radius_m + other.radius_m);
      towards[count] = approach.towards;
      excess[count] = approach.excess;
      discriminant[count] = approach.discriminant;
      begins[count] = begin.value;
      places[count] = static_cast<std::uint32_t>(i);
      const bool free = other.radius_m > 0;
      all_free &= free;
      count += static_cast<std::size_t>(approach.collides & free);
    }
    for (std::size_t i = 0; batch.details != nullptr && i < batch.count; ++i) {
      batch.details[i].feature = 0;
      batch.details[i].certain = false;
    }
    for (std::size_t i = 0; i < count; ++i) {
      const TickCount span = span_to_collision({towards[i], excess[i], discriminant[i], true});
      if (span >= k_tick_max.value) continue;
      batch.ticks[places[i]] = Tick{begins[i]} + span;
      if (batch.details != nullptr) batch.details[places[i]].certain = true;
    }
  }
  return all_free;
}

bool Predictions::predict_flight(BodyId body, const PairEdges& edges,
                                 std::span<const std::uint32_t> changes, Tick now) const {
  return bodies_.flight(body).begin == now ? predict_flight_from<true>(body, edges, changes, now)
                                           : predict_flight_from<false>(body, edges, changes, now);
}

}  // namespace sleight::physics
