// When do two convex pieces in motion meet?
//
// Idea. Along a fixed axis n the separation of two pieces is the lowest vertex of B less the
// highest of A, and the gap is never less than that. Each vertex's place along n is known now, so
// is its rate, and its acceleration has a bound; so the separation lies above the lower envelope of
// one line for each vertex, less D h^2 / 2. Pieces apart have to touch first, so of them it is only
// asked when the bound does. With n the line of closest points the bound is tight to second order,
// so a handful of looks finds the collision to the tick.
//
// Pieces that touch collide when the gap falls, as fast as the lowest vertex does along the normal:
// so the axis must turn with the features that touch, and of each vertex it is asked from when on
// it may be the lowest one and fall.
//
// This is the second of two stages (thesis 3.2.2); the first is when the bounding spheres meet.
// What the thesis takes for the second, the distance over the greatest speed of any point, is first
// order.
//
// A sphere is a piece of one vertex with a radius.
//
// Invariants
//   1. At a look within the touch all is a function of the two pieces' poses and motion alone: the
//      verdict and the contact, which are collision_rule.h's, and, if they don't collide, how long
//      they can't. It is what a search from scratch finds, by whatever means.
//   2. Elsewhere a look may start from what was found before, by this search or by earlier ones of
//      the pair. That decides which of several certified answers it finds, equal but for rounding,
//      and so, by the bound above, only which ticks are skipped: never what collides, or when.
//      Hence all searches, however they are divided, find the same collision, except in the cases
//      that 3 leaves open.
//   3. A look is skipped only under the bounds above, lowered by what rounding does to gaps so far
//      from the origin. Of pieces that touch that holds as long as the normal turns with the same
//      face, whichever vertices touch, or the same two edges, if these cross at a sine of 0.01 or
//      more. It doesn't cover what turns the normal of edges that are more nearly parallel, of two
//      vertices, or of a vertex and an edge, about the edge, while they are within k_touch_m of
//      each other; spheres' normals it covers. There a collision may be late, by no more than
//      comes_deeper_s (piece_motion.h).
// Thread safety: pure functions, but for the cache that they are given.
#pragma once

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/distance/closest_points.h"

namespace sleight::physics {

/// The cheaper part of a look, which asks for no orientation: while the spheres that hold two
/// bodies are apart by more than a small part of `near_m`, or the one above a plane, nothing else
/// need be asked. Mostly, other things happen before. Whether they are; `examined` then is the
/// look's result.
bool spheres_apart(const MovingPoint& a, const MovingPoint& b, double radii_m, double near_m,
                   Tick tick, Examined& examined);
bool sphere_above(const HalfSpace& solid_below, const MovingPoint& b, double radius_m, Tick tick,
                  Examined& examined);

/// One look. The cache is that of the pair's earlier looks, or a fresh one; `touch_m` stands for
/// k_touch_m. If they collide, `contact` is contact_of's result.
Examined examine_pieces(const MovingPiece& a, const MovingPiece& b, Tick tick, double touch_m,
                        SeparationCache& cache, PieceContact& contact);
Examined examine_plane(const HalfSpace& solid_below, const MovingPiece& b, Tick tick,
                       double touch_m, PieceContact& contact);

/// The first stage for two bodies that fall alike: when the spheres that hold them come to touch,
/// as a span from the moment at which the second centre is at `between_m` from the first. Not
/// later, rounding included; k_tick_max.value if never.
TickCount touch_of_free_spheres(const Vec3& between_m, const Vec3& relative_mps, double radii_m);

}  // namespace sleight::physics
