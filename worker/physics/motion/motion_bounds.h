// Bounds on motion in free flight, for bounding volumes and for searches that skip ticks.
//
// Idea. A body is inside a sphere about its centre of mass, and the centre follows a parabola.
// Along an axis, the parabola's extent follows from its two ends, and from its apex if the apex is
// between them (thesis figure 3.2). rotation_bounds.h bounds the rotation.
//
// Invariants
//   1. Bounds hold for the rounded results of position_at and orientation_at at whole ticks, not
//      just for the exact motion.
//   2. All results depend only on the arguments, and on a tick only through its difference from
//      `begin`.
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/motion/rotation_bounds.h"

namespace sleight::physics {

/// Motion whose centre follows a parabola from `begin` on, such as a FreeFlight. Any evaluation of
/// the position may err by at most 2^-51 (|p| + |v| s + |a| s^2/2) per coordinate.
template <class T>
concept OnParabola = requires(const T& motion) {
  { motion.begin } -> std::convertible_to<Tick>;
  { motion.position_m } -> std::convertible_to<Vec3>;
  { motion.velocity_mps } -> std::convertible_to<Vec3>;
  { motion.acceleration_mps2 } -> std::convertible_to<Vec3>;
};

static_assert(OnParabola<FreeFlight>);

namespace detail {

/// Returns a float below x, at most two floats away. A conversion errs by up to 2^-24 |x| or
/// 2^-150.
inline float float_below(double x) {
  return static_cast<float>(x - (std::fabs(x) * 0x1p-23 + 0x1p-149));
}

inline float float_above(double x) {
  return static_cast<float>(x + (std::fabs(x) * 0x1p-23 + 0x1p-149));
}

/// Returns the sum of a parabola's absolute terms, to which rounding errors are proportional.
inline double magnitude(double position, double velocity, double acceleration, double s) {
  return parabola(std::fabs(position), std::fabs(velocity), std::fabs(acceleration), s);
}

/// Returns the time, in seconds, for which a point stays between two walls. The point starts at the
/// distances `ahead` > 0 and `behind` > 0 from the walls. The point moves towards the wall ahead at
/// `speed` >= 0. The `acceleration` towards the wall ahead has any sign. Roots avoid cancellation.
inline double seconds_between(double ahead, double behind, double speed, double acceleration) {
  // If the acceleration is 0, the formula below has the same result, because `root` is the speed.
  if (acceleration == 0) return ahead / speed;
  const double square = speed * speed;
  const double discriminant = square + 2 * acceleration * ahead;
  // A decelerating point meets the wall ahead, or turns back and meets the wall behind.
  const bool meets_ahead = acceleration >= 0 || (discriminant >= 0 && speed > 0);
  const double root = std::sqrt(meets_ahead ? discriminant : square - 2 * acceleration * behind);
  return meets_ahead ? 2 * ahead / (speed + root) : (speed + root) / -acceleration;
}

}  // namespace detail

/// Returns a box that contains the sphere about position_at(motion, t) for every t in [from, to].
/// Each corner is too far out by at most two floats. REQUIRES: begin <= from <= to <= k_tick_max;
/// radius >= 0; everything finite.
template <OnParabola Motion>
Box path_box(const Motion& motion, double radius_m, Tick from, Tick to) {
  const double s_from = seconds(from - motion.begin);
  const double s_to = seconds(to - motion.begin);
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const double p = motion.position_m[axis];
    const double v = motion.velocity_mps[axis];
    const double a = motion.acceleration_mps2[axis];
    const double first = parabola(p, v, a, s_from);
    const double last = parabola(p, v, a, s_to);
    const double apex_s = a != 0 ? std::clamp(-v / a, s_from, s_to) : s_from;
    const double apex = parabola(p, v, a, apex_s);
    // The margin is twice the error that OnParabola permits, plus the rounding of the sums here.
    const double reach = radius_m + 0x1p-50 * (detail::magnitude(p, v, a, s_to) + radius_m);
    const auto index = static_cast<std::size_t>(axis);
    box.low_m[index] = detail::float_below(std::min(std::min(first, last), apex) - reach);
    box.high_m[index] = detail::float_above(std::max(std::max(first, last), apex) + reach);
  }
  return box;
}

/// Returns a tick until which the sphere stays in the box, including that tick. Returns k_tick_max
/// if the sphere never leaves, and from - 1 if the sphere is not inside at `from`. The walls are
/// moved inwards by 2^-49 (|p| + |v| s + 3 |a| s^2 + radius) + 2^-44 width. Here v is the velocity
/// at `from`, which is s seconds after `begin`. The result is before the exit through the moved
/// walls, by at most one tick plus 2^-39 (result - from). REQUIRES: begin <= from <= k_tick_max;
/// radius >= 0; everything finite.
template <OnParabola Motion>
Tick exit_tick(const Box& box, const Motion& motion, double radius_m, Tick from) {
  const double s = seconds(from - motion.begin);
  double stays_s = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const auto index = static_cast<std::size_t>(axis);
    const double low = static_cast<double>(box.low_m[index]);
    const double high = static_cast<double>(box.high_m[index]);
    const double a = motion.acceleration_mps2[axis];
    const double v = motion.velocity_mps[axis] + a * s;
    const double p = parabola(motion.position_m[axis], motion.velocity_mps[axis], a, s);
    // Rounding errors, here and in evaluations up to the exit, are below 16 roundings of the
    // parabola's terms. The width of the box bounds the terms after `from`. If a parabola stays
    // between the walls for a time T, |v| T and |a| T^2/2 are at most 4 times the distance between
    // the walls (Markov's inequality).
    const double terms = std::fabs(motion.position_m[axis]) +
                         (std::fabs(v) + 3 * std::fabs(a) * s) * s + 32 * (high - low) + radius_m;
    const double margin = radius_m + 0x1p-49 * terms;
    const double up = (high - p) - margin;
    const double down = (p - low) - margin;
    // Thinner gaps would underflow below. This test also refuses NaN.
    constexpr double k_gap_min = 0x1p-300;
    if (!(up > k_gap_min && down > k_gap_min)) return from - 1;
    const double axis_s = v >= 0 ? detail::seconds_between(up, down, v, a)
                                 : detail::seconds_between(down, up, -v, -a);
    stays_s = std::min(stays_s, axis_s);
  }
  // The margins cover the rounding of the roots; `k_shrink` covers the roundings after the roots.
  constexpr double k_shrink = 1 - 0x1p-40;
  const TickCount stays = ticks_before(stays_s * k_shrink);
  return stays >= k_tick_max - from ? k_tick_max : from + stays;
}

/// Returns the greatest speed of the centre of mass between two ticks. The maximum is at one of
/// these ticks, because |v|^2 is convex. REQUIRES: begin <= from <= to.
template <OnParabola Motion>
double centre_speed_mps_max(const Motion& motion, Tick from, Tick to) {
  const Vec3 first = motion.velocity_mps + seconds(from - motion.begin) * motion.acceleration_mps2;
  const Vec3 last = motion.velocity_mps + seconds(to - motion.begin) * motion.acceleration_mps2;
  constexpr double k_margin = 1 + 0x1p-30;
  return std::sqrt(std::max(math::dot(first, first), math::dot(last, last))) * k_margin;
}

/// Returns how far rounding can move evaluated positions. If a point of the body is within the
/// radius of the centre, its evaluated positions at any ticks t1 < t2 in [begin, to] differ by at
/// most
///   (t2 - t1) (centre_speed_mps_max + turning_speed_mps_max) + rounding_m_max(...).
/// A search that skips ticks subtracts this from the gap first. REQUIRES: `rotation` holds this
/// motion's bounds; begin <= to.
template <OnParabola Motion>
double rounding_m_max(const Motion& motion, const RotationBounds& rotation, double radius_m,
                      Tick to) {
  const double s = seconds(to - motion.begin);
  double terms = 0;
  for (int axis = 0; axis < 3; ++axis)
    terms += detail::magnitude(motion.position_m[axis], motion.velocity_mps[axis],
                               motion.acceleration_mps2[axis], s);
  return 0x1p-49 * (terms + (4 + rotation.phase_rate_radps * s) * radius_m);
}

/// Sums the absolute terms of each of the centre's coordinates, and returns the greatest sum. The
/// centre's rounding errors are proportional to it.
inline double coordinates_m_max(const FreeFlight& flight, Tick t) {
  const double s = seconds_since_begin(flight, t);
  double most_m = 0;
  for (int axis = 0; axis < 3; ++axis)
    most_m = std::max(most_m, detail::magnitude(flight.position_m[axis], flight.velocity_mps[axis],
                                                flight.acceleration_mps2[axis], s));
  return most_m;
}

}  // namespace sleight::physics
