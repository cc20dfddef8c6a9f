// How a sphere moves over an edge that it stays on.
//
// Idea. The centre runs around the edge on a cylinder, and along it. There is no closed form for
// that (a pendulum's), so the way is cut into pieces on each of which it moves as it would on a
// face: the plane at right angles to the normal half way round the piece. Across that plane it
// follows a parabola that begins and ends on the cylinder and is outside of it in between:
//
//               . - ~ ~ - .               n, t: normal and tangent half way; h: half of the angle
//          .                   .          chord 2 D sin(h), D from the edge to the centre
//        P0 - - - - chord - - - P1        along t: v0 T + a T^2 / 2 = 2 D sin(h)
//           \        | n      /           along n: up with u at P0, down with u at P1
//             \ h    |      /             u = tan(h) max(v0, v1): at P0 no slower than the tangent
//               \    |    /                   there, at P1 no slower than the tangent's fall
//                 \  |  /
//                   edge
//
// a is what the motion on that plane has (contact_motion.h), with the load lowered by the turn:
// N = -g.n - v^2 / D. A sphere that rolls goes on rolling: its spin stays what it is while the
// normal turns, and the impulse of friction that follows takes no energy.
//
// Invariants
//   1. The centre is at least as far from the edge all along as at the start, and no more than
//      `rise_max_m` further; at the end as far. (Of the square of the distance as a polynomial of
//      degree four in time, both ends are roots, and what remains is concave and not negative at
//      both.)
//   2. Kinetic energy plus gravity's is the same at the start and the end, friction apart: the
//      chord lies in the plane, and velocities are turned, never lengthened. In between, the load
//      lifts the centre over the chord and lets it down again; the cylinder would do no work.
//      without_lift gives the twist that belongs to the place.
// Thread safety: pure functions.
#pragma once

#include <optional>

#include "worker/physics/response/contact_motion.h"

namespace sleight::physics {

struct EdgeLine {
  Vec3 direction = Vec3::Zero();  ///< unit
  double distance_m = 0;          ///< of the centre from the line
};

struct EdgePiece {
  /// At the start, its velocity outwards included.
  Twist start{};
  Vec3 acceleration_mps2 = Vec3::Zero();
  Vec3 angular_acceleration_radps2 = Vec3::Zero();
  Vec3 half_way = Vec3::Zero();  ///< unit normal there
  bool rolls = false;
  double lasts_s = 0;  ///< then the centre is as far from the edge as at the start
};

/// The next piece of a sphere's way over an edge, as long as it rises by no more than so much.
/// Nothing if there is none: it stands or is about to turn on too steep a side, its surface begins
/// or ends to slip at once, or it is so fast that it flies off.
/// `contact`: at the start. `rolled`: it has rolled on this edge up to now.
/// REQUIRES: everything finite; radius, gyration, rise > 0; the sphere doesn't approach the edge by
/// more than the end of a piece does.
std::optional<EdgePiece> edge_piece(const RoundBody& body, const LastingContact& contact,
                                    const EdgeLine& edge, const Twist& twist, bool rolled,
                                    const Vec3& gravity_mps2, double rise_max_m);

/// A piece that is under way.
struct EdgeFlight {
  Twist start{};
  Vec3 acceleration_mps2 = Vec3::Zero();
  Vec3 half_way = Vec3::Zero();
};

/// The twist of a piece at a place, slowed down by the work that the load has done since the start,
/// and never with more energy than there was. `moved_m`: from the start to there.
Twist without_lift(const RoundBody& body, const EdgeFlight& flight, const Vec3& gravity_mps2,
                   const Vec3& moved_m, const Twist& twist);

}  // namespace sleight::physics
