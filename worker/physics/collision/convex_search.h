// When do two moving convex pieces meet?
//
// Idea. Along a fixed axis n, the separation of pieces A and B is the lowest vertex of B minus the
// highest vertex of A. The gap is never less than this separation. Each vertex's place and rate
// along n are known now, and its acceleration has a bound D. The separation therefore stays above
// the lower envelope of one line per vertex, minus D h^2 / 2 after time h. Pieces that are apart
// must touch before they collide, so the search skips to the time at which this bound reaches the
// touch distance. If n is the line of the closest points, the bound is tight to second order, and a
// few looks (examinations of one tick) find the collision's exact tick.
//
// Pieces that touch collide once their gap shrinks. The gap's rate is the rate of the lowest vertex
// along the normal. The axis must therefore turn with the touching features. For each vertex, the
// search computes the earliest time at which it may be both lowest and falling.
//
// This search is the second of two stages (thesis 3.2.2). The first stage finds when the bounding
// spheres meet. The thesis's second stage divides the distance by the greatest speed, which is only
// a first-order bound.
//
// A sphere is a piece with one vertex and a radius.
//
// Invariants
//   1. If the pieces touch, a look's result depends only on their poses and motion. The result is
//      collision_rule.h's verdict and contact or, without a collision, how long a collision is
//      impossible. A search from scratch finds the same result.
//   2. If the pieces are apart, a look may start from results of the pair's earlier looks. Earlier
//      results decide which of several certified answers the look finds; the answers are equal up
//      to rounding. The choice affects only which ticks are skipped, never what collides or when.
//      So all searches find the same collision, however they are divided into looks, except in the
//      cases that invariant 3 excludes.
//   3. A look is skipped only under the bounds above, lowered by the rounding error of gaps at the
//      pieces' distance from the origin. For touching pieces the bounds hold while the normal turns
//      with the same face, whichever vertices touch. The bounds also hold while the normal turns
//      with the same two edges, if the sine of the edges' angle is at least 0.01. For pieces within
//      k_touch_m of each other, the bounds don't cover some turns of the normal: between two edges
//      that are more nearly parallel, between two vertices, and, about the edge, between a vertex
//      and an edge. Normals of spheres are covered. In the uncovered cases a collision may be late,
//      by at most comes_deeper_s() (piece_motion.h).
// Thread safety: pure functions, except for the cache passed in.
#pragma once

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/distance/closest_points.h"

namespace sleight::physics {

/// Does the cheaper part of a look, which needs no orientation. Returns true if the bodies'
/// bounding spheres are apart by more than a small part of `near_m`, and stores the look's result
/// in `examined`. sphere_above() requires the sphere to be above the plane by a small part of the
/// sphere's radius. Usually other events happen before bounding spheres meet.
bool spheres_apart(const MovingPoint& a, const MovingPoint& b, double radii_m, double near_m,
                   Tick tick, Examined& examined);
bool sphere_above(const HalfSpace& solid_below, const MovingPoint& b, double radius_m, Tick tick,
                  Examined& examined);

/// Examines one tick. `cache`: from the pair's earlier looks, or new. `touch_m` replaces k_touch_m.
/// If the pieces collide, `contact` is contact_of()'s result.
Examined examine_pieces(const MovingPiece& a, const MovingPiece& b, Tick tick, double touch_m,
                        SeparationCache& cache, PieceContact& contact);
Examined examine_plane(const HalfSpace& solid_below, const MovingPiece& b, Tick tick,
                       double touch_m, PieceContact& contact);

/// The first stage for two bodies in free flight: returns the time span until their bounding
/// spheres touch. At the span's start the second centre is at `between_m` from the first. The
/// result is never too late, even with rounding. No touch: k_tick_max.value.
TickCount touch_of_free_spheres(const Vec3& between_m, const Vec3& relative_mps, double radii_m);

}  // namespace sleight::physics
