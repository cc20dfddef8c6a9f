// Makers of common solids, and bodies of several convex parts.
//
// All are centred at their centre of mass with principal axes along x, y, z, so their frame can be
// used as the body's. Sizes that are not positive and finite are a ShapeError whose index says
// which argument it was. Thread safety: pure functions and values.
#pragma once

#include <optional>
#include <vector>

#include "common/base/result.h"
#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/shape/round_piece.h"

namespace sleight::physics {

/// A body of convex parts, all in the body's frame; distances and impacts are per part. They are
/// numbered through, polyhedra first.
struct Compound {
  std::vector<ConvexPolyhedron> parts;
  std::vector<RoundPiece> round_parts{};
  std::size_t size() const { return parts.size() + round_parts.size(); }
  /// Of any part. Valid until the compound is changed, moved or destroyed.
  ConvexView view(std::size_t part) const;
  /// Every point of every part is this close to the frame's origin.
  double r_outer_m() const;
};

/// The hull of all parts of a compound, if these are round pieces about one axis, several of them,
/// and of no more features than a piece may have; for first looks, which then needn't ask each
/// part.
std::optional<RoundPiece> hull_of(const Compound& compound);

/// The axis of a compound that is a body of revolution about a line through the frame's origin,
/// where its parts' and its own axis are along z.
std::optional<Vec3> axis_of_revolution(const Compound& compound);

using ShapeResult = base::Result<ConvexPolyhedron, ShapeError>;

/// With these lengths of its sides. Eight vertices, six quadrilaterals; inertia: general unless two
/// or three sides are equal.
ShapeResult box(const Vec3& sides_m);
/// Inertia: spherical.
ShapeResult cube(double side_m);
/// Regular, with its vertices at this distance from the centre. Inertia: spherical.
ShapeResult tetrahedron(double circumradius_m);
/// An icosahedron whose triangles are split in four `subdivisions` times, all vertices on the
/// sphere of this radius: 12, 42, 162, 642 vertices for 0 to 3. Inertia: spherical.
/// Fails with too_many_points for more subdivisions.
ShapeResult icosphere(double radius_m, int subdivisions);
/// An upright prism along z over a regular polygon of this many corners (at least 3) on a circle of
/// this radius. Inertia: axial.
ShapeResult regular_prism(int corners, double radius_m, double height_m);

}  // namespace sleight::physics
