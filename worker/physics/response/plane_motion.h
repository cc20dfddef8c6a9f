// How a rigid body that isn't a sphere moves on a fixed plane: it slides, turns about the plane's
// normal, rolls or stands.
//
// Idea. The body touches the plane at its supports, which are points that keep their height. Each
// support pushes along the plane's normal n with a load N >= 0. Friction mu N acts against the
// support's slip.
//
//   - A body lying on an area has a velocity along the plane and a spin about n. A support at a
//     place x in the plane has the load N = a + b.x. The loads are the least-squares ones, which
//     many equal springs would also have. In three directions the body can't move. The laws of
//     Newton and Euler for these directions determine a and b. If a support's load would be
//     negative, the support is lifted and carries nothing. If fewer than three supports remain, the
//     body topples. If nothing slips, the body stands as long as friction holds it.
//   - A body of revolution lying on a line rolls about it. If the plane is level but the body's
//     axis isn't (a cone, a lying pin), the body circles at w_n = -spin (axis.n). The supports
//     provide the centripetal force and the gyroscopic torque, so both loads must push and friction
//     must suffice. If the axis is parallel to the plane (a cylinder), the body moves across its
//     axis like a sphere (contact_motion.h), whose gyration is the body's gyration about the axis.
//
// While no slip turns, loads and accelerations are constant: the centre follows a parabola and the
// angular velocity changes linearly. If a body slides without turning, or only spins, its motion is
// one such piece. If slips turn, a piece lasts until they have turned by a 32nd of a radian, but at
// least 2^-11 s. The piece uses the directions and loads at its midpoint in time. A cone's circle
// is cut into pieces of a 32nd of a radian. On a circle, a piece's velocities are exact at both
// ends and interpolated in between.
//
// Invariants
//   1. Nothing gains energy from piece to piece. At the start, a projection in the metric of the
//      masses removes velocity that the plane doesn't allow. In each piece, friction takes energy.
//      In the middle of a circle's piece, the energy is lower than at its ends, by a share of up to
//      2.5e-4.
//   2. The supports keep their height: velocities and accelerations have no component along n, and
//      the spin is about n or the axis of revolution. For cones, this invariant holds to 1e-9 rad
//      per piece.
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <limits>
#include <span>

#include "worker/physics/event/tolerances.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/motion/segment.h"

namespace sleight::physics {

struct PlaneSupport {
  Vec3 arm_m = Vec3::Zero();  ///< from the body's centre
  double friction = 0;        ///< mu
};

struct BodyOnPlane {
  double mass_kg = 0;
  Mat3 inertia_kgm2 = Mat3::Zero();  ///< about the centre, in the world's frame
  Vec3 normal = Vec3::UnitZ();       ///< unit, from the plane to the body
  /// At most k_plane_supports_max.
  std::span<const PlaneSupport> supports;
  /// Axis of revolution through the centre: a unit vector in the world's frame. 0 unless the body
  /// is a body of revolution.
  Vec3 axis = Vec3::Zero();
  double rolling_friction = 0;
  double stick_mps = 0;  ///< > 0; a slip slower than this is over
};

struct PlaneMotion {
  /// Whether the plane carries the body. If the plane doesn't, no other field is set.
  bool carried = false;
  bool stands = false;   ///< the body is at rest, and nothing moves it
  bool brakes = false;   ///< friction brakes the sliding until the body stands or rolls
  bool on_line = false;  ///< the body lies on a line; `start` has no motion along it
  MotionMode mode = MotionMode::sliding;
  /// Twist at the start. Motion that the plane doesn't allow has been removed.
  Twist start{};
  Vec3 acceleration_mps2 = Vec3::Zero();
  Vec3 angular_acceleration_radps2 = Vec3::Zero();
  /// Time until the motion must be computed again.
  double lasts_s = std::numeric_limits<double>::infinity();
};

/// REQUIRES: everything finite; mass and moments > 0.
PlaneMotion plane_motion(const BodyOnPlane& body, const Twist& twist, const Vec3& gravity_mps2);

/// Returns the inertia about the centre in the world's frame.
Mat3 inertia_in_world(const Vec3& principal_kgm2, const Quat& orientation);

}  // namespace sleight::physics
