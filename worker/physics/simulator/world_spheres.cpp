// What gases of spheres do most, from as little memory as there is: with many bodies, reading them
// takes longer than computing.
#include <array>

#include "worker/physics/simulator/world.h"

namespace sleight::physics {

bool World::predict_flight(std::uint32_t body, std::span<PairEdge> edges,
                           std::span<const std::uint32_t> changes, Tick now) const {
  // Judge some pairs without a branch, then compute those that collide: which ones, the processor
  // can't guess.
  constexpr std::size_t k_batch = 32;
  std::array<FlightApproach, k_batch> found;
  std::array<std::uint32_t, k_batch> places;
  bool all_free = true;
  for (std::size_t from = 0; from < edges.size(); from += k_batch) {
    const std::span<PairEdge> batch = edges.subspan(from, std::min(k_batch, edges.size() - from));
    std::size_t count = 0;
    for (std::size_t i = 0; i < batch.size(); ++i) {
      PairEdge& edge = batch[i];
      const Flight& first = flights_[std::min(body, edge.other)];
      const Flight& second = flights_[std::max(body, edge.other)];
      edge.predict({});
      edge.other_changes = changes[edge.other];
      found[count] = approach_of(first, second, nearest_shift(first, second, now));
      places[count] = static_cast<std::uint32_t>(i);
      const bool free = flights_[edge.other].radius_m > 0;
      all_free &= free;
      count += (found[count].approach.collides & free) ? 1 : 0;
    }
    for (std::size_t i = 0; i < count; ++i)
      batch[places[i]].predict(prediction_of(found[i]));
  }
  return all_free;
}

void World::collide_plain(std::uint32_t a, std::uint32_t b, const EventKey& event) {
  const Tick tick = event.tick;
  const Path first = path(a);
  const Path second = path(b);
  const Vec3 place_a_m = position_on(first, tick);
  const Vec3 place_b_m = position_on(second, tick);
  Vec3 between_m = place_b_m - place_a_m;
  if (periodic_) between_m = Vec3(between_m + to_nearest_image(between_m));
  const Vec3 normal = between_m / math::norm(between_m);
  const bool plastic = std::max(count_at(a, tick), count_at(b, tick)) > k_elastic_at_a_tick;
  Vec3 velocity_a_mps = first.velocity_mps + seconds(tick - first.begin) * first.acceleration_mps2;
  Vec3 velocity_b_mps =
      second.velocity_mps + seconds(tick - second.begin) * second.acceleration_mps2;
  frictionless_sphere_impact(normal, constants_[a].sphere_mass.inverse_mass_per_kg,
                             constants_[b].sphere_mass.inverse_mass_per_kg,
                             plastic ? 0 : scene_.contacts.between({}, {}).restitution, 0,
                             velocity_a_mps, velocity_b_mps);
  const auto fly_on = [&](std::uint32_t body, const Vec3& place_m, const Vec3& velocity_mps) {
    Flight& flight = flights_[body];
    flight.position_m = wrapped_m(place_m);
    flight.velocity_mps = velocity_mps;
    flight.begin = tick;
    FreeFlight& whole = segments_[body].flight;
    whole.begin = tick;
    whole.position_m = flight.position_m;
    whole.velocity_mps = velocity_mps;
    if (record_) recording_.append({body}, segments_[body], event);
    changed_.push_back(body);
  };
  fly_on(a, place_a_m, velocity_a_mps);
  fly_on(b, place_b_m, velocity_b_mps);
}

}  // namespace sleight::physics
