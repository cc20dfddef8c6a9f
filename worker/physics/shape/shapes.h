// Makes common solids, and bodies of several convex parts.
//
// Each solid's origin is its centre of mass, and its principal axes are x, y and z. So the solid's
// frame serves as the body's frame. If a size isn't positive and finite, the result is a ShapeError
// with the argument's index. Thread safety: pure functions and values.
#pragma once

#include <optional>
#include <vector>

#include "common/base/result.h"
#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/shape/round_piece.h"

namespace sleight::physics {

/// A body of convex parts, all in the body's frame. Distances and impacts are computed for each
/// part. Parts are numbered consecutively, polyhedra first.
struct Compound {
  std::vector<ConvexPolyhedron> parts;
  std::vector<RoundPiece> round_parts{};
  std::size_t size() const { return parts.size() + round_parts.size(); }
  /// A view of any part. The view is valid until the compound is changed, moved or destroyed.
  ConvexView view(std::size_t part) const;
  /// Radius of a ball that contains all parts. The ball's centre is the frame's origin.
  double r_outer_m() const;
};

/// If a compound consists of several round pieces about one axis, returns their hull, unless it has
/// too many features for a piece. Searches test the hull first. The test of the hull often saves
/// testing each part.
std::optional<RoundPiece> hull_of(const Compound& compound);

/// If a compound is a body of revolution about z through the frame's origin, returns this axis. All
/// parts must have axes along z too.
std::optional<Vec3> axis_of_revolution(const Compound& compound);

using ShapeResult = base::Result<ConvexPolyhedron, ShapeError>;

/// Eight vertices, six quadrilaterals. Inertia: general unless two or three sides are equal.
ShapeResult box(const Vec3& sides_m);
/// A cube. Inertia: spherical.
ShapeResult cube(double side_m);
/// A regular tetrahedron. Inertia: spherical.
ShapeResult tetrahedron(double circumradius_m);
/// An icosahedron; `subdivisions` times, each triangle is split in four. All vertices are on the
/// sphere. After 0 to 3 subdivisions, there are 12, 42, 162 or 642 of them. Inertia: spherical.
/// Error: too_many_points.
ShapeResult icosphere(double radius_m, int subdivisions);
/// An upright prism along z. The base is a regular polygon with at least 3 corners. Inertia: axial.
ShapeResult regular_prism(int corners, double radius_m, double height_m);

}  // namespace sleight::physics
