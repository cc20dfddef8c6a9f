// When does a sphere meet another sphere, a plane, a face, an edge or a vertex?
//
// A search finds the first tick at which the conditions of collision_rule.h all hold: touch,
// approach and region.
//
// Idea. No polynomial of fourth degree is solved. Along a straight line, the gap between a moving
// centre and a convex feature is convex. Let the relative acceleration be constant, and let its
// component towards the feature be at most A. Then
//
//   gap(t + h)  >= gap(t) + rate(t) h - A h^2 / 2,
//   rate(t + h) >= rate(t) - A h.
//
// So if a condition fails at a tick, it fails for a time that can be computed. The search skips the
// longest of these times, but at least one tick, and judges the next tick from the segments alone.
// A sphere that rolls along an edge approaches and leaves so slowly that the second bound skips few
// ticks. For such a sphere, the search uses c.v, where c leads from the edge or vertex to the
// centre. The sign of c.v is the sign of the rate:
//
//   c.v (t + h) = c.v + (v.v + c.a) h + 3/2 v.a h^2 + 1/2 a.a h^3.
//
// For two balls in free flight, A is 0, so the time of their touch is computed in closed form.
//
// Invariants
//   1. Such a bound is lowered by its inputs' rounding errors. A tick is skipped only if the
//      lowered bound excludes a collision.
//   2. The verdict at a tick depends only on the two segments and the tick. A search's first tick
//      and its limit don't change the result.
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

/// The distance from a sphere's centre to its contact point is at least this share of the radius.
/// For bounds only.
inline constexpr double k_approach_at = 0.5;

/// A sphere's gap to a feature's plane, line or point, and the gap's rate. Contains bounds on how
/// fast gap and rate can fall.
struct GapState {
  GapAndRate now;
  double fall_mps2 = 0;      ///< A above, >= 0
  double coordinates_m = 0;  ///< size of the numbers whose difference is the gap
  // For a line or a point only: let c lead from the line or point to the centre. The sign of c.v is
  // the sign of the rate. c.v is a cubic in time; its last term is left out, because it only raises
  // c.v.
  bool is_round = false;
  double c_v = 0;         ///< m^2/s
  double c_v_rate = 0;    ///< v.v + c.a, m^2/s^2
  double c_v_second = 0;  ///< 3 v.a, m^2/s^3
  double least_c_v = 0;   ///< the sphere approaches if c.v is below minus this number
};

/// Returns gap and rate as collision_rule.h does, and bounds on how fast they can fall.
GapState gap_state(const SphereFeature& feature, const MovingPoint& centre, double radius_m);

/// Returns the unit vector from the feature's closest point to the centre. REQUIRES: they differ.
Vec3 normal_at(const SphereFeature& feature, const Vec3& centre_m);

/// Returns a time for which the conditions on gap and rate can't both hold. If both hold now,
/// returns 0.
double failing_for_s(const GapState& state, double touch_m);

/// Returns a time for which the centre certainly stays outside the region. If the centre is inside,
/// returns 0.
double outside_for_s(std::span<const RegionSide> sides, const MovingPoint& centre);

/// Returns the least h > 0 at which place + rate h + curvature h^2 / 2 falls to 0, or k_forever_s
/// if there is none. Computes each root in the form without cancellation. REQUIRES: place >= 0.
inline double first_fall_s(double place, double rate, double curvature) {
  if (rate >= 0 && curvature >= 0) return k_forever_s;
  const double discriminant = rate * rate - 2 * curvature * place;
  if (!(discriminant >= 0)) return k_forever_s;
  const double root = std::sqrt(discriminant);
  return rate < 0 ? 2 * place / (root - rate) : (rate + root) / -curvature;
}

/// If coordinates are at most a kilometre, the rounding error of a gap is less than this margin.
inline constexpr double k_clear_margin_m = 1e-9;

/// Returns true if one of the three conditions fails throughout `span_s`, so that the sphere
/// doesn't collide with the feature. False means unknown. This check costs a fifth of examine().
/// Inline, because it usually suffices in a box of many features.
inline bool keeps_clear(const SphereFeature& feature, std::span<const RegionSide> sides,
                        const MovingPoint& centre, double radius_m, double span_s) {
  const double half_square = 0.5 * span_s * span_s;
  // Check the region: the centre may stay outside one side throughout.
  for (const RegionSide& side : sides) {
    const Vec3& normal = side.space.normal;
    const double depth_m = inside_m(side, centre.position_m);
    const double comes_m = std::max(0.0, math::dot(normal, centre.velocity_mps)) * span_s +
                           std::max(0.0, math::dot(normal, centre.acceleration_mps2)) * half_square;
    if (depth_m + comes_m < -k_clear_margin_m) return true;
  }
  // Touch and approach.
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
  // Replace the feature's point or line by a plane that contains it and is perpendicular to `from`.
  // The distance to this plane is at most the distance to the feature.
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
  // All terms are multiplied by the distance. The distance to the plane falls by at most `loss`.
  const double loss = -(std::min(0.0, comes) * span_s + falls * half_square);
  if (distance2 > reach_m * reach_m) {
    const double left = distance2 - loss;
    if (left > 0 && left * left > reach_m * reach_m * distance2) return true;
  }
  return false;
}

/// A search's result for a tick.
struct Examined {
  bool collides = false;
  Tick next{};  ///< if there is no collision: the next tick at which one is possible, or k_never
  double gap_m = 0;  ///< without collision: lower bound of the gap now, if known
};

/// Judges one tick. `centre` is the motion of the centre at the tick.
Examined examine(const SphereFeature& feature, std::span<const RegionSide> sides,
                 const MovingPoint& centre, double radius_m, Tick tick);

/// Returns the largest absolute coordinate of a place.
inline double size_of(const Vec3& place_m) {
  return std::max({std::fabs(place_m.x()), std::fabs(place_m.y()), std::fabs(place_m.z())});
}

/// Judges one tick for two spheres. `relative` is the second centre's motion relative to the first.
/// `coordinates_m` is the size of the centres' coordinates. `touch_m` replaces k_touch_m.
Examined examine_spheres(const MovingPoint& relative, double radii_m, double coordinates_m,
                         double touch_m, Tick tick);

/// Whether two spheres with constant relative velocity collide. This first step has no branch, so
/// it judges many pairs fast. For the few pairs that collide, span_to_collision then computes the
/// time.
struct SphereApproach {
  double towards = 0;       ///< negative: the spheres approach
  double excess = 0;        ///< squared distance minus the squared distance at the touch
  double discriminant = 0;  ///< squared rate at the touch, times the squared reach
  bool collides = false;
};

/// Returns two spheres' approach. `towards` is the dot product of relative position and relative
/// velocity (second sphere minus first sphere). Inline, because a gas of spheres does little else.
inline SphereApproach approach_of_free_spheres(double towards, double distance2_m2,
                                               double speed2_m2ps2, double radii_m) {
  const double reach_m = radii_m + k_touch_m;
  const double excess = distance2_m2 - reach_m * reach_m;
  const double discriminant = towards * towards - speed2_m2ps2 * excess;
  // At the touch the rate is -sqrt(discriminant) / reach. If the spheres already touch, they
  // collide now or never, because their gap's rate only grows.
  const double slowest = k_approach_mps * reach_m;
  const bool touching = excess <= 0;
  const bool meets = static_cast<bool>((touching & (towards < -slowest)) |
                                       (!touching & (discriminant > slowest * slowest)));
  return {towards, excess, discriminant, static_cast<bool>((towards < 0) & meets)};
}

/// REQUIRES: the spheres collide.
inline TickCount span_to_collision(const SphereApproach& approach) {
  if (approach.excess <= 0) return 0;
  return ticks_after(approach.excess / (std::sqrt(approach.discriminant) - approach.towards));
}

/// Computes the time span until the collision in closed form. Returns k_tick_max.value if there is
/// none. At the span's start, `between_m` leads from the first centre to the second.
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

/// Returns the tick at which two spheres in free flight collide, or k_never. `first` and `second`
/// each have a start tick (begin), and the position and velocity at that tick. `shift_m` is added
/// to the second sphere's position.
template <class Flight>
Tick collision_of_flights(const Flight& first, const Flight& second, const Vec3& gravity_mps2,
                          const Vec3& shift_m, double radii_m) {
  // Both spheres have the same acceleration, so the collision depends only on the relative motion
  // since the later start.
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
