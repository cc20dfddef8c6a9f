// Impact of two rigid bodies at a point, with friction, that gains no energy for any inertia.
//
// Idea. The law is that of restitution.h: against the slip, else Chatterjee and Ruina's. It is
// computed in whitened coordinates: a body's velocity times the root of its mass, and its angular
// velocity, in the body's own frame, times the roots of its principal moments. In these coordinates
// y (six for each moving body) the kinetic energy is |y|^2 / 2, an impulse adds G P with a column
// of G for the normal and two for tangents, and K = G^T G. The QR decomposition G = E R makes the
// law a statement about an orthonormal frame e_1, e_2, e_3 (symbols as in restitution.h):
//   y' = y - (1 + w/u) (e_1.y) e_1 - kappa ((e_2.y) e_2 + (e_3.y) e_3),
// that is: reflect and shrink the part along e_1, shrink the parts along e_2 and e_3. No inverse of
// the ill-conditioned K is formed.
//
// Why this law and not Stronge's (W. J. Stronge, "Rigid body collisions with friction", Proceedings
// of the Royal Society A 431, 1990), which integrates the sliding velocity along the normal
// impulse: neither gains energy, but this one is a closed form whose proof carries over to the
// rounded result, at 0.17 us. A throwaway Runge-Kutta integration of Stronge's with 64 steps of
// compression took 6 us for box corners (e = 0.5, mu = 0.4), and differed from one with 20,000 by
// 6e-3 m/s in the mean at speeds of 1 m/s. The price: friction acts along
// one direction, that of Q, so the turn of the slip during the impact is not resolved; and where
// normal and tangential motion are coupled (K_nt != 0) a sticking impact with e > 0 leaves with
// some slip.
//
// Invariants (e in [0, 1], mu >= 0, any positive moments, any contact point)
//   1. Kinetic energy after <= before but for rounding. By construction: after rounding the new
//      twists, their energy is evaluated in whitened coordinates, and as long as it exceeds the old
//      by more than the rounding of the twists themselves explains (2^-50 of the energy and of
//      |angular velocity| |angular momentum|; that is 5e-14 of the energy where moments differ by
//      1e4), the impulse P is scaled by a factor below 1. A scaled P is in the same cone, and loses
//      energy: dE(s) = s V.P + s^2/2 P.K P with dE(1) <= 0 gives dE(s) <= -(s - s^2) P.K P / 2.
//      After the last of the fixed rounds P is 0 and the impact `unresolved`.
//      In 1e6 random cases with contacts from 10 to 1e9 radii of gyration away no impact was
//      unresolved, one in 2700 was scaled, and by less than 1e-13; an adversary who puts far
//      centres in line with the normal gets a gain above 1e-12 without the scaling.
//   2. The bodies do not approach afterwards, but for rounding: the separation speed is w.
//   3. |friction impulse| <= mu times the normal impulse >= 0.
//   4. Linear and angular momentum are kept to rounding: one P acts on both.
//   5. mu = 0 is Newton's law; with e = 1 energy is kept to rounding. For spheres it agrees with
//      sphere_impact.h.
//   6. The result does not depend on which body is A nor on the frame, but for rounding.
// Thread safety: pure functions.
#pragma once

#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/response/restitution.h"

namespace sleight::physics {

/// A body's inertia as impacts need it. The default value is static geometry.
struct RigidMass {
  double inverse_mass_per_kg = 0;
  double root_mass = 0;                      ///< in kg^(1/2)
  double inverse_root_mass = 0;              ///< in kg^(-1/2)
  Vec3 root_moments = Vec3::Zero();          ///< of the principal moments, in kg^(1/2) m
  Vec3 inverse_root_moments = Vec3::Zero();  ///< in kg^(-1/2) m^-1
};

/// REQUIRES: mass and moments > 0, within 1e-100..1e100.
RigidMass rigid_mass(const Inertia& inertia);

struct RigidImpactBody {
  RigidMass mass{};
  Pose pose{};    ///< of a static body: ignored; the orientation has norm 1 to within 1e-12
  Twist twist{};  ///< of a static body: 0, and passed through
};

struct RigidImpactInput {
  RigidImpactBody a{};
  RigidImpactBody b{};
  Vec3 contact_m = Vec3::Zero();  ///< in the world's frame
  Vec3 normal = Vec3::UnitZ();    ///< from A to B; length 1 to within 1e-12
  ContactLaw law{};
};

/// No allocation; about 170 ns for two bodies and 150 ns against a static one.
/// REQUIRES: one of the two is not static; squares of all magnitudes neither over- nor underflow.
ImpactOutput rigid_impact(const RigidImpactInput& input);

/// What leaves static geometry at a contact, at least with a speed: paid from all its other motion,
/// of at most half of that's energy; all of that slows down by the same share, so what rolled
/// rolls. Keeps the kinetic energy but for rounding. `normal` points to the body, whose twist is
/// that after the impact. REQUIRES: it isn't static, and doesn't approach.
Twist rigid_hop(const RigidImpactBody& body, const Vec3& contact_m, const Vec3& normal,
                double speed_mps);

/// Without the scaling of invariant 1. For the test that shows the scaling to be needed.
ImpactOutput rigid_impact_unguarded(const RigidImpactInput& input);

}  // namespace sleight::physics
