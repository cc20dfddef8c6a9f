// How a rigid body that is no sphere moves while it stays on a plane that doesn't move: it slides,
// turns about the plane's normal, rolls, or stands.
//
// Idea. It touches the plane at some supports, points of it that keep their height. Each pushes
// along the plane's normal n with a load N >= 0, and against its slip with mu N.
//
//   It lies on an area. Its motion is a velocity along the plane and a spin about n. The supports'
//   loads are N = a + b.x, linear in their places x in the plane: the loads of least squares, and
//   what many springs of one kind would give. Newton's and Euler's laws for the three directions
//   in which the body doesn't move say what a and b are. Where such a load would pull, its support
//   is lifted and takes no part; if too few are left, nothing carries the body: it topples. If
//   nothing slips, it stands as long as friction holds it.
//   A body of revolution lies on a line. It rolls about it. If all of that is level and its axis is
//   not (a cone, a lying pin), it goes round in a circle at w_n = -spin (axis.n), and centripetal
//   force and gyroscopic torque come from the supports: both loads must push, and friction
//   suffice. If its axis is along the plane (a cylinder), it moves as a sphere does across its axis
//   (contact_motion.h), with the gyration about that.
//
// As long as no slip turns, loads and accelerations are constants, the centre runs along a parabola
// and the angular velocity changes evenly; a body that slides without turning has one such piece,
// and so has one that only spins. Where slips turn, a piece lasts while they turn by a 32nd of a
// radian, or 2^-11 s if that is longer, with the directions and loads that a step to half its time
// gives. A piece of a circle is a 32nd of a radian: its velocities are right at both ends and are
// interpolated between them.
//
// Invariants
//   1. Nothing gains energy from piece to piece: what is taken out at the start is a projection in
//      the metric of the masses, and friction takes energy in each piece. Within a piece of a
//      circle energy is lower by up to 2.5e-4 of itself, in the middle.
//   2. The supports keep their height: velocities and accelerations have no part along n, and spin
//      is about n or about the axis of revolution; of cones to 1e-9 rad in a piece.
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

/// A body in the pose in which it lies.
struct BodyOnPlane {
  double mass_kg = 0;
  Mat3 inertia_kgm2 = Mat3::Zero();  ///< about the centre, in the world's frame
  Vec3 normal = Vec3::UnitZ();       ///< unit, from the plane to the body
  /// At most k_plane_supports_max.
  std::span<const PlaneSupport> supports;
  /// Unit, in the world's frame, through the centre; of a body of revolution. Else 0.
  Vec3 axis = Vec3::Zero();
  double rolling_friction = 0;
  double stick_mps = 0;  ///< > 0; a slip slower than this is over
};

struct PlaneMotion {
  /// Whether the plane carries it; if not, nothing else here is set.
  bool carried = false;
  bool stands = false;   ///< it doesn't move, and nothing moves it
  bool brakes = false;   ///< friction brakes its sliding: it is going to stand, or to roll
  bool on_line = false;  ///< it lies on a line: `start` is without what it does along that
  MotionMode mode = MotionMode::sliding;
  /// At the start, without what the plane doesn't allow.
  Twist start{};
  Vec3 acceleration_mps2 = Vec3::Zero();
  Vec3 angular_acceleration_radps2 = Vec3::Zero();
  /// Then the motion is to be asked for again.
  double lasts_s = std::numeric_limits<double>::infinity();
};

/// REQUIRES: everything finite; mass and moments > 0.
PlaneMotion plane_motion(const BodyOnPlane& body, const Twist& twist, const Vec3& gravity_mps2);

/// The inertia about the centre in the world's frame.
Mat3 inertia_in_world(const Vec3& principal_kgm2, const Quat& orientation);

}  // namespace sleight::physics
