#include "worker/physics/collision/sphere_search.h"

#include <algorithm>
#include <cmath>

namespace sleight::physics {
namespace {

/// Returns the first h >= 0 at which distance + rate h + curvature h^2 / 2 >= 0, for distance < 0.
double first_rise_s(double distance, double rate, double curvature) {
  if (curvature == 0) return rate > 0 ? -distance / rate : k_forever_s;
  const double discriminant = rate * rate - 2 * curvature * distance;
  if (discriminant < 0) return k_forever_s;
  const double root = std::sqrt(discriminant);
  if (curvature > 0) {
    // Compute the only positive root, in the form without cancellation.
    return rate >= 0 ? -2 * distance / (rate + root) : (root - rate) / curvature;
  }
  // The function rises and then falls, so the first root is the result, if there is one.
  return rate > 0 ? -2 * distance / (rate + root) : k_forever_s;
}

Tick later(Tick tick, double span_s) {
  if (!(span_s < seconds(k_tick_max.value))) return k_never;
  return tick + std::max<TickCount>(1, ticks_before(span_s));
}

/// Returns the state of a sphere relative to a line or point. `c` leads from the line or point to
/// the sphere's centre, and is perpendicular to the line.
GapState round_state(const Vec3& c, const Vec3& velocity_mps, const Vec3& acceleration_mps2,
                     double radius_m, double coordinates_m) {
  const double c_v = math::dot(c, velocity_mps);
  return {.now = gap_at_distance(math::norm(c), c_v, radius_m),
          .fall_mps2 = math::norm(acceleration_mps2),
          .coordinates_m = coordinates_m,
          .is_round = true,
          .c_v = c_v,
          .c_v_rate = math::dot(velocity_mps, velocity_mps) + math::dot(c, acceleration_mps2),
          .c_v_second = 3 * math::dot(velocity_mps, acceleration_mps2),
          .least_c_v = k_approach_at * k_approach_mps * radius_m};
}

}  // namespace

GapState gap_state(const SphereFeature& feature, const MovingPoint& centre, double radius_m) {
  const Vec3 from = centre.position_m - feature.point_m;
  const double coordinates_m = std::max(math::norm(centre.position_m), math::norm(feature.point_m));
  const Vec3& velocity_mps = centre.velocity_mps;
  const Vec3& pull_mps2 = centre.acceleration_mps2;
  switch (feature.kind) {
    case FeatureKind::face:
      return {.now = gap_to_face(feature, from, velocity_mps, radius_m),
              .fall_mps2 = std::max(0.0, -math::dot(feature.direction, pull_mps2)),
              .coordinates_m = coordinates_m};
    case FeatureKind::edge:
      return round_state(across(feature, from), across(feature, velocity_mps),
                         across(feature, pull_mps2), radius_m, coordinates_m);
    case FeatureKind::vertex:
      break;
  }
  return round_state(from, velocity_mps, pull_mps2, radius_m, coordinates_m);
}

Vec3 normal_at(const SphereFeature& feature, const Vec3& centre_m) {
  if (feature.kind == FeatureKind::face) return feature.direction;
  const Vec3 from = centre_m - feature.point_m;
  if (feature.kind == FeatureKind::vertex) return math::normalized(from);
  return math::normalized(across(feature, from));
}

double failing_for_s(const GapState& state, double touch_m) {
  double failing_s = 0;
  const double fall = state.fall_mps2;
  const auto [gap_m, rate_mps] = state.now;
  // No collision is possible before the gap falls to the touch distance.
  if (!touches(gap_m, touch_m)) {
    const double excess_m = gap_m - touch_m - k_rounding_ulps * (state.coordinates_m + gap_m);
    if (excess_m > 0) {
      failing_s = first_rise_s(-excess_m, -rate_mps, fall);
    } else {
      failing_s = k_seconds_per_tick;  // within rounding of the touch: skip only this tick
    }
  }
  // No collision is possible before the rate falls below -k_approach_mps.
  if (!approaches(rate_mps)) {
    if (fall == 0) return k_forever_s;
    failing_s = std::max(failing_s, (rate_mps + k_approach_mps) / fall);
    const double left = state.c_v + state.least_c_v;
    if (state.is_round && left > 0)
      failing_s = std::max(failing_s, first_rise_s(-left, -state.c_v_rate, -state.c_v_second));
    failing_s = std::max(failing_s, k_seconds_per_tick);
  }
  return failing_s;
}

double outside_for_s(std::span<const RegionSide> sides, const MovingPoint& centre) {
  double outside_s = 0;
  for (const RegionSide& side : sides) {
    const Vec3& normal = side.space.normal;
    const double depth_m = inside_m(side, centre.position_m);
    if (is_inside(side, depth_m)) continue;
    const double margin_m = k_rounding_ulps * (std::fabs(side.space.offset_m) + std::fabs(depth_m));
    const double short_m = std::min(0.0, depth_m + margin_m);
    const double rise_s = short_m < 0
                              ? first_rise_s(short_m, math::dot(normal, centre.velocity_mps),
                                             math::dot(normal, centre.acceleration_mps2))
                              : 0;
    outside_s = std::max({outside_s, rise_s, k_seconds_per_tick});
  }
  return outside_s;
}

Examined examine(const SphereFeature& feature, std::span<const RegionSide> sides,
                 const MovingPoint& centre, double radius_m, Tick tick) {
  double span_s = failing_for_s(gap_state(feature, centre, radius_m), k_touch_m);
  if (span_s < k_forever_s && !sides.empty()) {
    span_s = std::max(span_s, outside_for_s(sides, centre));
  }
  if (span_s == 0) return {.collides = true, .next = tick};
  return {.collides = false, .next = later(tick, span_s)};
}

Examined examine_spheres(const MovingPoint& relative, double radii_m, double coordinates_m,
                         double touch_m, Tick tick) {
  const GapState state = round_state(relative.position_m, relative.velocity_mps,
                                     relative.acceleration_mps2, radii_m, coordinates_m);
  const double span_s = failing_for_s(state, touch_m);
  if (span_s == 0) return {.collides = true, .next = tick};
  return {.collides = false, .next = later(tick, span_s)};
}

}  // namespace sleight::physics
