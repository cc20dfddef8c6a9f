// The law of a single impact: normal impulse, friction and slow impacts.
//
// Idea. Bodies A and B touch. Let n be the unit normal from A to B, V the velocity of B's contact
// point relative to A's, and P the impulse on B (-P on A). The velocity afterwards is V + K P,
// where K is the positive definite inverse inertia at the contact. Two impulses span all others:
//   - P_I, the impulse along n that just stops the approach. P_I has the size u / K_nn, where u =
//     -V.n is the approach speed;
//   - P_II = -K^-1 V, the impulse that stops all motion at the contact.
// Let Q = P_II - P_I, and let w be the separation speed. Then the law of Chatterjee and Ruina ("A
// new algebraic rigid-body collision law based on impulse space considerations", Journal of Applied
// Mechanics 65, 1998; here with tangential restitution 0) is
//
//   P = (1 + w/u) P_I + kappa Q.
//
// If kappa = 1 puts P inside the friction cone, kappa is 1 (sticking). Otherwise kappa is the value
// in [0, 1) that puts P on the cone's surface (sliding).
//
// At a corner, the directions of Q and the slip may differ much: by 31 degrees for a cube that
// slides flat. The law above would make this cube's friction 15% too small. So if the slip doesn't
// reverse during the impact, Coulomb's law is applied directly. Let s > 0 be the slip speed before
// the impact, d its direction, and g = d.K (n - mu d). The impulse is
//
//   P = N (n - mu d),   N = (u + w) / k,   k = n.K (n - mu d) > 0,
//
// if s' = d.(V + K P) = s + N g >= 0. Otherwise the law above applies.
//
// Invariants
//   1. The separation speed is exactly w for any friction, because n.K Q = 0, and N is chosen for
//      w.
//   2. P_I and Q are orthogonal under K. The kinetic energy therefore changes by
//        (w^2 - u^2) / (2 K_nn) - (kappa - kappa^2/2) b,   b = Q.K Q >= 0.
//      If w <= u, the energy doesn't grow, because the second term is a loss for kappa in [0, 2].
//      The proof holds for every positive definite K, so for every inertia and every contact point.
//      If friction acts against the slip, the energy changes by N ((w - u) - mu (s + s')) / 2,
//      because the contact velocity is linear in the impulse. So if friction takes power at the
//      start and at the end of the impact, it takes power throughout.
//   3. |friction impulse| <= mu times the normal impulse, which is >= 0: P(kappa = 0) is in the
//      convex cone, and kappa grows from 0 towards 1 only as far as the cone allows.
//   4. Slow impacts: w = e u for a coefficient e. If w is below the floor v_c, w is raised to v_c.
//      If the energy doesn't suffice for v_c, w is chosen so that the energy change above is 0.
//      (The kappa or s' in it depends on w.) So a body that slides in a groove keeps bouncing at
//      about v_c and takes the energy from its sliding. The number of events in a time span stays
//      bounded. A body nearly at rest lacks this energy; other code decides whether it rests.
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

struct ContactLaw {
  double restitution = 1;                 ///< e, in [0, 1]
  double friction = 0;                    ///< Coulomb's mu, >= 0 and finite
  double separation_speed_floor_mps = 0;  ///< v_c >= 0; 0 switches it off
};

enum class ImpactRegime : std::uint8_t {
  separating,  ///< the bodies didn't approach; nothing changed
  sliding,     ///< friction on the cone's surface (mu = 0 included)
  sticking,    ///< friction inside the cone
  unresolved   ///< rounding destroyed the result, or it is NaN; nothing changed (rigid_impact.h)
};

struct ImpactOutput {
  Twist a{};
  Twist b{};
  Vec3 impulse_ns = Vec3::Zero();  ///< on B, in the world's frame; A receives the opposite
  double normal_impulse_ns = 0;    ///< >= 0
  ImpactRegime regime = ImpactRegime::separating;
};

/// An impact in impulse space. Symbols: see the top of this file.
struct ImpactSplit {
  double approach_speed_mps = 0;       ///< u > 0
  double normal_inverse_mass = 0;      ///< K_nn > 0, in 1/kg
  double tangential_energy_twice = 0;  ///< b, in J; a multiple of Q's tangential part squared
  double stick_friction_ns = 0;        ///< length of Q's tangential part
  double stick_normal_ns = 0;          ///< Q's normal component: 0 for spheres, else either sign
};

struct ImpactShares {
  double closing_speed_mps = 0;  ///< u + w: (1 + w/u) P_I is this over K_nn, along n
  double normal_impulse_ns = 0;  ///< of all of P
  double friction_share = 0;     ///< kappa
  ImpactRegime regime = ImpactRegime::sliding;
};

/// Returns the greatest separation speed at which no energy is gained (invariant 4). Without
/// friction, this is u. For sliding, kappa = (u + w) c with c = mu / (K_nn (|Q_t| - mu Q_n)). The
/// energy's change is then (u + w) times a factor that is linear in w. For sticking, w^2 = u^2 +
/// K_nn b.
inline double separation_speed_bound(const ImpactSplit& impact, double friction) {
  const double u = impact.approach_speed_mps;
  const double b = impact.tangential_energy_twice;
  const double slack_ns = impact.stick_friction_ns - friction * impact.stick_normal_ns;
  if (slack_ns > 0) {
    const double c = friction / (impact.normal_inverse_mass * slack_ns);
    if (u * c < 1) {
      const double w = u + 2 * c * b * (1 - u * c) / (1 / impact.normal_inverse_mass + c * c * b);
      if ((u + w) * c <= 1) return w;
    }
  }
  return friction > 0 ? std::sqrt(u * u + impact.normal_inverse_mass * b) : u;
}

/// Applies the law. REQUIRES: fields in their ranges; everything finite.
inline ImpactShares impact_shares(const ImpactSplit& impact, const ContactLaw& law) {
  // Choose the separation speed.
  const double u = impact.approach_speed_mps;
  double w = law.restitution * u;
  if (w < law.separation_speed_floor_mps) {
    // At or below u the energy always suffices.
    w = law.separation_speed_floor_mps;
    if (w > u) w = std::min(w, separation_speed_bound(impact, law.friction));
  }
  // Stick if the whole of Q is inside the cone.
  ImpactShares shares{.closing_speed_mps = u + w};
  const double base_ns = shares.closing_speed_mps / impact.normal_inverse_mass;
  const double stick_ns = base_ns + impact.stick_normal_ns;
  if (impact.stick_friction_ns > law.friction * stick_ns) {
    // Otherwise find the greatest share of Q that the cone allows. The comparison above ensures
    // that slack_ns > 0 even after rounding. This form of the normal impulse avoids the
    // cancellation in base + kappa Q_n.
    const double slack_ns = impact.stick_friction_ns - law.friction * impact.stick_normal_ns;
    shares.friction_share = law.friction * base_ns / slack_ns;
    if (shares.friction_share < 1) {
      shares.normal_impulse_ns = base_ns * (impact.stick_friction_ns / slack_ns);
      return shares;
    }
  }
  shares.friction_share = 1;
  shares.normal_impulse_ns = stick_ns;
  shares.regime = ImpactRegime::sticking;
  return shares;
}

/// An impact in which friction acts against the slip. Symbols: see the top of this file.
struct SlipSplit {
  double approach_speed_mps = 0;   ///< u > 0
  double slip_speed_mps = 0;       ///< s > 0
  double normal_inverse_mass = 0;  ///< k, of either sign, in 1/kg
  double slip_inverse_mass = 0;    ///< g, of either sign, in 1/kg
};

/// Returns the normal impulse N in N s. Empty if the slip would reverse, or if the impulse wouldn't
/// separate the bodies (k <= 0). REQUIRES: fields in their ranges; everything finite.
inline std::optional<double> impulse_against_slip(const SlipSplit& impact, const ContactLaw& law) {
  if (!(impact.normal_inverse_mass > 0)) return std::nullopt;
  const double u = impact.approach_speed_mps;
  double w = law.restitution * u;
  if (w < law.separation_speed_floor_mps) {
    w = law.separation_speed_floor_mps;
    // Invariant 4: w - u <= mu (s + s') with s' = s + (u + w) ratio.
    const double ratio = impact.slip_inverse_mass / impact.normal_inverse_mass;
    const double share = law.friction * ratio;
    if (w > u && share < 1) {
      const double paid = u * (1 + share) + 2 * law.friction * impact.slip_speed_mps;
      // If w fell below u, the slip would reverse; the test below refuses this.
      w = std::min(w, std::max(u, paid / (1 - share)));
    }
  }
  const double impulse_ns = (u + w) / impact.normal_inverse_mass;
  // This comparison has no negation, so it refuses NaN.
  if (impact.slip_speed_mps + impulse_ns * impact.slip_inverse_mass >= 0) return impulse_ns;
  return std::nullopt;
}

}  // namespace sleight::physics
