// Computes the mass, centre, inertia and own frame of a body made of convex parts.
//
// Idea. A body of uniform density is a union of convex parts that do not overlap. Each part is cut
// into tetrahedra. A tetrahedron joins the part's centre to a triangle of a face. A tetrahedron's
// volume, first moments and second moments are exact polynomials of its corners (Tonon, "Explicit
// exact formulas for the 3-D tetrahedron inertia tensor in terms of its vertex coordinates",
// Journal of Mathematics and Statistics 1, 2004). The covariance form is from Blow and Binstock
// ("How to find the inertia tensor of a 3D solid body", 2004): the integral of x x^T over the
// tetrahedron (0, a, b, c) of volume V is V/20 (a a^T + b b^T + c c^T + s s^T) with s = a + b + c.
//
// The maker of a shape declares its symmetry, which selects how free rotation is computed. The
// declaration is checked; symmetry is never guessed from rounded numbers.
// Thread safety: pure functions.
#pragma once

#include <span>
#include <vector>

#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/shape/convex_polyhedron.h"

namespace sleight::physics {

/// If moments are declared equal, they may differ by this share of the largest moment.
inline constexpr double k_moment_tolerance = 1e-9;

struct MassProperties {
  double volume_m3 = 0;
  double mass_kg = 0;
  Vec3 centre_m = Vec3::Zero();      ///< centre of mass, in the parts' frame
  Mat3 inertia_kgm2 = Mat3::Zero();  ///< about the centre of mass, in the parts' frame's axes
};

/// REQUIRES: at least one part; density > 0. Where parts overlap, mass counts once for each part.
MassProperties mass_properties(std::span<const ConvexPolyhedron> parts, double density_kgpm3);

struct PrincipalAxes {
  Vec3 moments = Vec3::Zero();
  Mat3 axes = Mat3::Identity();  ///< the columns are the moments' unit axes; determinant 1
};

/// Computes the eigenvalues and eigenvectors of a symmetric matrix by cyclic Jacobi rotations
/// (Golub and Van Loan, "Matrix computations", 3rd edition, 8.4). The axes' order and signs are
/// those closest to the given frame. So a diagonal matrix gives the identity. Errors are some 1e-15
/// of the largest entry. Reads only the upper triangle. REQUIRES: finite.
PrincipalAxes principal_axes(const Mat3& symmetric);

/// A body in its own frame: origin in the centre of mass, principal axes along x, y, z.
struct BodyShape {
  std::vector<ConvexPolyhedron> parts;  ///< in the body's frame
  Inertia inertia;
  Pose frame;  ///< the body's frame in the frame of the given parts
};

/// Moves parts into the body's frame. The axes depend on the declared symmetry.
///   - Spherical: The axes are those of the given frame. The moments are set to their mean.
///   - Axial: The z axis is the axis of the moment that differs. The z axis has the direction whose
///     largest component is positive. The x axis is as close as possible to the given x (or to y if
///     z is near x). The moments about x and y are set to their mean.
///   - General: The axes are the principal axes, with the order and signs closest to the given
///     frame.
///
/// Fails with no_parts, dimension_not_positive (index 0: the density), not_spherical or not_axial.
base::Result<BodyShape, ShapeError> in_body_frame(std::span<const ConvexPolyhedron> parts,
                                                  double density_kgpm3, InertiaSymmetry declared);

/// Returns the inertia of a solid ball of even density: 2/5 m r^2.
Inertia solid_ball_inertia(double mass_kg, double radius_m);

}  // namespace sleight::physics
