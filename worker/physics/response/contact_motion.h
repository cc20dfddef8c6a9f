// How a sphere moves while it stays in contact with one, two or three faces that don't move.
//
// Idea. Bounces that get ever lower are one long contact, in which a constant pull presses the
// sphere on the faces. Its centre then moves along a plane, or along the line on which it touches
// two; what remains of gravity, Coulomb's friction and rolling resistance accelerate it. At each
// contact the surface slips, and friction is mu times the load against the slip, or it sticks, and
// friction is what keeps it so, at most mu times the load. As long as no direction of slip turns
// and no contact begins or ends to slip, loads and accelerations are constants: the centre runs
// along a parabola and the spin changes evenly.
//
//   one face     slides: slip' = g_t - mu N (1 + 1/k) slip/|slip|;  rolls: v' = g_t / (1 + k)
//   two faces    the same along the valley, with the loads from a linear system, since friction
//                across the valley at one face presses on the other
//   three faces  a corner: the centre stays, and friction brakes the spin about the axis that it
//                has, by the power that it takes
//
// with k = I / (m r^2) (2/5 of a solid ball), g_t the part of gravity along the face and N the
// load over the mass. (For one face, F. Reif's or any text on mechanics; 5/7 and 2/7 of a ball that
// is thrown without spin follow.) Rolling resistance decelerates a sphere that rolls on one face by
// c N, in general by the power that this takes; it also brakes spin about the normal of one face,
// by the moment c N r.
//
// Where a slip turns, as that of a ball thrown across a slope, its direction is held at what it
// will be half way, for as long as it turns by a 32nd of a radian (up to half a radian where that
// does little: held_slip.h); then the motion is asked for anew.
//
// Invariants
//   1. Nothing gains energy: friction and resistance never act along the motion that they brake,
//      and what is taken out at the start is a projection in the metric of the masses.
//   2. Velocity and acceleration have no part along a normal, to rounding.
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

#include "worker/physics/event/tolerances.h"
#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

/// A face that a sphere stays on.
struct LastingContact {
  Vec3 normal = Vec3::Zero();   ///< unit, from the face to the centre
  double friction = 0;          ///< mu
  double rolling_friction = 0;  ///< c
};

struct RoundBody {
  double radius_m = 0;
  double gyration = 0.4;  ///< k = I / (m r^2)
  /// A slip slower than this is over: a slip that something pulls on from the side turns ever
  /// faster as it dies, and would be asked for some thirty times.
  double stick_mps = k_stick_mps;

  /// By how much a slip whose direction is held for a while may come out wrong.
  double slip_error_mps() const { return std::max(k_slip_error_mps, 0.125 * stick_mps); }
};

struct ContactMotion {
  /// Bit i: contact i carries a load. If one doesn't, the sphere doesn't stay on all of them, and
  /// nothing else here is set.
  std::uint32_t pressed = 0;
  /// At the start, without velocity into the faces and without slip that is as good as over.
  Twist start{};
  Vec3 acceleration_mps2 = Vec3::Zero();
  Vec3 angular_acceleration_radps2 = Vec3::Zero();
  bool rolls = false;  ///< no contact slips
  /// Then the accelerations change, and the motion is to be asked for again.
  double lasts_s = std::numeric_limits<double>::infinity();
};

/// Whether a sphere can stay on both.
bool is_valley(const Vec3& normal_a, const Vec3& normal_b);

/// Where a sphere meets an edge or a vertex it pivots, for which there is no closed form; it hops
/// instead. If it would separate more slowly than `speed_mps`, it does so with that, paid from what
/// moves it along and turns it, at most half of that; both slow down by the same share, so what
/// rolled rolls. Keeps the kinetic energy.
/// REQUIRES: the sphere doesn't approach along the unit `normal`.
Twist hop(const RoundBody& body, const Vec3& normal, const Twist& twist, double speed_mps);

/// Stops the slip at a contact by the impulse of friction that it takes.
void stop_slip(const RoundBody& body, const Vec3& normal, Twist& twist);

/// A velocity without what leads into faces or away from them: along one, along the line of a
/// valley, none in a corner.
/// REQUIRES: one contact, two that are a valley, or three.
Vec3 along_faces(std::span<const LastingContact> contacts, const Vec3& velocity_mps);

/// REQUIRES: the same; everything finite; radius and gyration > 0.
ContactMotion contact_motion(const RoundBody& body, std::span<const LastingContact> contacts,
                             const Twist& twist, const Vec3& gravity_mps2);

}  // namespace sleight::physics
