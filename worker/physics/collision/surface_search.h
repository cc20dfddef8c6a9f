// When does a moving box meet a spline surface?
//
// Idea. A box touches a surface with its corners and with a lattice of points on its edges and
// faces. The lattice is so dense that no bump slips through (StaticSurface::point_spacing_m). Each
// point's height above the surface, its rate and its second derivative are known now. The surface's
// derivatives near the box give a bound on the third derivative. So the height stays above a line
// minus a parabola, as in convex_search.h. Three bounds rule out most lattice points. Let the
// surface bend downwards by at most b and upwards by at most c, both per metre.
//   - Between the corners of a cell of radius r, heights are at least the lowest corner's height
//     minus b r^2 / 2.
//   - Let p be the lowest corner and m = (-S_x, -S_y, 1) at p. A point p + d is higher than p by at
//     least d.m - c |d|^2 / 2. Let d be a weighted sum of such vectors, with weights that sum to at
//     most 1. Then p + d is higher than p by at least the same weighted sum of the vectors' bounds.
//   - The same bound holds if p is any point of the box's edge and d leads across the face.
// Cells that these bounds don't settle are split. A box that settles is examined often while it
// hardly moves, and so is a box that rolls over a bump. Points far from the surface stay far for a
// while. So a search stores the few near points and a lower bound on the distance of all others.
// Later looks examine only some of the near points. A corner's room is the distance that the corner
// may come down before a point that isn't stored can touch. The rooms of other points are
// interpolated. The box is rigid and its faces are plane, so the greatest share of a room is used
// up at a corner. While the motion is unchanged, each point also stays clear for as long as its own
// bound allows.
//
// Gaps are vertical. The contact normal is the surface's normal, and a contact's rate is measured
// along it.
//
// Invariants
//   1. If the box touches, a look's verdict and contact depend only on the box's pose and motion.
//      If several points touch and approach, the contact is the point with the least gap. If gaps
//      are equal, the contact is the first point in lattice order.
//   2. A tick is skipped only if the bounds above exclude a collision. A point is left out only
//      where it can't touch. Stored points affect which ticks are skipped, never what collides or
//      when.
// Thread safety: none, because the surface caches lookups.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "worker/physics/collision/convex_search.h"
#include "worker/physics/surface/spline_surface.h"

namespace sleight::physics {

/// Lattice points of an edge of the box: the edge's ends and equally spaced points between them.
struct EdgeLattice {
  std::array<std::uint16_t, 2> end{};  ///< vertices of the box
  std::int32_t steps = 1;
};

/// Lattice points of a face. Point (i, j) is corner[0] + i/along (corner[1] - corner[0]) + j/across
/// (corner[3] - corner[0]).
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
  /// eight vertices and its faces are six parallelograms with at most k_steps_max steps per side.
  static std::optional<BoxLattice> of(const ConvexView& piece, double spacing_m);
  static constexpr std::int32_t k_steps_max = 1024;
};

struct NearPoints {
  static constexpr std::size_t k_most = 32;   ///< if there are more, each look finds them again
  std::array<Vec3, k_most> own_m{};           ///< in the box's frame
  std::array<std::uint32_t, k_most> order{};  ///< of the lattice
  /// By point, ascending. The point can't touch before a corner has used up this share of its room.
  std::array<double, k_most> share{};
  std::array<Tick, k_most> clear_until{};  ///< no collision before, if the motion is unchanged
  std::size_t count = 0;
  /// The corners' positions when the points were found, and their rooms: how far each corner may
  /// come down before any other point can touch. Rooms of points between corners are interpolated.
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

/// Computes the contact from scratch, at the point where the box touches and approaches. If there
/// is no such point, returns the contact at the lattice point with the least gap.
PieceContact contact_of(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box);

/// Examines one tick. If box and surface collide, `contact` is contact_of()'s result. `near` comes
/// from an earlier look, or is new. If the motion has changed since that look, call forget_motion
/// first.
Examined examine_surface(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box,
                         Tick tick, NearPoints& near, PieceContact& contact);

/// Calls found(point, surface normal) for up to k_surface_points_max points with gaps of at most
/// `near_m`. The points are the outermost ones, one per horizontal direction.
void points_near(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box,
                 double near_m, const std::function<void(const Vec3&, const Vec3&)>& found);

}  // namespace sleight::physics
