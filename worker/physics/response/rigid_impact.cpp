#include "worker/physics/response/rigid_impact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {
namespace {

/// A moving body at the contact. P acts on it with `sign`.
struct Side {
  const RigidImpactBody* body = nullptr;
  double sign = 1;
  Vec3 arm_m = Vec3::Zero();  ///< from the centre of mass to the contact, in the world's frame
  Mat3 axes = Mat3::Identity();
};

Side side_of(const RigidImpactBody& body, double sign, const Vec3& contact_m) {
  return {&body, sign, contact_m - body.pose.position_m, math::matrix_of(body.pose.orientation)};
}

/// Converts a vector from the world's to the body's frame: multiplies it by the transpose of the
/// axes.
Vec3 in_body(const Mat3& axes, const Vec3& v) {
  return {(axes(0, 0) * v.x() + axes(1, 0) * v.y()) + axes(2, 0) * v.z(),
          (axes(0, 1) * v.x() + axes(1, 1) * v.y()) + axes(2, 1) * v.z(),
          (axes(0, 2) * v.x() + axes(1, 2) * v.y()) + axes(2, 2) * v.z()};
}

/// Whitened coordinates of one or two bodies: each body's velocity, then its angular velocity.
template <std::size_t k_sides>
using Whitened = std::array<double, 6 * k_sides>;

template <std::size_t k_size>
double dot(const std::array<double, k_size>& a, const std::array<double, k_size>& b) {
  // For one and for two bodies, six partial sums fix the order of additions and avoid a long chain
  // of dependent additions.
  std::array<double, 6> sums{};
  for (std::size_t i = 0; i < k_size; ++i)
    sums[i % 6] += a[i] * b[i];
  return ((sums[0] + sums[3]) + (sums[1] + sums[4])) + (sums[2] + sums[5]);
}

template <std::size_t k_size>
void subtract(std::array<double, k_size>& a, double factor, const std::array<double, k_size>& b) {
  for (std::size_t i = 0; i < k_size; ++i)
    a[i] -= factor * b[i];
}

template <std::size_t k_size>
void scale(std::array<double, k_size>& a, double factor) {
  for (double& component : a)
    component *= factor;
}

template <std::size_t k_sides>
using Sides = std::array<Side, k_sides>;

/// Returns the column of G for an impulse along a unit direction.
template <std::size_t k_sides>
Whitened<k_sides> column(const Sides<k_sides>& sides, const Vec3& direction) {
  Whitened<k_sides> y;
  for (std::size_t s = 0; s < k_sides; ++s) {
    const Side& side = sides[s];
    const RigidMass& mass = side.body->mass;
    const Vec3 turn = in_body(side.axes, math::cross(side.arm_m, direction));
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto at = 6 * s + static_cast<std::size_t>(i);
      y[at] = side.sign * mass.inverse_root_mass * direction[i];
      y[at + 3] = side.sign * mass.inverse_root_moments[i] * turn[i];
    }
  }
  return y;
}

template <std::size_t k_sides>
Whitened<k_sides> whitened(const Sides<k_sides>& sides, const std::array<Twist, k_sides>& twists) {
  Whitened<k_sides> y;
  for (std::size_t s = 0; s < k_sides; ++s) {
    const RigidMass& mass = sides[s].body->mass;
    const Vec3 spin_radps = in_body(sides[s].axes, twists[s].angular_velocity_radps);
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto at = 6 * s + static_cast<std::size_t>(i);
      y[at] = mass.root_mass * twists[s].velocity_mps[i];
      y[at + 3] = mass.root_moments[i] * spin_radps[i];
    }
  }
  return y;
}

/// Returns how much rounding of the twists may increase |y|^2. A rounding error d of an angular
/// velocity adds d times the angular momentum. The error is equally large along axes of large and
/// of small moment.
template <std::size_t k_sides>
double rounding_of_energy(const Sides<k_sides>& sides, const Whitened<k_sides>& y) {
  double sum = dot(y, y);
  for (std::size_t s = 0; s < k_sides; ++s) {
    const RigidMass& mass = sides[s].body->mass;
    Vec3 spin = Vec3::Zero();
    Vec3 momentum = Vec3::Zero();
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double component = y[6 * s + 3 + static_cast<std::size_t>(i)];
      spin[i] = mass.inverse_root_moments[i] * component;
      momentum[i] = mass.root_moments[i] * component;
    }
    sum += math::norm(spin) * math::norm(momentum);
  }
  return k_impact_rounding * sum;
}

template <std::size_t k_sides>
std::array<Twist, k_sides> pushed(const Sides<k_sides>& sides, const Vec3& impulse_ns) {
  std::array<Twist, k_sides> twists;
  for (std::size_t s = 0; s < k_sides; ++s) {
    const Side& side = sides[s];
    const RigidMass& mass = side.body->mass;
    const Vec3 on_body_ns = side.sign * impulse_ns;
    Vec3 spin = in_body(side.axes, math::cross(side.arm_m, on_body_ns));
    for (Eigen::Index i = 0; i < 3; ++i)
      spin[i] *= mass.inverse_root_moments[i] * mass.inverse_root_moments[i];
    twists[s].velocity_mps = side.body->twist.velocity_mps + mass.inverse_mass_per_kg * on_body_ns;
    twists[s].angular_velocity_radps =
        side.body->twist.angular_velocity_radps + math::product(side.axes, spin);
  }
  return twists;
}

struct Tangents {
  Vec3 first;
  Vec3 second;
};

/// Returns two unit vectors perpendicular to n (Duff and others, "Building an orthonormal basis,
/// revisited", Journal of Computer Graphics Techniques 6, 2017).
Tangents tangents_of(const Vec3& n) {
  const double sign = std::copysign(1.0, n.z());
  const double a = -1 / (sign + n.z());
  const double b = n.x() * n.y() * a;
  return {{1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x()},
          {b, sign + n.y() * n.y() * a, -n.y()}};
}

struct Impulse {
  Vec3 vector_ns = Vec3::Zero();
  double normal_ns = 0;
  ImpactRegime regime = ImpactRegime::separating;
};

/// Returns the law's impulse for given whitened velocities.
template <std::size_t k_sides>
Impulse impulse_of(const Sides<k_sides>& sides, Whitened<k_sides> y, const Vec3& n,
                   const ContactLaw& law) {
  // The normal column: e_1 and y's component along it.
  Whitened<k_sides> e1 = column(sides, n);
  const double r11 = std::sqrt(dot(e1, e1));
  scale(e1, 1 / r11);
  const double z1 = dot(e1, y);
  if (!(z1 < 0)) return {};
  ImpactSplit split{.approach_speed_mps = -z1 * r11, .normal_inverse_mass = r11 * r11};
  if (law.friction == 0) {
    const ImpactShares shares = impact_shares(split, law);
    return {shares.normal_impulse_ns * n, shares.normal_impulse_ns, ImpactRegime::sliding};
  }

  // Compute the tangential columns by modified Gram-Schmidt, and deflate y in the same steps
  // (Bjoerck, "Solving linear least squares problems by Gram-Schmidt orthogonalization", BIT 7,
  // 1967). K's eigenvalues are at least 1/m_A + 1/m_B, so R's diagonal elements are at least the
  // square root of this sum. If rounding destroys a column, use this bound as its diagonal element.
  const Tangents t = tangents_of(n);
  double inverse_mass = 0;
  for (const Side& side : sides)
    inverse_mass += side.body->mass.inverse_mass_per_kg;
  const double r_least = std::sqrt(inverse_mass);
  Whitened<k_sides> e2 = column(sides, t.first);
  Whitened<k_sides> e3 = column(sides, t.second);
  subtract(y, z1, e1);
  const double r12 = dot(e1, e2);
  subtract(e2, r12, e1);
  const double r13 = dot(e1, e3);
  subtract(e3, r13, e1);
  const double r22 = std::max(std::sqrt(dot(e2, e2)), r_least);
  scale(e2, 1 / r22);
  const double z2 = dot(e2, y);
  subtract(y, z2, e2);
  const double r23 = dot(e2, e3);
  subtract(e3, r23, e2);
  const double r33 = std::max(std::sqrt(dot(e3, e3)), r_least);
  scale(e3, 1 / r33);
  const double z3 = dot(e3, y);

  // If the slip doesn't reverse, apply friction against it: V = R^T z, K = R^T R.
  const double v2_mps = r12 * z1 + r22 * z2;
  const double v3_mps = r13 * z1 + r23 * z2 + r33 * z3;
  const double slip_mps = std::sqrt(v2_mps * v2_mps + v3_mps * v3_mps);
  if (slip_mps > 0) {
    const double d2 = v2_mps / slip_mps;
    const double d3 = v3_mps / slip_mps;
    // This is the vector R d, whose first component couples slip and normal motion.
    const double a1 = r12 * d2 + r13 * d3;
    const double a2 = r22 * d2 + r23 * d3;
    const double a3 = r33 * d3;
    const SlipSplit slip{
        .approach_speed_mps = split.approach_speed_mps,
        .slip_speed_mps = slip_mps,
        .normal_inverse_mass = r11 * (r11 - law.friction * a1),
        .slip_inverse_mass = r11 * a1 - law.friction * (a1 * a1 + a2 * a2 + a3 * a3)};
    if (const std::optional<double> normal_ns = impulse_against_slip(slip, law)) {
      const double friction_ns = law.friction * *normal_ns;
      return {*normal_ns * n - friction_ns * d2 * t.first - friction_ns * d3 * t.second, *normal_ns,
              ImpactRegime::sliding};
    }
  }

  // Q solves R Q = (0, -z2, -z3).
  const double q3_ns = -z3 / r33;
  const double q2_ns = (-z2 - r23 * q3_ns) / r22;
  split.tangential_energy_twice = z2 * z2 + z3 * z3;
  split.stick_friction_ns = std::sqrt(q2_ns * q2_ns + q3_ns * q3_ns);
  split.stick_normal_ns = -(r12 * q2_ns + r13 * q3_ns) / r11;
  const ImpactShares shares = impact_shares(split, law);
  const double kappa = shares.friction_share;
  return {shares.normal_impulse_ns * n + kappa * q2_ns * t.first + kappa * q3_ns * t.second,
          shares.normal_impulse_ns, shares.regime};
}

/// Computes impulse and new twists. If `guarded`, reduces P until no energy is gained.
template <bool guarded, std::size_t k_sides>
Impulse resolved(const Sides<k_sides>& sides, const RigidImpactInput& input,
                 std::array<Twist, k_sides>& twists) {
  const Whitened<k_sides> before = whitened(sides, twists);
  Impulse impulse = impulse_of(sides, before, input.normal, input.law);
  if (impulse.regime == ImpactRegime::separating) return impulse;
  const std::array<Twist, k_sides> twists_before = twists;
  twists = pushed(sides, impulse.vector_ns);
  if constexpr (guarded) {
    const double energy_twice = dot(before, before);
    double reduction = k_impact_reduction_first;
    for (int round = 0;; ++round) {
      const Whitened<k_sides> after = whitened(sides, twists);
      const double gain = dot(after, after) - energy_twice;
      if (gain <= 0 || gain <= rounding_of_energy(sides, after)) return impulse;
      if (round == k_impact_reduction_rounds) break;
      const double factor = 1 - reduction;
      impulse.vector_ns *= factor;
      impulse.normal_ns *= factor;
      twists = pushed(sides, impulse.vector_ns);
      reduction *= k_impact_reduction_growth;
    }
    twists = twists_before;
    return {.regime = ImpactRegime::unresolved};
  }
  return impulse;
}

template <bool guarded>
ImpactOutput rigid_impact_of(const RigidImpactInput& input) {
  ImpactOutput out{.a = input.a.twist, .b = input.b.twist};
  Impulse impulse;
  const bool moves_a = input.a.mass.inverse_mass_per_kg > 0;
  const bool moves_b = input.b.mass.inverse_mass_per_kg > 0;
  if (moves_a && moves_b) {
    std::array<Twist, 2> twists{out.a, out.b};
    impulse = resolved<guarded>(
        Sides<2>{side_of(input.a, -1, input.contact_m), side_of(input.b, 1, input.contact_m)},
        input, twists);
    out.a = twists[0];
    out.b = twists[1];
  } else {
    std::array<Twist, 1> twists{moves_a ? out.a : out.b};
    impulse = resolved<guarded>(Sides<1>{moves_a ? side_of(input.a, -1, input.contact_m)
                                                 : side_of(input.b, 1, input.contact_m)},
                                input, twists);
    (moves_a ? out.a : out.b) = twists[0];
  }
  out.impulse_ns = impulse.vector_ns;
  out.normal_impulse_ns = impulse.normal_ns;
  out.regime = impulse.regime;
  return out;
}

}  // namespace

RigidMass rigid_mass(const Inertia& inertia) {
  RigidMass mass;
  mass.inverse_mass_per_kg = 1 / inertia.mass_kg;
  mass.root_mass = std::sqrt(inertia.mass_kg);
  mass.inverse_root_mass = 1 / mass.root_mass;
  for (Eigen::Index i = 0; i < 3; ++i) {
    mass.root_moments[i] = std::sqrt(inertia.principal_kgm2[i]);
    mass.inverse_root_moments[i] = 1 / mass.root_moments[i];
  }
  return mass;
}

ImpactOutput rigid_impact(const RigidImpactInput& input) {
  return rigid_impact_of<true>(input);
}

Twist rigid_hop(const RigidImpactBody& body, const Vec3& contact_m, const Vec3& normal,
                double speed_mps) {
  const Sides<1> sides{side_of(body, 1, contact_m)};
  Whitened<1> y = whitened<1>(sides, {body.twist});
  Whitened<1> e1 = column(sides, normal);
  const double r11 = std::sqrt(dot(e1, e1));
  scale(e1, 1 / r11);
  const double parts = dot(e1, y);
  const double wanted = speed_mps / r11;
  if (!(parts < wanted)) return body.twist;
  subtract(y, parts, e1);
  const double other = dot(y, y);
  const double paid = std::min(wanted * wanted - parts * parts, 0.5 * other);
  if (!(paid > 0)) return body.twist;
  scale(y, std::sqrt(1 - paid / other));
  subtract(y, -std::sqrt(parts * parts + paid), e1);
  Twist twist;
  Vec3 spin;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    twist.velocity_mps[i] = body.mass.inverse_root_mass * y[at];
    spin[i] = body.mass.inverse_root_moments[i] * y[at + 3];
  }
  twist.angular_velocity_radps = math::product(sides[0].axes, spin);
  return twist;
}

ImpactOutput rigid_impact_unguarded(const RigidImpactInput& input) {
  return rigid_impact_of<false>(input);
}

}  // namespace sleight::physics
