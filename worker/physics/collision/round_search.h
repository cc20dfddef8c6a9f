// When do two pieces in motion meet, one of which is round at least?
//
// Idea. As for polyhedra the gap is at least the separation along any fixed axis, and what lies
// along it is known now, with a bound of how it bends. A body that turns reaches along the axis n
// as far as it does now along n + h n x w, but for its points' acceleration; a support is convex,
// so on that straight line of directions it is convex in the time h, rings included. The separation
// therefore lies above a function of h that is concave: no collision before that comes down to the
// touch, and any chord of it lies below it. So the time is approached from the safe side, by
// chords.
//
//   separation(h) >= n.(place + h velocity + h^2/2 pull) - reach_a(h) - reach_b(h) - bend h^2/2
//
// Pieces that touch and don't collide are looked at again before any of their points can have come
// k_touching_depth_m nearer at the speed that it has now, and after k_touching_s_max at the latest.
// A bounce leaves the touch within some ticks, so that is rare; it bounds how late a pair that
// touches may be, where that of polyhedra has no bound.
//
// Invariants
//   1. A look at pieces that touch is a function of their poses and motion alone, and so is the
//   first
//      tick at which pieces that were apart touch. What is kept from earlier looks, an axis,
//      decides only which ticks before that are skipped. So all searches find the same collision.
//   2. Apart, no look is skipped at which the pieces touch. In touch, a collision is late by no
//   more
//      than what was said.
// Internal to worker/physics/collision: examine_pieces and examine_plane call it. Thread safety:
// pure functions.
#pragma once

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/collision/sphere_search.h"

namespace sleight::physics {

/// As examine_pieces. REQUIRES: a or b is round.
Examined examine_round(const MovingPiece& a, const MovingPiece& b, Tick tick, double touch_m,
                       SeparationCache& cache, PieceContact& contact);
/// As examine_plane. REQUIRES: b is round.
Examined examine_round_plane(const HalfSpace& solid_below, const MovingPiece& b, Tick tick,
                             double touch_m, PieceContact& contact);

}  // namespace sleight::physics
