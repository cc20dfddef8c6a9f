// How a sphere moves over an edge that it stays on.
//
// Idea. The centre moves on a cylinder: around the edge, and along it. Like a pendulum's motion,
// this motion has no closed form. So the path is cut into pieces. On each piece the sphere moves as
// on a plane face. The face's normal is the contact's normal half way through the piece. In the
// plane across the edge, the centre follows a parabola. The parabola begins and ends on the
// cylinder and is outside it in between:
//               . - ~ ~ - .               n, t: normal and tangent half way; h: half of the angle
//          .                   .          chord 2 D sin(h), D from the edge to the centre
//        P0 - - - - chord - - - P1        along t: v0 T + a T^2 / 2 = 2 D sin(h)
//           \        | n      /           along n: up with u at P0, down with u at P1
//             \ h    |      /             u = tan(h) max(v0, v1): at P0 no slower than the tangent
//               \    |    /                   there, at P1 no slower than the tangent's fall
//                 \  |  /
//                   edge
//
// The acceleration a is computed for this plane face (contact_motion.h), but the turn reduces the
// load: N = -g.n - v^2 / D. A rolling sphere keeps rolling. While the normal turns, the spin stays
// constant. Then an impulse of friction adjusts the spin without taking energy.
//
// Invariants
//   1. The centre is never nearer to the edge than at the start, and at most `rise_max_m` further
//      away. At the end, the centre is as far from the edge as at the start. (Proof: the square of
//      the distance, minus its value at the start, is a polynomial of degree four in time, and has
//      roots at both ends. The remaining factor is concave and not negative at both ends.)
//   2. Without friction, kinetic plus potential energy is the same at the start and the end: the
//      chord is in the plane, and velocities are turned, never lengthened. In between, the load
//      does work, which a cylinder would not do: it lifts the centre over the chord and lowers it
//      again. The function without_lift() removes this work from the twist.
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

/// Returns the next piece of a sphere's path over an edge. The rise is at most `rise_max_m`.
/// Returns nothing if the sphere stands, starts or stops slipping at once, is so fast that it flies
/// off, or is about to turn back where the side is too steep. `contact`: at the start. `rolled`:
/// the sphere has rolled on this edge up to now. REQUIRES: everything finite; radius, gyration,
/// rise > 0; the sphere approaches the edge no faster than it does at the end of a piece.
std::optional<EdgePiece> edge_piece(const RoundBody& body, const LastingContact& contact,
                                    const EdgeLine& edge, const Twist& twist, bool rolled,
                                    const Vec3& gravity_mps2, double rise_max_m);

/// A piece in progress.
struct EdgeFlight {
  Twist start{};
  Vec3 acceleration_mps2 = Vec3::Zero();
  Vec3 half_way = Vec3::Zero();
};

/// Corrects the twist at a place on a piece: removes the work that the load has done since the
/// start. The result never has more energy than at the start. `moved_m`: vector from the start to
/// the place.
Twist without_lift(const RoundBody& body, const EdgeFlight& flight, const Vec3& gravity_mps2,
                   const Vec3& moved_m, const Twist& twist);

}  // namespace sleight::physics
