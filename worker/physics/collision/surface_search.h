// When does a moving box meet a spline surface?
//
// Idea. A box touches a surface with its corners and with a lattice of points on its edges and
// faces. The lattice is so dense that no bump slips through (StaticSurface::point_spacing_m). Each
// point's height above the surface, its rate and its second derivative are known now. The third
// derivative has a bound, by the surface's derivatives near the box. So the height stays above a
// line minus a parabola, as in convex_search.h. Three bounds rule out most lattice points. The
// bounds use the surface's maximum downward bend b and upward bend c, both per metre:
//   - Between the corners of a cell of radius r, heights are at least the corners' least height
//     minus b r^2 / 2.
//   - Let p be the lowest corner and m = (-S_x, -S_y, 1) at p. A point p + d is higher than p by at
//     least d.m - c |d|^2 / 2. If d is a weighted sum of such vectors, with weights that sum to at
//     most 1, the height grows by at least the same sum of their bounds.
//   - The same bound holds if p is any point of the box's edge and d leads across the face.
// Cells that these bounds don't settle are split. A box that settles, or rolls over a bump, is
// examined repeatedly while it hardly moves, and points far from the surface stay far for a while.
// So a search stores the few near points and a lower bound on the distance of all others. Later
// looks examine only some of the near points. A corner's room is how far it may come down before a
// point that isn't stored can touch; other points' rooms are interpolated. The box is rigid with
// plane faces, so no point uses up a greater share of its room than the corners do. While the
// motion is unchanged, each point also stays clear for as long as its own bound allows.
//
// Gaps are vertical. Contact normals are the surface's, and contact rates are measured along them.
//
// Invariants
//   1. If the box touches, a look's verdict and contact depend only on the box's pose and motion.
//      If several points touch and approach, the contact is the one with the least gap; on a tie,
//      the first in lattice order.
//   2. A look is skipped only under the bounds above, and a point is left out only where it can't
//      touch. Stored points affect which ticks are skipped, never what collides or when.
// Thread safety: none, because the surface caches lookups.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "worker/physics/collision/convex_search.h"
#include "worker/physics/surface/spline_surface.h"

namespace sleight::physics {

/// Lattice points of a box's edge: its ends and equally spaced points between them.
struct EdgeLattice {
  std::array<std::uint16_t, 2> end{};  ///< vertices of the box
  std::int32_t steps = 1;
};

/// Lattice points of a face. Point (i, j) is corner[0], plus i/along of the way to corner[1], plus
/// j/across of the way to corner[3].
struct FaceLattice {
  std::array<std::uint16_t, 4> corner{};  ///< vertices of the box, in order around the face
  std::int32_t along = 1;                 ///< number of steps, at least 1
  std::int32_t across = 1;
};

struct BoxLattice {
  std::array<EdgeLattice, 12> edges;
  std::array<FaceLattice, 6> faces;
  std::int32_t steps_most = 1;  ///< maximum over all edges
  /// Builds a lattice with points at most `spacing_m` apart. Returns nothing unless the piece has
  /// eight vertices and six parallelograms as faces, with at most k_steps_max steps to a side.
  static std::optional<BoxLattice> of(const ConvexView& piece, double spacing_m);
  static constexpr std::int32_t k_steps_max = 1024;
};

struct NearPoints {
  static constexpr std::size_t k_most = 32;   ///< if there are more, each look finds them again
  std::array<Vec3, k_most> own_m{};           ///< in the box's frame
  std::array<std::uint32_t, k_most> order{};  ///< of the lattice
  /// By point, ascending. Until a corner has used up this share of its room, the point can't touch.
  std::array<double, k_most> share{};
  std::array<Tick, k_most> clear_until{};  ///< no collision before, if the motion is unchanged
  std::size_t count = 0;
  /// The corners' positions when the points were found, and how far each may come down before any
  /// other point can touch. Bounds for points between corners are interpolated.
  std::array<Vec3, 8> corners_m{};
  std::array<double, 8> allowed_m{};
  std::array<double, 8> per_allowed{};  ///< 1 / allowed_m
  double slope = 0;  ///< maximum slope of the surface while no corner has moved further than room_m
  double room_m = 0;
  bool known = false;

  /// Adds the next point in lattice order. REQUIRES: count < k_most.
  void keep(const Vec3& point_m, double of_share);
  /// Call before a look if the box's motion has changed since the last look.
  void forget_motion() { clear_until.fill(Tick{}); }
};

/// Computes the contact from scratch: the point where the box touches and approaches. If no point
/// does, returns the corner or lattice point with the least gap.
PieceContact contact_of(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box);

/// Examines one tick. If box and surface collide, `contact` is contact_of()'s result. `near`: from
/// an earlier look, or new. If the motion has changed since then, call forget_motion first.
Examined examine_surface(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box,
                         Tick tick, NearPoints& near, PieceContact& contact);

/// Calls found(point, surface normal) for the k_surface_points_max outermost points within near_m.
void points_near(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box,
                 double near_m, const std::function<void(const Vec3&, const Vec3&)>& found);

}  // namespace sleight::physics
