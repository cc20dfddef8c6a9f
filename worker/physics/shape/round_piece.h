// Round pieces, such as capsules, cylinders, cones and parts of pins: convex hulls of balls and of
// rings about one axis.
//
// A ball has a centre and a radius. A ring is a solid torus: a circle about the piece's axis, and
// all points within a radius of the circle. A ring whose circle has radius 0 is a ball on the axis.
// The piece is the convex hull of all its features. The piece's reach in a unit direction u (its
// support) is
//   h(u) = max over its features of c.u + R |u across the axis| + r,
// where c is the feature's centre, R is the circle's radius (0 for a ball), and r is the radius
// around the circle.
//
// No edge is perfectly sharp: each r is at least k_round_edge_min of the piece's size, like the
// edges of real things. A piece's margin is its least r. If two touching pieces are reduced by
// their margins, they are apart, and the line between them gives the contact's direction
// (distance/round_distance.h).
//
// A piece of revolution has all its features on the axis. If a half-plane that begins at the axis
// cuts the piece, the section is the hull of discs. The profile, its outline there, is a chain of
// arcs and straight lines. The arcs are stored in order, and so are the lines' normals.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/shape/shape_error.h"

namespace sleight::physics {

inline constexpr std::size_t k_round_features_max = 64;
/// Minimum r of a feature, as a share of the piece's size. The size is the distance from the origin
/// to the furthest point.
inline constexpr double k_round_edge_min = 1e-4;

struct RoundBall {
  Vec3 centre_m = Vec3::Zero();
  double radius_m = 0;
};
/// A ring. The ring's circle is perpendicular to the axis.
struct RoundRing {
  double height_m = 0;  ///< height of the centre along the axis, from the piece's origin
  double circle_m = 0;  ///< radius of the circle; 0: a ball
  double radius_m = 0;  ///< around the circle
};
struct RoundDescription {
  Vec3 origin_m = Vec3::Zero();  ///< a point of the axis
  Vec3 axis = Vec3::UnitZ();     ///< unit
  std::vector<RoundRing> rings;
  std::vector<RoundBall> balls;
};

struct RoundFeature {
  Vec3 centre_m = Vec3::Zero();
  double height_m = 0;  ///< height of the centre along the axis, from the piece's origin
  double circle_m = 0;
  double radius_m = 0;
};

/// A direction in a half-plane that begins at the axis. One component points away from the axis,
/// the other along it.
struct ProfileNormal {
  double across = 0;  ///< >= 0
  double along = 0;
};
/// A feature's arc of the profile, from its top normal down to its bottom normal.
struct ProfileArc {
  std::uint32_t feature = 0;
  ProfileNormal from;
  ProfileNormal to;
};

class RoundPiece {
 public:
  /// Makes a piece. Omits features that other features contain. Fails with no_parts,
  /// too_many_features, no_axis, not_finite, dimension_not_positive (for a radius), or sharp (if r
  /// is below k_round_edge_min of the size). The error's `index` counts the rings, then the balls.
  static base::Result<RoundPiece, ShapeError> make(const RoundDescription& description);

  std::span<const RoundFeature> features() const { return features_; }
  const Vec3& axis() const { return axis_; }
  /// A point of the axis.
  const Vec3& origin_m() const { return origin_m_; }
  /// The least r of all features.
  double margin_m() const { return margin_m_; }
  /// Radius of a ball that contains the piece. The ball's centre is the frame's origin.
  double r_outer_m() const { return r_outer_m_; }
  const Vec3& centre_m() const { return centre_m_; }

  /// Returns whether all features are on the axis.
  bool of_revolution() const { return !arcs_.empty(); }
  /// The arcs of the profile, from the top downwards. Empty unless of_revolution().
  std::span<const ProfileArc> arcs() const { return arcs_; }
  /// Outward normals of the straight parts, flat ends included.
  std::span<const ProfileNormal> flats() const { return flats_; }
  /// Returns the radius of a piece of revolution at a height along its axis; 0 above and below the
  /// piece.
  double radius_at_m(double height_m) const;

  /// Calls offer(feature, reach) for each feature. A feature's reach along a direction u of any
  /// length is c.u + R |u across| + r. `across` is |u across|. Inline, because most search time is
  /// spent here.
  template <class Offer>
  void for_each_reach(const Vec3& direction, double across, const Offer& offer) const {
    if (of_revolution()) {
      const double along = math::dot(axis_, direction);
      const double origin_m = math::dot(origin_m_, direction);
      for (const RoundFeature& feature : features_)
        offer(feature, origin_m + ((feature.height_m * along + feature.circle_m * across) +
                                   feature.radius_m));
      return;
    }
    for (const RoundFeature& feature : features_)
      offer(feature, (math::dot(feature.centre_m, direction) + feature.circle_m * across) +
                         feature.radius_m);
  }
  /// Returns the greatest reach of all features.
  double reach_m(const Vec3& direction) const;

  /// A view without vertices. The view is valid until this piece is changed, moved or destroyed.
  ConvexView view() const;

 private:
  RoundPiece() = default;
  void drop_held();
  void find_profile();
  ProfileArc arc_from(std::uint32_t feature, const ProfileNormal& from, std::uint32_t& next) const;

  std::vector<RoundFeature> features_;
  std::vector<ProfileArc> arcs_;
  std::vector<ProfileNormal> flats_;
  Vec3 axis_ = Vec3::UnitZ();
  Vec3 origin_m_ = Vec3::Zero();
  Vec3 centre_m_ = Vec3::Zero();
  double margin_m_ = 0;
  double r_outer_m_ = 0;
};

/// Returns the length of a vector's component perpendicular to a unit axis.
inline double length_across(const Vec3& axis, const Vec3& v) {
  const Vec3 part = v - math::dot(axis, v) * axis;
  return math::norm(part);
}

}  // namespace sleight::physics
