// How a sphere moves while it stays in contact with one, two or three faces that don't move.
//
// Idea. A series of ever lower bounces becomes one lasting contact, during which a constant pull
// presses the sphere onto the faces. The centre moves along a plane, or along a line if the sphere
// touches two faces. Gravity along the faces, Coulomb friction and rolling resistance accelerate
// the sphere. At a contact the sphere's surface either slips or sticks. If the surface slips,
// friction of mu times the load brakes it. If the surface sticks, friction of at most mu times the
// load holds it. Loads and accelerations are constant while no slip changes direction and no
// contact starts or stops slipping. The centre then follows a parabola and the spin changes
// linearly.
//
//   - One face: slip' = g_t - mu N (1 + 1/k) slip/|slip| if the sphere slides, and
//     v' = g_t / (1 + k) if it rolls.
//   - Two faces: The same holds along the valley. A linear system gives the loads, because friction
//     across the valley at one face presses on the other face.
//   - Three faces: The centre stays at rest. Friction takes power from the spin, whose axis doesn't
//     change.
//
// Here k = I / (m r^2) (2/5 for a solid ball), g_t is the part of gravity along the face, and N is
// the load per mass. (Any text on mechanics derives this for one face, and the fractions 5/7 and
// 2/7 for a ball thrown without spin.) Rolling resistance decelerates a sphere rolling on one face
// by c N. On two faces, the deceleration follows from the power that this resistance takes. Rolling
// resistance also brakes spin about the normal of one face, by the moment c N r.
//
// The slip of a ball thrown across a slope turns. A motion with turning slip is computed in pieces.
// In each piece the slip turns by a 32nd of a radian, or by up to half a radian if the error is
// small (held_slip.h). Throughout a piece, friction acts against one direction: that of the slip
// half way through the piece.
//
// Invariants
//   1. Nothing gains energy: friction and resistance act against the motion that they brake. If
//      velocity must be removed at the start, a projection in the metric of the masses does so.
//   2. Velocity and acceleration have no component along a normal, up to rounding.
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

#include "worker/physics/event/tolerances.h"
#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

struct LastingContact {
  Vec3 normal = Vec3::Zero();   ///< unit, from the face to the centre
  double friction = 0;          ///< mu
  double rolling_friction = 0;  ///< c
};

struct RoundBody {
  double radius_m = 0;
  double gyration = 0.4;  ///< k = I / (m r^2)
  /// A slip slower than this speed counts as ended. Without this limit, a sideways pull would turn
  /// an ending slip ever faster, and the motion would need some thirty pieces.
  double stick_mps = k_stick_mps;

  /// Permitted error of a slip, caused by the constant direction of friction.
  double slip_error_mps() const { return std::max(k_slip_error_mps, 0.125 * stick_mps); }
};

struct ContactMotion {
  /// Bit i: contact i carries a load. If the bit of any contact is 0, the sphere doesn't stay on
  /// all contacts, and no other field is set.
  std::uint32_t pressed = 0;
  /// Twist at the start. Velocity into the faces and slip below `stick_mps` have been removed.
  Twist start{};
  Vec3 acceleration_mps2 = Vec3::Zero();
  Vec3 angular_acceleration_radps2 = Vec3::Zero();
  bool rolls = false;
  /// The accelerations are valid for this time; then the motion must be computed again.
  double lasts_s = std::numeric_limits<double>::infinity();
};

/// Returns whether a sphere can stay on both faces.
bool is_valley(const Vec3& normal_a, const Vec3& normal_b);

/// Makes a sphere hop off an edge or a vertex, because pivoting about it has no closed form. If the
/// sphere separates more slowly than `speed_mps`, raises that speed to `speed_mps`, but uses at
/// most half of the energy of the sphere's other motion. All other motion slows down in proportion,
/// so a rolling sphere keeps rolling. Conserves kinetic energy. REQUIRES: the sphere doesn't
/// approach along the unit `normal`.
Twist hop(const RoundBody& body, const Vec3& normal, const Twist& twist, double speed_mps);

/// Stops the slip at a contact by an impulse of friction.
void stop_slip(const RoundBody& body, const Vec3& normal, Twist& twist);

/// Removes the velocity's components into and away from faces. Returns the rest: along one face,
/// along a valley's line, or 0 in a corner. REQUIRES: one contact, two that form a valley, or
/// three.
Vec3 along_faces(std::span<const LastingContact> contacts, const Vec3& velocity_mps);

/// REQUIRES: contacts as in along_faces; everything finite; radius and gyration > 0.
ContactMotion contact_motion(const RoundBody& body, std::span<const LastingContact> contacts,
                             const Twist& twist, const Vec3& gravity_mps2);

}  // namespace sleight::physics
