// A part of a ball's path, and when on it the ball may first collide with something, at the
// earliest.
//
// Idea. Most of what is near a path is not met, and the rest not at once. Which it is, and when,
// can be said from the coefficients of three parabolas along the feature's own directions, for a
// tenth of what it costs to judge a tick: here are these bounds, and whoever asks judges ticks from
// there on (marbles_predictions.cpp).
//
//   face    n.(p - q) is a parabola; that of a centre which falls on it is lowest at an end.
//   corner  with c the way from an edge's line, or a vertex, to the centre at a time s, and h
//   later,
//             |c(s + h)| >= c.c(s + h) / |c|,  a parabola again,
//           and c.c, c.v and c.a at any s are polynomials of five products, taken once.
//   region  of a half-space the parabola's greatest value between two times.
//
// Invariants
//   1. Up to what is returned the ball does not collide with the feature: by touch, approach or
//      region, as examine (sphere_search.h) computes them, rounding included.
//   2. Every margin is larger than what rounding does to the bound by a factor of 4 at least. With
//      N the sum of all sizes that are added up on the way (size_m, and size_m times speed_mps for
//      c.v), a bound here takes fewer than 16 roundings, each of 2^-53 N.
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "worker/physics/event/tolerances.h"
#include "worker/physics/marbles/four.h"
#include "worker/physics/marbles/near_features.h"
#include "worker/physics/simulator/sphere_search.h"

namespace sleight::physics {

/// A centre's parabola from a moment on, for a while.
struct PathPart {
  Four place_m;
  Four velocity_mps;
  Four pull_mps2;
  double span_s = 0;
  double size_m = 0;     ///< no less than sum of |coordinates|, along it, and of what is near
  double speed_mps = 0;  ///< no less than sum of |velocities|, along it

  /// REQUIRES: place, velocity and pull are set. `near_m`: sum of |coordinates| of what is near.
  void lasts(double for_s, double near_m) {
    span_s = for_s;
    const double pull = sum(fabs(pull_mps2)) * for_s;
    const double speed = sum(fabs(velocity_mps));
    speed_mps = speed + pull;
    size_m = near_m + sum(fabs(place_m)) + (speed + 0.5 * pull) * for_s;
  }
};

namespace detail {

inline constexpr double k_forever_s = std::numeric_limits<double>::infinity();

/// More than roundings take from a root's time.
inline constexpr double k_root_shrink = 1 - 0x1p-40;

/// Rounding of sums of products, by their size.
inline constexpr double k_sum_ulps = 0x1p-46;

inline Four parabolas(const Four& place, const Four& speed, const Four& pull, double s) {
  return place + (speed + pull * Four::all(0.5 * s)) * Four::all(s);
}

}  // namespace detail

/// Of the centre between two times of its flight, without any margin.
struct PathExtent {
  Four low_m;
  Four high_m;
};
inline PathExtent extent_of(const Four& place_m, const Four& velocity_mps, const Four& pull_mps2,
                            double from_s, double to_s) {
  const Four first = detail::parabolas(place_m, velocity_mps, pull_mps2, from_s);
  const Four last = detail::parabolas(place_m, velocity_mps, pull_mps2, to_s);
  // Where the velocity's sign changes, the apex lies between. There the pull is not 0.
  const Four turns =
      (velocity_mps + pull_mps2 * Four::all(from_s)) * (velocity_mps + pull_mps2 * Four::all(to_s));
  const Four apex =
      choose_if_less(turns, Four::zero(),
                     place_m - Four::all(0.5) * velocity_mps * velocity_mps / pull_mps2, first);
  return {min(min(first, last), apex), max(max(first, last), apex)};
}

/// Less than the time that a place stays between two walls in each coordinate. REQUIRES: it is
/// between them, and they are finite.
inline double stays_s(const Four& place, const Four& speed, const Four& pull, const Four& low,
                      const Four& high) {
  constexpr double k_less = 1 - 0x1p-30;
  const Four zero = Four::zero();
  const Four up = high - place;
  const Four down = place - low;
  const Four ahead = choose_if_less(speed, zero, down, up);
  const Four behind = choose_if_less(speed, zero, up, down);
  const Four a = choose_if_less(speed, zero, zero - pull, pull);
  const Four v = fabs(speed);
  const Four twice = a + a;
  // Slowing down, it meets the wall ahead before its apex, or else the one behind.
  const Four square = v * v;
  const Four at_ahead = square + twice * ahead;
  const Four root = sqrt(choose_if_less(at_ahead, zero, square - twice * behind, at_ahead));
  const Four sum_of_speeds = v + root;
  return k_less * least(choose_if_less(at_ahead, zero, sum_of_speeds, ahead + ahead) /
                        choose_if_less(at_ahead, zero, zero - a, sum_of_speeds));
}

/// A gap that is at least such a parabola in time: when it first is below 0 while it shrinks, at
/// the earliest. `not_before_s`: until then it doesn't shrink.
inline double falls_after_s(double excess_m, double rate_mps, double pull_mps2,
                            double not_before_s) {
  if (excess_m > 0) return std::max(not_before_s, first_fall_s(excess_m, rate_mps, pull_mps2));
  const double discriminant = rate_mps * rate_mps - 2 * pull_mps2 * excess_m;
  if (pull_mps2 < 0 && rate_mps > 0 && discriminant > 0) {
    // It rises at once, and falls back.
    const double root = std::sqrt(discriminant);
    if (-2 * excess_m <= not_before_s * (rate_mps + root))
      return std::max(not_before_s, (rate_mps + root) / -pull_mps2);
  }
  return not_before_s;
}

/// When a centre on a path may first touch a face's plane and approach it; infinite if it doesn't.
inline double face_not_before_s(const PathPart& path, const SphereFeature& face, double radius_m) {
  const Four normal = Four::of(face.direction);
  const double rate_mps = dot(normal, path.velocity_mps);
  const double pull_mps2 = dot(normal, path.pull_mps2);
  // It never approaches.
  const double last_rate_mps = rate_mps + pull_mps2 * path.span_s;
  if (std::min(rate_mps, last_rate_mps) > detail::k_sum_ulps * path.speed_mps - k_approach_mps)
    return detail::k_forever_s;
  // It never touches: where it is lowest, at the end, unless it turns before. Some rounding more
  // counts as a touch.
  const double excess_m = dot(normal, path.place_m - Four::of(face.point_m)) -
                          (radius_m + (k_touch_m + k_rounding_ulps * path.size_m));
  if (excess_m > 0 && (pull_mps2 <= 0 || last_rate_mps <= 0) &&
      excess_m + (rate_mps + 0.5 * pull_mps2 * path.span_s) * path.span_s > 0)
    return detail::k_forever_s;
  const double not_before_s =
      rate_mps > 0 && pull_mps2 < 0 ? rate_mps / -pull_mps2 : 0;  // until then it goes away
  return detail::k_root_shrink * falls_after_s(excess_m, rate_mps, pull_mps2, not_before_s);
}

/// When a centre on a path may first touch an edge's line or a vertex and approach it; infinite if
/// it doesn't.
inline double corner_not_before_s(const PathPart& path, const SphereFeature& corner,
                                  double radius_m) {
  const double span_s = path.span_s;
  const Four along = Four::of(corner.direction);  // of a vertex 0
  const Four from = path.place_m - Four::of(corner.point_m);
  const Four c = from - Four::all(dot(along, from)) * along;
  const double c_c = dot(c, c);
  const double c_v = dot(c, path.velocity_mps);
  const double c_a = dot(c, path.pull_mps2);
  // c.c is known to a part of size_m^2, so the distance is, near the touch, to that over the
  // radius.
  const double reach_m = radius_m + k_touch_m +
                         detail::k_sum_ulps * (path.size_m + path.size_m * path.size_m / radius_m);
  // It never touches: by the plane at right angles to the way there.
  if (c_c > reach_m * reach_m) {
    const double left = c_a <= 0 || c_v + c_a * span_s <= 0
                            ? c_c + std::min(0.0, (c_v + 0.5 * c_a * span_s) * span_s)
                            : c_c + std::min(0.0, c_v) * span_s;
    if (left > 0 && left * left > reach_m * reach_m * c_c) return detail::k_forever_s;
  }
  const Four v = path.velocity_mps - Four::all(dot(along, path.velocity_mps)) * along;
  const Four a = path.pull_mps2 - Four::all(dot(along, path.pull_mps2)) * along;
  const double v_a = dot(v, a);
  const double a_a = dot(a, a);
  const double c_v_rate = dot(v, v) + c_a;
  // It approaches at c.v < -|c| k_approach, and what it touches is half of its radius away at
  // least.
  const double least_c_v =
      0.25 * k_approach_mps * radius_m - detail::k_sum_ulps * path.size_m * path.speed_mps;
  double s = 0;
  constexpr int k_steps_max = 8;
  for (int step = 0; step < k_steps_max; ++step) {
    const double c_c_now = c_c + (2 * c_v + (c_v_rate + (v_a + 0.25 * a_a * s) * s) * s) * s;
    const double c_v_now = c_v + (c_v_rate + (1.5 * v_a + 0.5 * a_a * s) * s) * s;
    const double c_a_now = c_a + (v_a + 0.5 * a_a * s) * s;
    // It doesn't approach as long as c.v stays positive; the last term of that only raises it.
    const double left = c_v_now + least_c_v;
    double not_before_s = 0;
    if (left > 0)
      not_before_s =
          first_fall_s(left, c_v_rate + (3 * v_a + 1.5 * a_a * s) * s, 3 * v_a + 3 * a_a * s);
    if (!(detail::k_root_shrink * (s + not_before_s) <= span_s)) return detail::k_forever_s;
    // All times the distance.
    const double excess = c_c_now - reach_m * std::sqrt(std::max(0.0, c_c_now));
    const double fails_s = falls_after_s(excess, c_v_now, c_a_now, not_before_s);
    const double then_s = detail::k_root_shrink * (s + fails_s);
    if (!(then_s <= span_s)) return detail::k_forever_s;
    constexpr double k_close = 1 + 0x1p-20;
    const bool close = then_s <= k_close * s + k_seconds_per_tick;
    s = then_s;
    if (close) break;
  }
  return s;
}

/// Whether a centre on a path is outside of a region from one time to another one, by one of the
/// region's sides.
inline bool stays_outside(std::span<const RegionSide> sides, const PathPart& path, double from_s,
                          double to_s) {
  const double margin_m = k_clear_margin_m + k_rounding_ulps * path.size_m;
  for (std::size_t i = sides.size(); i-- > 0;) {
    const Four normal = Four::of(sides[i].space.normal);
    const double inside_m = dot(normal, path.place_m) - (sides[i].space.offset_m - margin_m);
    const double rate_mps = dot(normal, path.velocity_mps);
    const double pull_mps2 = dot(normal, path.pull_mps2);
    const double first_m = inside_m + (rate_mps + 0.5 * pull_mps2 * from_s) * from_s;
    if (first_m >= 0) continue;
    const double last_m = inside_m + (rate_mps + 0.5 * pull_mps2 * to_s) * to_s;
    if (last_m >= 0) continue;
    // It may have been inside between, if it rises, turns and falls.
    const double first_mps = rate_mps + pull_mps2 * from_s;
    if (first_mps > 0 && rate_mps + pull_mps2 * to_s < 0 &&
        first_m - 0.5 * first_mps * first_mps / pull_mps2 >= 0)
      continue;
    return true;
  }
  return false;
}

}  // namespace sleight::physics
