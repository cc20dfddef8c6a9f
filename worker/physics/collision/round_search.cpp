#include "worker/physics/collision/round_search.h"

#include <algorithm>
#include <cmath>

#include "worker/physics/collision/first_collision.h"
#include "worker/physics/collision/piece_motion.h"
#include "worker/physics/distance/round_distance.h"

namespace sleight::physics {
namespace {

/// The search margins below affect only the speed, and how late a collision may be
/// (piece_motion.h). Maximum number of chords in the search for the touch. After this many, the
/// span is good enough.
constexpr int k_chords_max = 8;
/// The first span tried, and its growth factor.
constexpr double k_first_span_s = 0x1p-9;
constexpr double k_span_growth = 4;

/// How far a turning piece reaches along an axis, if its points' acceleration is ignored.
class TurningReach {
 public:
  TurningReach(const MovingPiece& piece, const Vec3& axis)
      : piece_(piece),
        now_(transposed_product(piece.pose.rotation, axis)),
        rate_(transposed_product(piece.pose.rotation,
                                 math::cross(axis, piece.angular_velocity_radps))) {}
  double at_m(double h) const {
    return reach_of_m(*piece_.view, now_ + h * rate_) + piece_.radius_m;
  }

 private:
  const MovingPiece& piece_;
  Vec3 now_;
  Vec3 rate_;
};

/// Returns a bound on the difference between the true gap and a gap computed from scratch.
double error_m(const MovingPiece& a, const MovingPiece& b) {
  return rounding_m(a, b) + k_round_gap_error * (a.view->r_outer_m + b.view->r_outer_m +
                                                 math::norm(b.pose.position_m - a.pose.position_m));
}

/// A function of time: a lower bound of (two pieces' separation minus the touch distance).
class Bound {
 public:
  Bound(const MovingPiece& a, const MovingPiece& b, const Vec3& axis, double touch_m)
      : place_m_(math::dot(axis, b.pose.position_m - a.pose.position_m) - touch_m - error_m(a, b)),
        rate_mps_(math::dot(axis, b.velocity_mps - a.velocity_mps)),
        bends_mps2_(std::min(0.0, math::dot(axis, b.acceleration_mps2 - a.acceleration_mps2) -
                                      (a.turning_acceleration_mps2 + b.turning_acceleration_mps2))),
        of_a_(a, axis),
        of_b_(b, -axis) {}
  double at_m(double h) const {
    return place_m_ + h * (rate_mps_ + 0.5 * h * bends_mps2_) - (of_a_.at_m(h) + of_b_.at_m(h));
  }

 private:
  double place_m_;
  double rate_mps_;
  double bends_mps2_;
  TurningReach of_a_;
  TurningReach of_b_;
};

/// A function of time: a lower bound of (a piece's height above a half-space minus the touch
/// distance).
class PlaneBound {
 public:
  PlaneBound(const HalfSpace& below, const MovingPiece& b, double touch_m)
      : place_m_(math::dot(below.normal, b.pose.position_m) - below.offset_m - touch_m -
                 rounding_m(below, b)),
        rate_mps_(math::dot(below.normal, b.velocity_mps)),
        bends_mps2_(std::min(
            0.0, math::dot(below.normal, b.acceleration_mps2) - b.turning_acceleration_mps2)),
        of_b_(b, -below.normal) {}
  double at_m(double h) const {
    return place_m_ + h * (rate_mps_ + 0.5 * h * bends_mps2_) - of_b_.at_m(h);
  }

 private:
  double place_m_;
  double rate_mps_;
  double bends_mps2_;
  TurningReach of_b_;
};

/// Returns a lower bound on how long a concave bound stays above 0.
template <class BoundOfGap>
double stays_above_for_s(const BoundOfGap& bound) {
  double low_s = 0;
  double low_m = bound.at_m(0);
  if (!(low_m > 0)) return 0;
  const double first_m = low_m;
  double high_s = k_first_span_s;
  double high_m = bound.at_m(high_s);
  while (high_m > 0) {
    low_s = high_s;
    low_m = high_m;
    high_s *= k_span_growth;
    const double last_s = seconds(k_tick_max.value);
    if (low_s >= last_s) return k_forever_s;
    high_s = std::min(high_s, last_s);
    high_m = bound.at_m(high_s);
  }
  for (int i = 0; i < k_chords_max && low_m > 1e-3 * first_m; ++i) {
    // A chord reaches 0 before the bound does. Take a slightly earlier time to allow for rounding.
    constexpr double k_less = 1 - 0x1p-12;
    const double chord_s = low_s + k_less * (high_s - low_s) * (low_m / (low_m - high_m));
    const double chord_m = bound.at_m(chord_s);
    if (!(chord_m > 0)) return low_s;
    low_s = chord_s;
    low_m = chord_m;
    // Also try the middle, so that low_s and high_s both approach the bound's zero.
    const double middle_s = 0.5 * (low_s + high_s);
    const double middle_m = bound.at_m(middle_s);
    if (middle_m > 0) {
      low_s = middle_s;
      low_m = middle_m;
    } else {
      high_s = middle_s;
      high_m = middle_m;
    }
  }
  return low_s;
}

/// Returns the next look for two pieces that touch without colliding.
Examined touching(const MovingPiece& a, const MovingPiece& b, const PieceContact& contact,
                  Tick tick) {
  const double soon_s = std::min(comes_deeper_s(a, b, contact.normal), k_touching_s_max);
  Examined later = look_after(tick, std::max(soon_s, too_slow_for_s(a, b)));
  later.gap_m = contact.gap_m;
  return later;
}

Vec3 middle_of(const MovingPiece& piece) {
  return to_world(piece.pose, piece.view->centre_m);
}

}  // namespace

Examined examine_round(const MovingPiece& a, const MovingPiece& b, Tick tick, double touch_m,
                       SeparationCache& cache, PieceContact& contact) {
  // First try an earlier look's axis.
  if (cache.filled) {
    const Bound earlier(a, b, math::product(a.pose.rotation, cache.axis), touch_m);
    const double span_s = stays_above_for_s(earlier);
    if (span_s > k_long_enough_s) {
      Examined apart = look_after(tick, span_s);
      apart.gap_m = earlier.at_m(0) + touch_m;
      return apart;
    }
  }
  // Then try the line between the pieces' middles.
  const Vec3 between_m = middle_of(b) - middle_of(a);
  const double distance_m = math::norm(between_m);
  if (distance_m > 0) {
    const Bound guess(a, b, between_m / distance_m, touch_m);
    const double smaller_m =
        std::min(a.view->r_outer_m + a.radius_m, b.view->r_outer_m + b.radius_m);
    const double gap_m = guess.at_m(0);
    if (gap_m > k_well_apart * smaller_m) {
      Examined apart = look_after(tick, stays_above_for_s(guess));
      apart.gap_m = gap_m + touch_m;
      return apart;
    }
  }
  contact = contact_of(a, b);
  cache = {.axis = transposed_product(a.pose.rotation, contact.normal),
           .a = {},
           .b = {},
           .filled = true};
  if (collides(contact, touch_m)) return {.collides = true, .next = tick};
  if (touches(contact.gap_m, touch_m)) return touching(a, b, contact, tick);
  Examined apart = look_after(
      tick,
      std::max(stays_above_for_s(Bound(a, b, contact.normal, touch_m)), too_slow_for_s(a, b)));
  apart.gap_m = contact.gap_m - error_m(a, b);
  return apart;
}

Examined examine_round_plane(const HalfSpace& solid_below, const MovingPiece& b, Tick tick,
                             double touch_m, PieceContact& contact) {
  MovingPiece still;
  still.view = b.view;
  contact = contact_of(solid_below, b);
  if (collides(contact, touch_m)) return {.collides = true, .next = tick};
  if (touches(contact.gap_m, touch_m)) return touching(still, b, contact, tick);
  return look_after(tick, std::max(stays_above_for_s(PlaneBound(solid_below, b, touch_m)),
                                   too_slow_for_s(still, b)));
}

}  // namespace sleight::physics
