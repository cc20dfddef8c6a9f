// When do two things collide? This header evaluates, at one tick, the simulator's only rule:
//
//   - Touch: gap <= k_touch.
//   - Approach: rate < -k_approach; `rate` is the gap's rate of change along the contact normal.
//   - Region (static geometry only): the closest point is on the given feature, not on a neighbour.
//
// Two things collide at the first tick at which all these conditions hold. The functions below
// compute gap and rate from scratch: they use only both positions and motions at the tick. A search
// may skip ticks at which it can show that a condition fails. At all other ticks the search calls
// these functions. The search for spheres (sphere_search.h) evaluates the conditions with its own
// code, because it computes how long a condition keeps failing. A test checks that this search
// agrees with the rule. So a verdict doesn't depend on the search, and all searches and engines
// give the same bits. If a constant or the order of a sum below changes, trajectories change.
//
// For two balls in free flight, the collision is computed in closed form instead
// (approach_of_free_spheres in sphere_search.h). A test checks that the closed form agrees with
// this rule.
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

struct GapAndRate {
  double gap_m = 0;
  double rate_mps = 0;
};
inline bool collides(const GapAndRate& between, double touch_m = k_touch_m) {
  return collides(between.gap_m, between.rate_mps, touch_m);
}

// ---- a sphere and a feature of static geometry, and two spheres ---------------------------------

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

/// A feature of static geometry. A sphere can touch the feature only while the sphere's centre is
/// in the feature's region. If the centre is in the region, the point of the geometry closest to
/// the centre is on the feature.
struct SphereFeature {
  FeatureKind kind = FeatureKind::face;
  Vec3 point_m = Vec3::Zero();      ///< on the face's plane, at an end of the edge, or the vertex
  Vec3 direction = Vec3::Zero();    ///< unit: the face's outward normal or the edge's direction
  std::uint32_t regions_begin = 0;  ///< its half-spaces in the table of all regions
  std::uint32_t regions_end = 0;
};

/// A half-space of a feature's region. A face's region includes its boundary. The regions of edges
/// and vertices exclude their boundaries (`strict`). So each point belongs to exactly one region.
struct RegionSide {
  HalfSpace space;
  bool strict = false;
};

/// Returns the depth of a point inside a side's half-space. The depth is negative if the point is
/// outside.
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

/// Returns the component of a vector perpendicular to an edge.
inline Vec3 across(const SphereFeature& edge, const Vec3& v) {
  return v - math::dot(edge.direction, v) * edge.direction;
}

/// `from_m` leads from any point of the face's plane to the sphere's centre.
inline GapAndRate gap_to_face(const SphereFeature& face, const Vec3& from_m,
                              const Vec3& velocity_mps, double radius_m) {
  return {.gap_m = math::dot(face.direction, from_m) - radius_m,
          .rate_mps = math::dot(face.direction, velocity_mps)};
}
/// Returns the same as gap_to_round(), from the length of `from_m` and its dot product with the
/// velocity.
inline GapAndRate gap_at_distance(double distance_m, double from_dot_velocity, double radius_m) {
  return {.gap_m = distance_m - radius_m, .rate_mps = from_dot_velocity / distance_m};
}
/// Returns gap and rate of a sphere and a round object: a vertex, an edge or another sphere. For
/// another sphere, `radius_m` is the sum of both radii. `from_m` leads from the object to the
/// sphere's centre. `velocity_mps` is the centre's velocity relative to the object. For an edge,
/// pass only those components of both vectors that are perpendicular to the edge. REQUIRES:
/// `from_m` is not 0.
inline GapAndRate gap_to_round(const Vec3& from_m, const Vec3& velocity_mps, double radius_m) {
  return gap_at_distance(math::norm(from_m), math::dot(from_m, velocity_mps), radius_m);
}

/// `between_m` leads from the first centre to the second.
inline double gap_of_spheres_m(const Vec3& between_m, double radii_m) {
  return math::norm(between_m) - radii_m;
}

/// Doesn't check the region.
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

/// A convex piece at a tick. The bounds on the piece's motion hold from this tick on. A sphere is a
/// piece with one vertex and a radius.
struct MovingPiece {
  const ConvexView* view = nullptr;
  double radius_m = 0;  ///< added all around the vertices' hull
  PlacedPose pose{};
  /// Each coordinate of the position was computed as a sum. coordinates_m is the greatest sum of
  /// absolute terms (coordinates_m_max). The position's rounding error is proportional to
  /// coordinates_m.
  double coordinates_m = 0;
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 acceleration_mps2 = Vec3::Zero();
  Vec3 angular_velocity_radps = Vec3::Zero();
  /// Maximum acceleration of any point of the piece relative to the centre, from now on.
  double turning_acceleration_mps2 = 0;
  bool turns_evenly = false;  ///< the angular velocity is constant
  /// Radius about pose.position_m that contains the piece. Infinite: the piece doesn't move.
  double reach_m = 0;
};

inline bool is_round(const MovingPiece& piece) {
  return piece.view->round != nullptr;
}

inline Vec3 velocity_of(const MovingPiece& piece, const Vec3& point_m) {
  return piece.velocity_mps +
         math::cross(piece.angular_velocity_radps, point_m - piece.pose.position_m);
}

struct PieceContact {
  double gap_m = 0;
  double rate_mps = 0;          ///< of the gap, at the closest points
  Vec3 normal = Vec3::Zero();   ///< unit, from A to B
  Vec3 point_m = Vec3::Zero();  ///< half way between the closest points
};
inline bool collides(const PieceContact& contact, double touch_m = k_touch_m) {
  return collides(contact.gap_m, contact.rate_mps, touch_m);
}

/// Computes the contact from only the two pieces' poses and velocities.
PieceContact contact_of(const MovingPiece& a, const MovingPiece& b);
/// Returns the same as contact_of(). `closest` must have been found from scratch (closest_cold).
PieceContact contact_from(const Closest& closest, const MovingPiece& a, const MovingPiece& b);
/// Returns the contact of a piece and a half-space at rest. The half-space is dot(normal, x) <=
/// offset_m.
PieceContact contact_of(const HalfSpace& solid_below, const MovingPiece& b);

/// Returns two spheres' contact without its rate. `between_m` leads from the first centre to the
/// second.
inline PieceContact contact_of_spheres(const Vec3& place_a_m, const Vec3& between_m,
                                       double radius_a_m, double radius_b_m) {
  const double distance_m = math::norm(between_m);
  const Vec3 normal = between_m / distance_m;
  return {.gap_m = distance_m - (radius_a_m + radius_b_m),
          .normal = normal,
          .point_m = place_a_m + radius_a_m * normal};
}

// ---- a point of a body and a spline surface -----------------------------------------------------

/// Returns a point's gap and rate. The gap is the point's height above the spline surface.
inline GapAndRate height_above(const SurfacePlace& below, const Vec3& place_m,
                               const Vec3& velocity_mps) {
  return {.gap_m = place_m.z() - below.height_m,
          .rate_mps = (velocity_mps.z() - below.slope_x * velocity_mps.x()) -
                      below.slope_y * velocity_mps.y()};
}
/// Converts a vertical rate to the rate along the surface's normal.
inline double rate_along_normal_mps(double vertical_mps, const Vec3& normal) {
  return vertical_mps * normal.z();
}

}  // namespace sleight::physics
