// Makes round bodies of even density and computes their moments of inertia: capsule, cylinder,
// cone, coin, rounded box, bowling pin.
//
// Each shape's origin is its centre of mass, and its axis is z. So the shape's frame serves as the
// body's frame. Edges are rounded by `edge_m` (round_piece.h explains why). Sizes include the
// edges. If a size isn't positive and finite, the result is a ShapeError with the argument's index.
//
// Mass and moments are integrals over the profile r(z), where dm = density pi r^2 dz:
//   about the axis r^2/2 dm, across it (r^2/4 + (z - centre)^2) dm.
// The integrals use the Gauss-Legendre rule between the profile's corners. The integration variable
// is an angle, because a profile begins and ends like a square root. Relative errors are below
// 1e-9. If pieces overlap and their profiles cross between corners, errors are below 1e-4. Thread
// safety: pure functions and values.
#pragma once

#include <span>
#include <vector>

#include "common/base/result.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/shape/round_piece.h"

namespace sleight::physics {

struct RoundSolid {
  std::vector<RoundPiece> parts;
  Inertia inertia;
  double volume_m3 = 0;
  double foot_m = 0;  ///< depth of the lowest point below the centre of mass, along z
};
using RoundResult = base::Result<RoundSolid, ShapeError>;

/// Each piece of revolution about z is the hull of its rings. Makes the union of the pieces and
/// centres it along z. Inertia: axial. Overlapping volume counts once.
RoundResult solid_of_revolution(std::span<const std::vector<RoundRing>> pieces,
                                double density_kgpm3);

/// The hull of two balls. The balls' centres are `between_m` apart along z.
RoundResult capsule(double radius_m, double between_m, double density_kgpm3);
RoundResult cylinder(double radius_m, double height_m, double edge_m, double density_kgpm3);
/// A cone with its tip in the direction of z. The tip and the edge of the base are rounded.
RoundResult cone(double radius_m, double height_m, double edge_m, double density_kgpm3);
/// A cylinder whose edges are rounded by a quarter of its thickness.
RoundResult coin(double radius_m, double thickness_m, double density_kgpm3);
/// A box of these side lengths. All edges and corners are rounded by one radius, at most half of
/// the least side. The inertia's symmetry depends on the number of equal sides.
RoundResult rounded_box(const Vec3& sides_m, double edge_m, double density_kgpm3);

/// A ten-pin bowling pin standing along z. The profile is a cubic spline through the heights and
/// diameters that the United States Bowling Congress specifies. The spline is level at 13.5 in.
/// Above it is a dome of radius 1.273 in, and below it a rim of radius 5/32 in, to 0.4 mm. The ten
/// parts are the belly, eight parts of the neck, and the head. Mass and moments follow from the
/// spline.
RoundResult bowling_pin(double mass_kg);

inline constexpr double k_bowling_pin_height_m = 15 * 0.0254;
/// Returns the spline's radius at a height above the pin's foot, or 0 outside. For pictures and
/// tests.
double bowling_pin_radius_m(double height_m);

}  // namespace sleight::physics
