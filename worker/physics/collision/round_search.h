// When do two moving pieces meet, if at least one of them is round?
//
// Idea. As for polyhedra, the gap is at least the separation along any fixed axis. The pieces'
// extents along the axis are known now, and their second derivatives in time have a bound. Let a
// body turn with angular velocity w. If its points' acceleration is ignored, the body's reach along
// the axis n after time h equals its present reach along n + h n x w. A support function is convex,
// and these directions lie on a straight line, so the reach is convex in h (for rings too). The
// separation is therefore at least a concave function of h:
//
//   separation(h) >= n.(place + h velocity + h^2/2 pull) - reach_a(h) - reach_b(h) - bend h^2/2.
//
// No collision is possible before this function falls to the touch distance. Each chord is below
// this concave function, so a search with chords never skips too far.
//
// If pieces touch without colliding, they are examined again after at most k_touching_s_max. The
// next look also comes before any point, at its present speed, can come k_touching_depth_m nearer.
// A bounce separates touching pieces within a few ticks, so such looks are rare. Both limits bound
// how late a touching pair's collision can be. For polyhedra, k_touching_s_max doesn't apply.
//
// Invariants
//   1. If pieces touch, a look's result depends only on their poses and motion. Poses and motion
//      also determine the first tick at which separate pieces touch. The axis stored by earlier
//      looks decides only which ticks are skipped, so all searches find the same collision.
//   2. While pieces are apart, no tick at which they touch is skipped. While pieces touch, a
//      collision is late by at most the limits above.
// Internal to worker/physics/collision: examine_pieces and examine_plane call this search. Thread
// safety: pure functions.
#pragma once

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/collision/sphere_search.h"

namespace sleight::physics {

/// Like examine_pieces. REQUIRES: a or b is round.
Examined examine_round(const MovingPiece& a, const MovingPiece& b, Tick tick, double touch_m,
                       SeparationCache& cache, PieceContact& contact);
/// Like examine_plane. REQUIRES: b is round.
Examined examine_round_plane(const HalfSpace& solid_below, const MovingPiece& b, Tick tick,
                             double touch_m, PieceContact& contact);

}  // namespace sleight::physics
