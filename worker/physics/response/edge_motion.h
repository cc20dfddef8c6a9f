// How a sphere moves over an edge that it stays on.
//
// Idea. The centre runs around the edge, on a cylinder, and along the edge. This motion, like a
// pendulum's, has no closed form. So the way is cut into pieces. On each piece the sphere moves as
// on a face perpendicular to the normal half way through the piece. In the plane across the edge,
// the centre follows a parabola that begins and ends on the cylinder and is outside it in between:
//               . - ~ ~ - .               n, t: normal and tangent half way; h: half of the angle
//          .                   .          chord 2 D sin(h), D from the edge to the centre
//        P0 - - - - chord - - - P1        along t: v0 T + a T^2 / 2 = 2 D sin(h)
//           \        | n      /           along n: up with u at P0, down with u at P1
//             \ h    |      /             u = tan(h) max(v0, v1): at P0 no slower than the tangent
//               \    |    /                   there, at P1 no slower than the tangent's fall
//                 \  |  /
//                   edge
//
// The acceleration a is that of the motion on this plane (contact_motion.h), with the load reduced
// by the turn: N = -g.n - v^2 / D. A rolling sphere keeps rolling. The sphere's spin stays constant
// while the normal turns, and the impulse of friction that follows takes no energy.
//
// Invariants
//   1. The centre is never nearer to the edge than at the start, and at most `rise_max_m` further
//      away. At the end, the centre is as far from the edge as at the start. (The square of the
//      distance, minus its value at the start, is a polynomial of degree four in time with roots at
//      both ends. The remaining factor is concave and not negative at both ends.)
//   2. Kinetic plus potential energy is the same at the start and the end, except for friction: the
//      chord is in the plane, and velocities are turned, never lengthened. In between, the load
//      lifts the centre over the chord and lowers it again, while a cylinder would do no work.
//      without_lift() returns the twist without this work.
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
  /// Twist at the start, including the outward velocity.
  Twist start{};
  Vec3 acceleration_mps2 = Vec3::Zero();
  Vec3 angular_acceleration_radps2 = Vec3::Zero();
  Vec3 half_way = Vec3::Zero();  ///< unit normal there
  bool rolls = false;
  double lasts_s = 0;  ///< at the end, the centre is as far from the edge as at the start
};

/// Returns the next piece of a sphere's way over an edge, with a rise of at most `rise_max_m`.
/// Returns nothing if the sphere stands, is about to turn back on too steep a side, starts or stops
/// slipping at once, or is so fast that it flies off. `contact`: at the start. `rolled`: the sphere
/// has rolled on this edge up to now. REQUIRES: everything finite; radius, gyration, rise > 0; the
/// sphere approaches the edge no faster than at the end of a piece.
std::optional<EdgePiece> edge_piece(const RoundBody& body, const LastingContact& contact,
                                    const EdgeLine& edge, const Twist& twist, bool rolled,
                                    const Vec3& gravity_mps2, double rise_max_m);

/// A piece in progress.
struct EdgeFlight {
  Twist start{};
  Vec3 acceleration_mps2 = Vec3::Zero();
  Vec3 half_way = Vec3::Zero();
};

/// Returns a piece's twist at a place, without the load's work since the start, and never with more
/// energy than at the start. `moved_m`: vector from the start to the place.
Twist without_lift(const RoundBody& body, const EdgeFlight& flight, const Vec3& gravity_mps2,
                   const Vec3& moved_m, const Twist& twist);

}  // namespace sleight::physics
