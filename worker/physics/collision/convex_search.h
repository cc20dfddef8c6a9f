// When do two moving convex pieces meet?
//
// Idea. Along a fixed axis n, the separation of pieces A and B is the lowest vertex of B minus the
// highest vertex of A. The gap is at least the separation. Each vertex's place and rate along n are
// known now, and its acceleration has a bound D. So the separation after time h is at least the
// lower envelope of one line per vertex, minus D h^2 / 2. Pieces that are apart must touch before
// they collide, so the search skips to the time at which this bound reaches the touch distance. If
// n leads from one closest point to the other, the bound is tight to second order. A few looks
// (examinations of one tick) then find the collision's exact tick.
//
// Pieces that touch collide once their gap shrinks. The gap's rate is the lowest vertex's rate
// along the normal. So the axis must turn with the touching features. For each vertex, the search
// computes the earliest time at which it may be both lowest and falling.
//
// This search is the second of two stages (thesis 3.2.2). The first stage finds when the bounding
// spheres meet. The thesis's second stage uses a bound of only first order: the distance divided by
// the greatest speed.
//
// Invariants
//   1. If the pieces touch, a look's result depends only on their poses and motion. If the pieces
//      collide, the result is collision_rule.h's verdict and contact. Otherwise the result is the
//      time for which a collision is impossible. A search from scratch finds the same result.
//   2. If the pieces are apart, a look may start from results of the pair's earlier looks. Earlier
//      results decide which of several certified answers the look finds. The answers are equal up
//      to rounding. The choice affects only which ticks are skipped, never what collides or when.
//      So all searches find the same collision, whichever ticks they look at. Invariant 3 lists the
//      exceptions.
//   3. The bounds above are lowered by the rounding error of gaps at the pieces' distance from the
//      origin. A tick is skipped only if the lowered bounds exclude a collision. For touching
//      pieces the bounds hold while the normal turns with the same face, whichever vertices touch.
//      The bounds also hold while the normal turns with the same two edges, if the sine of the
//      edges' angle is at least 0.01. For pieces within k_touch_m of each other, the bounds don't
//      cover some turns of the normal: between two edges with a smaller angle; between two
//      vertices; between a vertex and an edge, if the normal turns about the edge. Normals of
//      spheres are covered. In the uncovered cases, a collision may be late by at most
//      comes_deeper_s() (piece_motion.h).
// Thread safety: pure functions, except for the cache passed in.
#pragma once

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/distance/closest_points.h"

namespace sleight::physics {

/// Does the cheap part of a look, without orientations. spheres_apart() returns true if the gap
/// between the bounding spheres exceeds a small share of `near_m`. sphere_above() returns true if
/// the sphere is above the plane by a small share of the radius. If the result is true, `examined`
/// is the look's result.
bool spheres_apart(const MovingPoint& a, const MovingPoint& b, double radii_m, double near_m,
                   Tick tick, Examined& examined);
bool sphere_above(const HalfSpace& solid_below, const MovingPoint& b, double radius_m, Tick tick,
                  Examined& examined);

/// Examines one tick. `cache` comes from the pair's earlier looks, or is new. `touch_m` replaces
/// k_touch_m. If the pieces collide, `contact` is contact_of()'s result.
Examined examine_pieces(const MovingPiece& a, const MovingPiece& b, Tick tick, double touch_m,
                        SeparationCache& cache, PieceContact& contact);
Examined examine_plane(const HalfSpace& solid_below, const MovingPiece& b, Tick tick,
                       double touch_m, PieceContact& contact);

/// Does the first stage for two bodies in free flight. Returns the time span until their bounding
/// spheres touch. At its start, `between_m` leads from the first centre to the second. The result
/// is never too late, even with rounding. No touch: k_tick_max.value.
TickCount touch_of_free_spheres(const Vec3& between_m, const Vec3& relative_mps, double radii_m);

}  // namespace sleight::physics
