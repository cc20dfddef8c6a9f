#include "worker/worlds/readers/places_likeness.h"

#include <algorithm>
#include <cmath>

namespace sleight::worlds {

PlaceOf centres_of(const physics::Recording& recording) {
  return [&recording](std::uint32_t body, physics::Tick tick) {
    const physics::Segment* segment = recording.segment_at({body}, tick);
    return segment == nullptr ? math::Vec3(math::Vec3::Constant(std::nan("")))
                              : math::Vec3(physics::position_at(segment->flight, tick));
  };
}

std::vector<double> PlacesLikeness::numbers(double events, physics::Tick end,
                                            const PlaceOf& place_m) const {
  std::vector<double> numbers{events};
  const auto append_places = [&](physics::Tick tick) {
    for (std::uint32_t body = 0; body < diameters_m.size(); ++body) {
      const math::Vec3 place = place_m(body, tick);
      numbers.insert(numbers.end(), {place.x(), place.y(), place.z()});
    }
  };
  for (physics::Tick t{}; t <= end; t = t + step)
    append_places(t);
  append_places(end);
  return numbers;
}

double PlacesLikeness::distance(std::span<const double> a, std::span<const double> b,
                                double enough) const {
  const std::size_t width = 3 * diameters_m.size();
  const auto ticks = [&](std::span<const double> of) { return (of.size() - 1) / width - 1; };
  const auto place_m = [&](std::span<const double> of, std::size_t nth, std::size_t body) {
    return Eigen::Map<const math::Vec3>(&of[1 + width * std::min(nth, ticks(of)) + 3 * body]);
  };
  const double by_events = std::fabs(a[0] - b[0]) / std::max({a[0], b[0], 1.0});
  double most = 0;
  for (std::size_t i = 0; i < std::max(ticks(a), ticks(b)) && most + by_events <= enough; ++i) {
    for (std::size_t body = 0; body < diameters_m.size(); ++body) {
      const double apart_m = math::norm(math::Vec3(place_m(a, i, body) - place_m(b, i, body)));
      if (apart_m / diameters_m[body] > most) most = apart_m / diameters_m[body];  // not if NaN
    }
  }
  return most + by_events;
}

}  // namespace sleight::worlds
