// For a part of a ball's path, computes the earliest time at which the ball may collide with a
// feature.
//
// Idea. A ball usually collides with only a few of the features near its path, and late on the
// path. Three parabolas along a feature's own directions give a bound on the first possible
// collision. Computing the bound costs a tenth of testing one tick. The caller tests the ticks
// after the bound (marbles_predictions.cpp).
//
// Faces. Let n be a face's normal and q a point of the face. The height n.(p - q) of the centre p
// is a parabola in time. If the centre's height curves downwards, it is lowest at an end of the
// path.
//
// Edges and vertices. Let c be the initial vector from an edge's line, or a vertex, to the centre.
// The plane perpendicular to c gives |c(h)| >= c.c(h) / |c|. The right side is also a parabola. The
// square c.c is a polynomial in time. The polynomial's first three terms are a parabola, and the
// other terms are bounded.
//
// Regions. For a half-space, the bound is the parabola's maximum between two times.
//
// Invariants
//   1. Before the returned time, examine (sphere_search.h) finds no collision of the ball with the
//      feature. The condition on touch, approach or region fails, even with rounding. A shorter
//      path may use a longer path's margins.
//   2. Every margin is at least 4 times the bound's rounding error. Let N be the sum of all sizes
//      added on the way: size_m, or size_m times the speed for c.v. A bound has fewer than 16
//      roundings, each of 2^-53 N.
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/marbles/four.h"
#include "worker/physics/marbles/near_features.h"

namespace sleight::physics {

namespace detail {

/// Shortens a root's time to cover its rounding.
inline constexpr double k_root_shrink = 1 - 0x1p-40;

/// Relative rounding of sums of products.
inline constexpr double k_sum_ulps = 0x1p-46;

inline Four parabolas(const Four& place, const Four& speed, const Four& pull, double s) {
  return place + (speed + pull * Four::all(0.5 * s)) * Four::all(s);
}

}  // namespace detail

/// A centre's parabola for a time span, and the margins for bounds on it.
struct PathPart {
  Four place_m;
  Four velocity_mps;
  Four pull_mps2;
  double span_s = 0;
  double size_m = 0;    ///< upper bound of the sum of |coordinates| along the path and nearby
  double travel_m = 0;  ///< upper bound of the path's length along all axes together
  double touch_m = 0;   ///< distance between a centre and a face at which they may touch
  double near_m = 0;    ///< the same plus the path's travel, for tests at its start
  double near_m2 = 0;
  double floor_mps = 0;      ///< above this rate, a gap doesn't shrink
  double floor_m2ps = 0;     ///< the same for c.v (corners)
  double side_margin_m = 0;  ///< margin of region sides

  /// Sets the margins, also for any part of this path that ends sooner. REQUIRES: the fields above
  /// are set. `around_m`: sum of |coordinates| of nearby features.
  void sets_margins(double around_m, double radius_m) {
    const double for_s = span_s;
    const double pull_mps = sum(fabs(pull_mps2)) * for_s;
    const double speed_mps = sum(fabs(velocity_mps));
    travel_m = (speed_mps + 0.5 * pull_mps) * for_s;
    size_m = around_m + sum(fabs(place_m)) + travel_m;
    touch_m = radius_m + (k_touch_m + k_rounding_ulps * size_m);
    const double rounding_mps = detail::k_sum_ulps * (speed_mps + pull_mps);
    floor_mps = rounding_mps - k_approach_mps;
    // The centre approaches if c.v < -|c| k_approach. |c| is at least half the ball's radius.
    floor_m2ps = rounding_mps * size_m - 0.5 * k_approach_at * k_approach_mps * radius_m;
    side_margin_m = k_clear_margin_m + k_rounding_ulps * size_m;
    near_m = near_m2 = k_forever_s;
  }
  /// Sets near_m. `way_m` is an upper bound of the path's length along all axes together, usually
  /// less than travel_m.
  void goes(double way_m) {
    near_m = touch_m + way_m;
    near_m2 = near_m * near_m;
  }
};

/// Bounding box of the centre between two times of its flight, without margins.
struct PathExtent {
  Four low_m;
  Four high_m;
};
inline PathExtent extent_between(const Four& first_m, const Four& last_m, const Four& velocity_mps,
                                 const Four& pull_mps2, const Four& last_mps) {
  PathExtent extent{min(first_m, last_m), max(first_m, last_m)};
  // If the velocity changes its sign, the apex is between both times, and the pull is not 0.
  const Four turns = velocity_mps * last_mps;
  if (!is_any_negative(turns)) return extent;
  const Four apex =
      choose_if_less(turns, Four::zero(),
                     first_m - Four::all(0.5) * velocity_mps * velocity_mps / pull_mps2, first_m);
  return {min(extent.low_m, apex), max(extent.high_m, apex)};
}
inline PathExtent extent_of(const Four& place_m, const Four& velocity_mps, const Four& pull_mps2,
                            double span_s) {
  return extent_between(place_m, detail::parabolas(place_m, velocity_mps, pull_mps2, span_s),
                        velocity_mps, pull_mps2, velocity_mps + pull_mps2 * Four::all(span_s));
}

/// Returns a lower bound for the time in which a point stays between two walls on each axis.
/// REQUIRES: the point is between the walls, and they are finite.
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
  // A point that slows down meets the wall ahead before its apex. If it doesn't reach this wall, it
  // meets the wall behind.
  const Four square = v * v;
  const Four at_ahead = square + twice * ahead;
  const Four root = sqrt(choose_if_less(at_ahead, zero, square - twice * behind, at_ahead));
  // Avoid 0 / 0. For a point at rest at a wall, the bound is 0.
  const Four sum_of_speeds = max(v + root, Four::all(1e-300));
  return k_less * least(choose_if_less(at_ahead, zero, sum_of_speeds, ahead + ahead) /
                        choose_if_less(at_ahead, zero, zero - a, sum_of_speeds));
}

/// Returns the earliest time t at which a gap can be below 0 and shrink. The gap is at least
/// excess_m + rate_mps t + pull_mps2 t^2 / 2. It doesn't shrink before `not_before_s`.
inline double falls_after_s(double excess_m, double rate_mps, double pull_mps2,
                            double not_before_s) {
  if (excess_m > 0) return std::max(not_before_s, first_fall_s(excess_m, rate_mps, pull_mps2));
  const double discriminant = rate_mps * rate_mps - 2 * pull_mps2 * excess_m;
  if (pull_mps2 < 0 && rate_mps > 0 && discriminant > 0) {
    // The gap first grows, then falls back.
    const double root = std::sqrt(discriminant);
    if (-2 * excess_m <= not_before_s * (rate_mps + root))
      return std::max(not_before_s, (rate_mps + root) / -pull_mps2);
  }
  return not_before_s;
}

/// Returns the earliest time at which a centre may touch a face's plane and approach it, or
/// infinity.
inline double face_not_before_s(const PathPart& path, const SphereFeature& face) {
  const Four normal = Four::of(face.direction);
  const double above_m = dot(normal, path.place_m - Four::of(face.point_m));
  if (above_m > path.near_m) return k_forever_s;
  const double rate_mps = dot(normal, path.velocity_mps);
  const double pull_mps2 = dot(normal, path.pull_mps2);
  // The centre never approaches.
  const double last_rate_mps = rate_mps + pull_mps2 * path.span_s;
  if (rate_mps > path.floor_mps && last_rate_mps > path.floor_mps) return k_forever_s;
  // If the gap is positive at both ends and has no minimum between them, the centre never touches
  // the plane. touch_m includes a rounding margin.
  const double excess_m = above_m - path.touch_m;
  if (excess_m > 0 && (pull_mps2 <= 0 || last_rate_mps <= 0) &&
      excess_m + 0.5 * (rate_mps + last_rate_mps) * path.span_s > 0)
    return k_forever_s;
  const double not_before_s =
      rate_mps > 0 && pull_mps2 < 0 ? rate_mps / -pull_mps2 : 0;  // moves away until then
  return detail::k_root_shrink * falls_after_s(excess_m, rate_mps, pull_mps2, not_before_s);
}

/// The vector c from a corner (an edge's line or a vertex) to a centre. At an edge, c is
/// perpendicular to the edge.
struct CornerWay {
  Four along;  ///< the edge's direction; 0 for a vertex
  Four c;
  double c_c;
};
inline CornerWay corner_way(const PathPart& path, const SphereFeature& corner) {
  const Four along = Four::of(corner.direction);
  const Four from = path.place_m - Four::of(corner.point_m);
  const Four c = from - Four::all(dot(along, from)) * along;
  return {.along = along, .c = c, .c_c = dot(c, c)};
}

/// Returns the touch distance plus rounding errors. c has the rounding error of coordinates. The
/// rounding error of c.c is relative to the size of c.c. Along the path, this size is at most 2
/// (travel_m^2 + c_c). The distance's error is the error of c.c divided by the diameter.
inline double corner_reach_m(const PathPart& path, const CornerWay& way, double radius_m) {
  const double square = path.travel_m * path.travel_m + way.c_c;
  return (radius_m + k_touch_m) + detail::k_sum_ulps * (path.size_m + 2 * square / radius_m);
}

/// Returns the earliest time at which a centre may touch and approach an edge's line or a vertex,
/// or infinity.
inline double corner_not_before_s(const PathPart& path, const CornerWay& way, double radius_m) {
  const double span_s = path.span_s;
  const double reach_m = corner_reach_m(path, way, radius_m);
  const double square = reach_m * reach_m;
  const double first_c_v = dot(way.c, path.velocity_mps);
  const double first_c_a = dot(way.c, path.pull_mps2);
  // The plane perpendicular to c may show that the centre never touches the corner. The distance
  // from this plane is lowest at an end of the span. If the centre turns back within the span, the
  // computed bound is lower than the true one.
  if (way.c_c > square) {
    const double last_c_v = first_c_v + first_c_a * span_s;
    const double change =
        first_c_a <= 0 || last_c_v <= 0 ? 0.5 * (first_c_v + last_c_v) : first_c_v;
    const double left = way.c_c + std::min(0.0, change) * span_s;
    if (left > 0 && left * left > square * way.c_c) return k_forever_s;
  }
  const Four v = path.velocity_mps - Four::all(dot(way.along, path.velocity_mps)) * way.along;
  const Four a = path.pull_mps2 - Four::all(dot(way.along, path.pull_mps2)) * way.along;
  const double v_a = dot(v, a);
  const double a_a = dot(a, a);
  const double c_v_rate = dot(v, v) + first_c_a;
  double s = 0;
  constexpr int k_steps_max = 8;
  for (int step = 0; step < k_steps_max; ++step) {
    const double half = 0.5 * a_a * s;
    const double c_c = way.c_c + (2 * first_c_v + (c_v_rate + (v_a + 0.5 * half) * s) * s) * s;
    const double c_v = first_c_v + (c_v_rate + (1.5 * v_a + half) * s) * s;
    const double rate = c_v_rate + 3 * (v_a + half) * s;
    const double bend = v_a + 2 * half;
    // The centre doesn't approach while c.v is positive. The last term of c.v only raises c.v.
    const double left = c_v - path.floor_m2ps;
    const double not_before_s = left > 0 ? first_fall_s(left, rate, 3 * bend) : 0;
    if (!(detail::k_root_shrink * (s + not_before_s) <= span_s)) return k_forever_s;
    // After a further time h, half of c.c's excess is: excess + c.v h + rate h^2 / 2 + bend h^3 / 2
    // + a.a h^4 / 8. The last two terms are at least bend h^2 / 2 times the remaining time.
    const double least_rate = rate + std::min(0.0, bend) * (span_s - s);
    const double fails_s = falls_after_s(0.5 * (c_c - square), c_v, least_rate, not_before_s);
    const double then_s = detail::k_root_shrink * (s + fails_s);
    if (!(then_s <= span_s)) return k_forever_s;
    constexpr double k_close = 1 + 0x1p-14;
    const bool close = then_s <= k_close * s + k_seconds_per_tick;
    s = then_s;
    if (close) break;
  }
  return s;
}

/// Returns whether a centre stays beyond one side of a region, and so outside it, between two
/// times.
inline bool stays_outside(std::span<const RegionSide> sides, const PathPart& path, double from_s,
                          double to_s) {
  const Four first_m = detail::parabolas(path.place_m, path.velocity_mps, path.pull_mps2, from_s);
  const double for_s = to_s - from_s;
  for (std::size_t i = sides.size(); i-- > 0;) {
    const Four normal = Four::of(sides[i].space.normal);
    const double inside_m = dot(normal, first_m) - (sides[i].space.offset_m - path.side_margin_m);
    if (inside_m >= 0) continue;
    const double pull_mps2 = dot(normal, path.pull_mps2);
    const double rate_mps = dot(normal, path.velocity_mps) + pull_mps2 * from_s;
    const double last_rate_mps = rate_mps + pull_mps2 * for_s;
    if (inside_m + 0.5 * (rate_mps + last_rate_mps) * for_s >= 0) continue;
    // If the centre rises and then falls, it may be inside between the two times.
    if (rate_mps > 0 && last_rate_mps < 0 && inside_m - 0.5 * rate_mps * rate_mps / pull_mps2 >= 0)
      continue;
    return true;
  }
  return false;
}

/// Let two balls stay in two boxes. Returns a lower bound for the squared distance of their
/// centres.
inline double apart_m2(const TouchBox& a, const TouchBox& b, double radius_m) {
  const Four gaps_m =
      max(Four::of(a.low_m) - Four::of(b.high_m), Four::of(b.low_m) - Four::of(a.high_m)) +
      Four::axes(2 * radius_m);
  const Four apart_m = max(gaps_m, Four::zero());
  return dot(apart_m, apart_m);
}

}  // namespace sleight::physics
