// When does a sphere meet another sphere, a plane, a face, an edge or a vertex?
//
// The question is always the same: the first tick, not before a given one, at which touch, approach
// and region hold together, as collision_rule.h has them.
//
// Idea. No polynomial of fourth degree is solved. The gap between a moving centre and a convex
// feature is convex along a straight line, so under a constant relative acceleration of which at
// most A points towards the feature
//
//   gap(t + h)  >= gap(t) + rate(t) h - A h^2 / 2
//   rate(t + h) >= rate(t) - A h
//
// and each condition that fails at a tick gives a span during which it must go on failing. The
// search skips the longest of them, at least a tick, and judges again from the segments alone. A
// sphere that rolls along an edge comes and goes so slowly that the second bound shows a few ticks;
// there c.v, with c from the edge or vertex to the centre, tells when the rate changes its sign:
//
//   c.v (t + h) = c.v + (v.v + c.a) h + 3/2 v.a h^2 + 1/2 a.a h^3
//
// For two balls in free flight A is 0 and the touch has a closed form; it is used as such.
//
// Invariants
//   1. A tick is skipped only under such a bound, lowered by the rounding of what was computed.
//   2. The verdict at a tick is a function of the two segments and the tick: where a search began,
//      and how far it was allowed to go, doesn't change its result.
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/event/tick.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/motion/free_flight.h"
#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

/// What a sphere touches is at least this part of its radius from its centre: a bound for searches.
inline constexpr double k_approach_at = 0.5;

/// Gap between a sphere and a feature's plane, line or point, its rate, and bounds on how that may
/// fall.
struct GapState {
  GapAndRate now;
  double fall_mps2 = 0;      ///< A above, >= 0
  double coordinates_m = 0;  ///< size of the numbers that the gap is the difference of
  // Of a line or a point: c.v of the centre c from it, which has the rate's sign, is a cubic in
  // time. Its first terms, without the last, which only raises it.
  bool is_round = false;
  double c_v = 0;         ///< m^2/s
  double c_v_rate = 0;    ///< v.v + c.a, m^2/s^2
  double c_v_second = 0;  ///< 3 v.a, m^2/s^3
  double least_c_v = 0;   ///< below this, as a positive number, it approaches
};

/// The rule's gap, and what bounds it from then on.
GapState gap_state(const SphereFeature& feature, const MovingPoint& centre, double radius_m);

/// Unit vector from the feature's closest point to the centre. REQUIRES: the centre is not on it.
Vec3 normal_at(const SphereFeature& feature, const Vec3& centre_m);

/// How long the conditions on gap and rate must go on failing together: 0 if both hold.
double failing_for_s(const GapState& state, double touch_m);

/// How long a centre must go on being outside of the region: 0 if it is inside.
double outside_for_s(std::span<const RegionSide> sides, const MovingPoint& centre);

/// Least h > 0 at which place + rate h + curvature h^2 / 2 falls to 0; infinite if never. Each root
/// is taken in the form without cancellation. REQUIRES: place >= 0.
inline double first_fall_s(double place, double rate, double curvature) {
  if (rate >= 0 && curvature >= 0) return k_forever_s;
  const double discriminant = rate * rate - 2 * curvature * place;
  if (!(discriminant >= 0)) return k_forever_s;
  const double root = std::sqrt(discriminant);
  return rate < 0 ? 2 * place / (root - rate) : (rate + root) / -curvature;
}

/// More than rounding does to a gap, at coordinates of up to a kilometre.
inline constexpr double k_clear_margin_m = 1e-9;

/// A quick answer: whether a sphere certainly doesn't collide with a feature for a while, as one of
/// the three conditions fails throughout. False says nothing. Costs a fifth of examine. Inline,
/// since spheres in a box of many features ask little else.
inline bool keeps_clear(const SphereFeature& feature, std::span<const RegionSide> sides,
                        const MovingPoint& centre, double radius_m, double span_s) {
  const double half_square = 0.5 * span_s * span_s;
  // The region: outside of one side throughout.
  for (const RegionSide& side : sides) {
    const Vec3& normal = side.space.normal;
    const double depth_m = inside_m(side, centre.position_m);
    const double comes_m = std::max(0.0, math::dot(normal, centre.velocity_mps)) * span_s +
                           std::max(0.0, math::dot(normal, centre.acceleration_mps2)) * half_square;
    if (depth_m + comes_m < -k_clear_margin_m) return true;
  }
  // The touch and the approach.
  const Vec3 from = centre.position_m - feature.point_m;
  const double reach_m = radius_m + (k_touch_m + k_clear_margin_m);
  if (feature.kind == FeatureKind::face) {
    const double rate_mps = math::dot(feature.direction, centre.velocity_mps);
    const double pull_mps2 = math::dot(feature.direction, centre.acceleration_mps2);
    const double excess_m = math::dot(feature.direction, from) - reach_m;
    const double falls_mps2 = std::min(0.0, pull_mps2);
    return excess_m + std::min(0.0, rate_mps) * span_s + falls_mps2 * half_square > 0 ||
           rate_mps + falls_mps2 * span_s > 0;
  }
  // The distance to a point or a line is at least what it is from a plane through that, at right
  // angles to the way there.
  Vec3 away = from;
  Vec3 velocity_mps = centre.velocity_mps;
  Vec3 pull_mps2 = centre.acceleration_mps2;
  if (feature.kind == FeatureKind::edge) {
    away -= math::dot(feature.direction, away) * feature.direction;
    velocity_mps -= math::dot(feature.direction, velocity_mps) * feature.direction;
    pull_mps2 -= math::dot(feature.direction, pull_mps2) * feature.direction;
  }
  const double distance2 = math::dot(away, away);
  const double comes = math::dot(away, velocity_mps);
  const double falls = std::min(0.0, math::dot(away, pull_mps2));
  // All times the distance: the plane's distance falls by this at most.
  const double loss = -(std::min(0.0, comes) * span_s + falls * half_square);
  if (distance2 > reach_m * reach_m) {
    const double left = distance2 - loss;
    if (left > 0 && left * left > reach_m * reach_m * distance2) return true;
  }
  // c.v grows with v.v >= 0; c.a falls by |a| times the way at most, and 3/2 v.a in the cubic.
  return false;
}

/// What a search says of a tick.
struct Examined {
  bool collides = false;
  Tick next{};       ///< if not: the next tick at which it may collide; k_never if it can't
  double gap_m = 0;  ///< if not, and if it is known: at that tick, at least
};

/// Judges one tick for a sphere and a feature. `centre` is the state at that tick.
Examined examine(const SphereFeature& feature, std::span<const RegionSide> sides,
                 const MovingPoint& centre, double radius_m, Tick tick);

/// Of a place's coordinates.
inline double size_of(const Vec3& place_m) {
  return std::max({std::fabs(place_m.x()), std::fabs(place_m.y()), std::fabs(place_m.z())});
}

/// Judges one tick for two spheres, given as the motion of the second centre against the first.
/// `coordinates_m` is the size of the coordinates of which `relative` is the difference; `touch_m`
/// stands for k_touch_m.
Examined examine_spheres(const MovingPoint& relative, double radii_m, double coordinates_m,
                         double touch_m, Tick tick);

/// What decides whether two spheres that keep their relative velocity collide, in two steps, so
/// that many pairs can be judged without a branch and the few that collide computed after.
struct SphereApproach {
  double towards = 0;       ///< < 0: they approach
  double excess = 0;        ///< of the squared distance over that of the touch
  double discriminant = 0;  ///< squared rate at the touch, times the squared reach
  bool collides = false;
};

/// From the dot products of the way from the first centre to the second, `between`, and of the
/// relative velocity. Inline, since a gas of spheres does little else.
inline SphereApproach approach_of_free_spheres(double towards, double distance2_m2,
                                               double speed2_m2ps2, double radii_m) {
  const double reach_m = radii_m + k_touch_m;
  const double excess = distance2_m2 - reach_m * reach_m;
  const double discriminant = towards * towards - speed2_m2ps2 * excess;
  // At the touch the rate is -sqrt(discriminant) / reach. Where they touch already it is a
  // collision if they approach fast enough, now or never, since the rate of two free spheres only
  // grows.
  const double slowest = k_approach_mps * reach_m;
  const bool touching = excess <= 0;
  const bool meets = static_cast<bool>((touching & (towards < -slowest)) |
                                       (!touching & (discriminant > slowest * slowest)));
  return {towards, excess, discriminant, static_cast<bool>((towards < 0) & meets)};
}

/// After what span they collide. REQUIRES: they do.
inline TickCount span_to_collision(const SphereApproach& approach) {
  if (approach.excess <= 0) return 0;
  return ticks_after(approach.excess / (std::sqrt(approach.discriminant) - approach.towards));
}

/// The collision as a span from the moment at which the second centre is at `between_m` from the
/// first; k_tick_max.value if there is none. Closed form.
inline TickCount collision_of_free_spheres(const Vec3& between_m, const Vec3& relative_mps,
                                           double radii_m) {
  const auto dot = [](const Vec3& a, const Vec3& b) {
    return (a.x() * b.x() + a.y() * b.y()) + a.z() * b.z();
  };
  const SphereApproach approach =
      approach_of_free_spheres(dot(between_m, relative_mps), dot(between_m, between_m),
                               dot(relative_mps, relative_mps), radii_m);
  return approach.collides ? span_to_collision(approach) : k_tick_max.value;
}

/// When two spheres in flight collide, each given by its flight's begin, place and velocity there;
/// k_never if they don't. `shift_m` is added to the second one's place.
template <class Flight>
Tick collision_of_flights(const Flight& first, const Flight& second, const Vec3& gravity_mps2,
                          const Vec3& shift_m, double radii_m) {
  // Both fall alike, so the later one's begin and the motion of one against the other decide.
  const Tick begin = std::max(first.begin, second.begin);
  const Vec3& g = gravity_mps2;
  const double s = seconds(begin - first.begin);
  const double t = seconds(begin - second.begin);
  Vec3 between_m;
  Vec3 relative_mps;
  for (int i = 0; i < 3; ++i) {
    const double p = parabola(first.position_m[i], first.velocity_mps[i], g[i], s);
    const double q = parabola(second.position_m[i], second.velocity_mps[i], g[i], t);
    between_m[i] = (q + shift_m[i]) - p;
    relative_mps[i] = (second.velocity_mps[i] + t * g[i]) - (first.velocity_mps[i] + s * g[i]);
  }
  const TickCount span = collision_of_free_spheres(between_m, relative_mps, radii_m);
  return span >= k_tick_max.value ? k_never : begin + span;
}

}  // namespace sleight::physics
