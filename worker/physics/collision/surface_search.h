// When does a box in motion meet a spline surface?
//
// Idea. A box meets a surface with its corners and with a lattice of points on its edges and faces,
// so close that no bump slips through (StaticSurface::point_spacing_m). Each point's height above
// the surface is known now, so are its rate and its second derivative, and the third one has a
// bound by the surface's derivatives near the box; so the height lies above a line less a parabola,
// as in convex_search.h. Three bounds spare the lattice most of its points, from how much the
// surface may bend down, b per metre, and up, c per metre:
//   - between the corners of a cell, heights are no less than the least of theirs less b r^2 / 2,
//     with r the radius of the cell;
//   - with the lowest corner p and m = (-S_x, -S_y, 1) there, a point p + d is higher than p by at
//     least d.m - c |d|^2 / 2. What is a sum of some d, with weights that sum to at most 1, is
//     higher by at least the same sum of these;
//   - the same with each point of an edge of the box for p, and d across the face.
// Cells that these don't settle are split. And what is not near the surface stays so for a while: a
// box that settles, or rolls over a bump, is looked at again and again where it hardly moves. So a
// search keeps the few points that are near, with how far away all others are at least. Of those it
// looks only at some again: a box is rigid and its faces plane, so a point comes down by no greater
// share of what it may than one of the corners does; and while the motion stays as it was, each
// point is clear for as long as its own bound has said.
//
// Gaps are vertical, contacts' normals and rates those of the surface.
//
// Invariants
//   1. At a look within the touch the verdict and the contact are functions of the box's pose and
//      motion alone: of all points that touch and approach, the contact is the one with the least
//      gap, the first of these in the order of the lattice.
//   2. A look is skipped only under the bounds above, and a point left out only where it can't
//      touch: what a search has kept changes which ticks are skipped, never what collides, or when.
// Thread safety: none: the surface keeps what it was asked for.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "worker/physics/collision/convex_search.h"
#include "worker/physics/surface/spline_surface.h"

namespace sleight::physics {

/// Points of an edge of the box: its ends, and what lies between them in equal steps.
struct EdgeLattice {
  std::array<std::uint16_t, 2> end{};  ///< vertices of the box
  std::int32_t steps = 1;
};

/// The points of a face: corner[0] + i/along of the way to corner[1] + j/across to corner[3].
struct FaceLattice {
  std::array<std::uint16_t, 4> corner{};  ///< vertices of the box, in order around the face
  std::int32_t along = 1;                 ///< steps, at least 1
  std::int32_t across = 1;
};

/// The points of a box.
struct BoxLattice {
  std::array<EdgeLattice, 12> edges;
  std::array<FaceLattice, 6> faces;
  std::int32_t steps_most = 1;  ///< of any edge
  /// With points no further apart than this. Nothing unless the piece is a box: eight vertices, six
  /// parallelograms; or if a face had more than k_steps_max steps to a side.
  static std::optional<BoxLattice> of(const ConvexView& piece, double spacing_m);
  static constexpr std::int32_t k_steps_max = 1024;
};

/// Those points of a box that are near a surface.
struct NearPoints {
  static constexpr std::size_t k_most = 32;   ///< if there are more, each look finds them again
  std::array<Vec3, k_most> own_m{};           ///< in the box's frame
  std::array<std::uint32_t, k_most> order{};  ///< of the lattice
  /// By point, ascending: it can't touch until some corner has come down by this share of its room.
  std::array<double, k_most> share{};
  std::array<Tick, k_most> clear_until{};  ///< none collides before, in the motion as it was
  std::size_t count = 0;
  /// Where the corners were, and how far each of them may come down against the surface before any
  /// other point touches. Others come down by what lies between, as they do.
  std::array<Vec3, 8> corners_m{};
  std::array<double, 8> allowed_m{};
  std::array<double, 8> per_allowed{};  ///< 1 / allowed_m
  double slope = 0;  ///< of the surface wherever no corner has gone further than room_m
  double room_m = 0;
  bool known = false;

  /// The next one in the order of the lattice. REQUIRES: count < k_most.
  void keep(const Vec3& point_m, double of_share);
  /// Before a look at the box in another motion than at the last look.
  void forget_motion() { clear_until.fill(Tick{}); }
};

/// From scratch: where the box touches and approaches, or, if it doesn't, its corner or lattice
/// point with the least gap.
PieceContact contact_of(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box);

/// One look. If they collide, `contact` is contact_of's result. `near` is of an earlier look, or a
/// fresh one; when the motion has changed since that, it forgets that first.
Examined examine_surface(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box,
                         Tick tick, NearPoints& near, PieceContact& contact);

/// Calls found(point, normal of the surface) for points that are within near_m of the surface: of
/// all the outermost ones, at most k_surface_points_max.
void points_near(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box,
                 double near_m, const std::function<void(const Vec3&, const Vec3&)>& found);

}  // namespace sleight::physics
