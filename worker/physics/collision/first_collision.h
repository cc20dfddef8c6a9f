// Computes the first time at which a collision is possible, from a lower bound on the gap.
//
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/event/tick.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {

/// A skip is shortened by this share to allow for its own rounding.
inline constexpr double k_skip_margin = 0x1p-20;

/// Returns the first h >= from at which place + rate h - fall h^2 / 2 <= k_touch, for fall >= 0.
inline double first_touch_s(double place_m, double rate_mps, double fall, double from_s) {
  const double excess_m = place_m - k_touch_m;
  if (excess_m + from_s * (rate_mps - 0.5 * fall * from_s) <= 0) return from_s;
  // The later root is the time at which the bound reaches the touch distance.
  if (fall <= 0) return rate_mps < 0 ? excess_m / -rate_mps : k_forever_s;
  const double root = std::sqrt(std::max(0.0, rate_mps * rate_mps + 2 * fall * excess_m));
  const double down_s = rate_mps < 0 ? 2 * excess_m / (root - rate_mps) : (root + rate_mps) / fall;
  return std::max(from_s, down_s);
}

/// Returns the first h >= from at which first_touch_s()'s condition holds and rate - fall h <
/// -k_approach. REQUIRES: fall >= 0.
inline double first_collision_s(double place_m, double rate_mps, double fall, double from_s) {
  double h = from_s;
  if (rate_mps - fall * h >= -k_approach_mps) {
    if (fall <= 0) return k_forever_s;
    h = std::max(from_s, (rate_mps + k_approach_mps) / fall);
  }
  return first_touch_s(place_m, rate_mps, fall, h);
}

/// Returns the least h >= 0 at which place + rate h + curvature h^2 / 2 <= 0.
inline double first_zero_s(double place, double rate, double curvature) {
  if (place <= 0) return 0;
  const double discriminant = rate * rate - 2 * curvature * place;
  if (discriminant < 0) return k_forever_s;
  const double root = std::sqrt(discriminant);
  if (curvature < 0 && rate >= 0) return -(rate + root) / curvature;
  return rate < 0 ? 2 * place / (root - rate) : k_forever_s;
}

/// Returns the result of a look at `tick` after which no collision is possible for `span_s`.
inline Examined look_after(Tick tick, double span_s) {
  if (!(span_s < seconds(k_tick_max.value))) return {.collides = false, .next = k_never};
  const TickCount span = ticks_before(span_s * (1 - k_skip_margin));
  return {.collides = false, .next = tick + std::max<TickCount>(1, span)};
}

}  // namespace sleight::physics
