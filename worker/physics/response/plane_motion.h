// How a rigid body other than a sphere moves on a plane that doesn't move: it slides, turns about
// the plane's normal, rolls or stands.
//
// Idea. The body touches the plane at its supports, which are points that keep their height. Each
// support pushes along the plane's normal n with a load N >= 0, and against its slip with mu N.
//
//   - A body lying on an area has a velocity along the plane and a spin about n. The supports'
//     loads are N = a + b.x, linear in their places x in the plane. These are the least-squares
//     loads, the same as those of many equal springs. Newton's and Euler's laws, for the three
//     directions in which the body can't move, determine a and b. A support whose load would pull
//     is lifted and takes no part. If too few supports remain, nothing carries the body and it
//     topples. If nothing slips, the body stands as long as friction holds it.
//   - A body of revolution lying on a line rolls about it. On a level plane with an axis that isn't
//     level (a cone, a lying pin), the body circles at w_n = -spin (axis.n). The supports provide
//     the centripetal force and the gyroscopic torque, so both loads must push and friction must
//     suffice. If the axis is parallel to the plane (a cylinder), the body moves like a sphere
//     across its axis (contact_motion.h), with the gyration about the axis.
//
// While no slip turns, loads and accelerations are constant, the centre follows a parabola and the
// angular velocity changes linearly. A body that slides without turning, or only spins, has one
// such piece. If slips turn, a piece lasts while they turn by a 32nd of a radian, or for 2^-11 s if
// that is longer. The piece uses the directions and loads at its midpoint in time. A piece of a
// cone's circle covers a 32nd of a radian; its velocities are exact at both ends and interpolated
// in between.
//
// Invariants
//   1. Nothing gains energy from piece to piece. At the start, velocity that the plane doesn't
//      allow is removed by a projection in the metric of the masses. In each piece, friction takes
//      energy. In the middle of a piece of a circle, the energy is lower by up to 2.5e-4 of itself.
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

/// A body that lies on a plane.
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
  /// Twist at the start, without motion that the plane doesn't allow.
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
