// Makers of round bodies of even density, with their moments of inertia: capsule, cylinder, cone,
// coin, rounded box, bowling pin.
//
// Each is centred at its centre of mass, and z is its axis, so its frame can be used as the body's.
// Edges are rounded: of a cylinder by `edge_m` (round_piece.h says why no edge is quite sharp).
// Sizes are those of the whole, edges included. Sizes that are not positive and finite are a
// ShapeError whose index says which argument it was.
//
// Mass and moments are integrals over the profile r(z): dm = density pi r^2 dz,
//   about the axis r^2/2 dm, across it (r^2/4 + (z - centre)^2) dm,
// by Gauss and Legendre's rule between the profile's corners, in an angle, since a profile begins
// and ends like a root. Errors are below 1e-9 of
// them, or 1e-4 where pieces overlap whose profiles cross between corners. Thread safety: pure
// functions and values.
#pragma once

#include <span>
#include <vector>

#include "common/base/result.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/shape/round_piece.h"

namespace sleight::physics {

/// The parts and the inertia of a body.
struct RoundSolid {
  std::vector<RoundPiece> parts;
  Inertia inertia;
  double foot_m = 0;  ///< depth of its lowest point below the centre of mass, along z
};
using RoundResult = base::Result<RoundSolid, ShapeError>;

/// The union of pieces of revolution about z, each the hull of its rings, re-centred along z.
/// Inertia: axial. The mass counts once where pieces overlap.
RoundResult solid_of_revolution(std::span<const std::vector<RoundRing>> pieces,
                                double density_kgpm3);

/// Two balls of this radius, with their centres so far apart along z, and what is between.
RoundResult capsule(double radius_m, double between_m, double density_kgpm3);
RoundResult cylinder(double radius_m, double height_m, double edge_m, double density_kgpm3);
/// Its tip, in the direction of z, and the edge of its base are rounded.
RoundResult cone(double radius_m, double height_m, double edge_m, double density_kgpm3);
/// A cylinder whose edges are rounded by a quarter of its thickness.
RoundResult coin(double radius_m, double thickness_m, double density_kgpm3);
/// A box of these sides, all its edges and corners rounded by one radius, less than half of the
/// least side. Inertia: general, or what equal sides make it.
RoundResult rounded_box(const Vec3& sides_m, double edge_m, double density_kgpm3);

/// A ten-pin bowling pin that stands along z. Its profile is that of the heights and diameters of
/// the United States Bowling Congress's equipment specifications, joined by a cubic spline that is
/// level at 13.5 in, with a dome of radius 1.273 in above and a rim of radius 5/32 in below, to 0.4
/// mm. Ten parts: the belly, the neck in eight, the head. Mass and
/// moments are those of the spline.
RoundResult bowling_pin(double mass_kg);

/// Radius of the pin's profile at a height above its foot, of the spline itself; for pictures and
/// tests. 0 outside.
double bowling_pin_radius_m(double height_m);

}  // namespace sleight::physics
