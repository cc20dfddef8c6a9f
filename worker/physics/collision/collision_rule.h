// When do two things collide? The one rule of the simulator, a function of one tick.
//
//   touch     gap <= k_touch
//   approach  rate < -k_approach: how fast the gap changes, along the contact's normal
//   region    of a feature of static geometry: the closest point lies on the feature itself, not on
//             a neighbouring one
//
// Two things collide at the first tick, from a given one on, at which these hold together. Gap and
// rate are computed cold: from where the two are at that tick and how they move, by the functions
// below and no others. A search may skip the ticks that it can show to fail; at the others it asks
// here, or, where it needs to know for how long a condition goes on failing, compares what these
// functions give (sphere_search.h, which a test holds to this). So it doesn't matter how it came
// there, and all searches and engines give the same bits. Another size of either constant, or
// another order of the sums below, is another model: trajectories change.
//
// One thing answers without these functions: two balls in free flight meet in closed form
// (approach_of_free_spheres in sphere_search.h), which a test holds to this rule.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>

#include "worker/physics/distance/closest_points.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/surface/spline_surface.h"

namespace sleight::physics {

// ---- the rule -----------------------------------------------------------------------------------

/// `touch_m` is less than k_touch_m while a pair is refractory (recent_contacts.h).
inline bool touches(double gap_m, double touch_m = k_touch_m) {
  return gap_m <= touch_m;
}
inline bool approaches(double rate_mps) {
  return rate_mps < -k_approach_mps;
}
inline bool collides(double gap_m, double rate_mps, double touch_m = k_touch_m) {
  return touches(gap_m, touch_m) && approaches(rate_mps);
}

/// How two things are to each other at a tick.
struct GapAndRate {
  double gap_m = 0;
  double rate_mps = 0;  ///< of the gap
};
inline bool collides(const GapAndRate& between, double touch_m = k_touch_m) {
  return collides(between.gap_m, between.rate_mps, touch_m);
}

// ---- a sphere and a feature of static geometry, and two spheres ---------------------------------

/// A point that moves along a parabola.
struct MovingPoint {
  Vec3 position_m;
  Vec3 velocity_mps;
  Vec3 acceleration_mps2;
};

/// The set dot(normal, x) >= offset.
struct HalfSpace {
  Vec3 normal = Vec3::Zero();  ///< unit
  double offset_m = 0;
};

/// One feature of static geometry as spheres meet it: they touch where the centre's closest point
/// lies on it, which is where the centre is in its region.
struct SphereFeature {
  FeatureKind kind = FeatureKind::face;
  Vec3 point_m = Vec3::Zero();      ///< on the plane, an end of the edge, the vertex
  Vec3 direction = Vec3::Zero();    ///< a face's outward normal, an edge's direction; unit
  std::uint32_t regions_begin = 0;  ///< its half-spaces in the table of all
  std::uint32_t regions_end = 0;
};

/// One of the half-spaces that make up a feature's region. Faces take their sides closed and edges
/// and vertices open (`strict`), so each point belongs to exactly one feature.
struct RegionSide {
  HalfSpace space;
  bool strict = false;
};

/// How far a place is inside of one; negative if it is outside.
inline double inside_m(const RegionSide& side, const Vec3& place_m) {
  return math::dot(side.space.normal, place_m) - side.space.offset_m;
}
inline bool is_inside(const RegionSide& side, double depth_m) {
  return side.strict ? depth_m > 0 : depth_m >= 0;
}
inline bool is_inside(std::span<const RegionSide> sides, const Vec3& centre_m) {
  for (const RegionSide& side : sides) {
    if (!is_inside(side, inside_m(side, centre_m))) return false;
  }
  return true;
}

/// The part of a vector at right angles to an edge.
inline Vec3 across(const SphereFeature& edge, const Vec3& v) {
  return v - math::dot(edge.direction, v) * edge.direction;
}

/// Of a sphere whose centre is at `from_m` from some point of a face's plane.
inline GapAndRate gap_to_face(const SphereFeature& face, const Vec3& from_m,
                              const Vec3& velocity_mps, double radius_m) {
  return {.gap_m = math::dot(face.direction, from_m) - radius_m,
          .rate_mps = math::dot(face.direction, velocity_mps)};
}
/// Of a sphere at a distance from what is round (below), which has this product with its velocity.
inline GapAndRate gap_at_distance(double distance_m, double from_dot_velocity, double radius_m) {
  return {.gap_m = distance_m - radius_m, .rate_mps = from_dot_velocity / distance_m};
}
/// Of a sphere and what is round: a vertex, an edge, or another sphere, whose radius counts with
/// this one's. `from_m` is the way from there to the centre and the velocity that of the centre
/// against it; of an edge both are the parts across it. REQUIRES: `from_m` is not 0.
inline GapAndRate gap_to_round(const Vec3& from_m, const Vec3& velocity_mps, double radius_m) {
  return gap_at_distance(math::norm(from_m), math::dot(from_m, velocity_mps), radius_m);
}

/// Of two spheres, the second centre at `between_m` from the first.
inline double gap_of_spheres_m(const Vec3& between_m, double radii_m) {
  return math::norm(between_m) - radii_m;
}

/// Of a sphere and a feature, but for the region.
inline GapAndRate gap_between(const SphereFeature& feature, const MovingPoint& centre,
                              double radius_m) {
  const Vec3 from_m = centre.position_m - feature.point_m;
  switch (feature.kind) {
    case FeatureKind::face:
      return gap_to_face(feature, from_m, centre.velocity_mps, radius_m);
    case FeatureKind::edge:
      return gap_to_round(across(feature, from_m), across(feature, centre.velocity_mps), radius_m);
    case FeatureKind::vertex:
      break;
  }
  return gap_to_round(from_m, centre.velocity_mps, radius_m);
}
inline bool collides(const SphereFeature& feature, std::span<const RegionSide> sides,
                     const MovingPoint& centre, double radius_m) {
  return collides(gap_between(feature, centre, radius_m)) && is_inside(sides, centre.position_m);
}

// ---- two convex pieces --------------------------------------------------------------------------

/// A piece at a tick. What bounds motion must hold from then on. A sphere is a piece of one vertex
/// with a radius.
struct MovingPiece {
  const ConvexView* view = nullptr;
  double radius_m = 0;  ///< added all around
  PlacedPose pose{};
  /// Sum of the sizes of what a coordinate of the place was computed from, where that is more than
  /// the coordinate itself: the place is rounded by that (coordinates_m_max).
  double coordinates_m = 0;
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 acceleration_mps2 = Vec3::Zero();
  Vec3 angular_velocity_radps = Vec3::Zero();
  /// Of any point of the piece against the centre, at most, from now on.
  double turning_acceleration_mps2 = 0;
  bool turns_evenly = false;  ///< the angular velocity doesn't change
  /// Radius of a sphere about pose.position_m that holds the piece; infinite for what doesn't move.
  double reach_m = 0;
};

/// Whether it is one of round_piece.h.
inline bool is_round(const MovingPiece& piece) {
  return piece.view->round != nullptr;
}

inline Vec3 velocity_of(const MovingPiece& piece, const Vec3& point_m) {
  return piece.velocity_mps +
         math::cross(piece.angular_velocity_radps, point_m - piece.pose.position_m);
}

/// How two pieces meet at a tick.
struct PieceContact {
  double gap_m = 0;
  double rate_mps = 0;          ///< of the gap, at the closest points
  Vec3 normal = Vec3::Zero();   ///< unit, from A to B
  Vec3 point_m = Vec3::Zero();  ///< half way between the closest points
};
inline bool collides(const PieceContact& contact, double touch_m = k_touch_m) {
  return collides(contact.gap_m, contact.rate_mps, touch_m);
}

/// From scratch: a function of the two pieces' poses and velocities alone.
PieceContact contact_of(const MovingPiece& a, const MovingPiece& b);
/// The same, of closest points that a search has found from scratch (closest_cold).
PieceContact contact_from(const Closest& closest, const MovingPiece& a, const MovingPiece& b);
/// Of the half-space dot(normal, x) <= offset_m, at rest, and a piece.
PieceContact contact_of(const HalfSpace& solid_below, const MovingPiece& b);

/// Of two spheres, the second at `between_m` from the first. Without its rate.
inline PieceContact contact_of_spheres(const Vec3& place_a_m, const Vec3& between_m,
                                       double radius_a_m, double radius_b_m) {
  const double distance_m = math::norm(between_m);
  const Vec3 normal = between_m / distance_m;
  return {.gap_m = distance_m - (radius_a_m + radius_b_m),
          .normal = normal,
          .point_m = place_a_m + radius_a_m * normal};
}

// ---- a point of a body and a spline surface -----------------------------------------------------

/// Gaps of surfaces are vertical: how high a point is above one, and how fast that changes.
inline GapAndRate height_above(const SurfacePlace& below, const Vec3& place_m,
                               const Vec3& velocity_mps) {
  return {.gap_m = place_m.z() - below.height_m,
          .rate_mps = (velocity_mps.z() - below.slope_x * velocity_mps.x()) -
                      below.slope_y * velocity_mps.y()};
}
/// The rate along the surface's normal there, given the vertical one.
inline double rate_along_normal_mps(double vertical_mps, const Vec3& normal) {
  return vertical_mps * normal.z();
}

}  // namespace sleight::physics
