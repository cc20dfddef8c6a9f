#include "tests/unit/worker/physics/response/reference.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

namespace sleight::physics::response_reference {
namespace {

using Real33 = std::array<Real3, 3>;  // rows

/// Rotation matrix of a quaternion with any norm.
Real33 axes_of(const Quat& q) {
  const Real w = q.w();
  const Real x = q.x();
  const Real y = q.y();
  const Real z = q.z();
  const Real s = 2 / (w * w + x * x + y * y + z * z);
  return {Real3{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
          Real3{s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)},
          Real3{s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)}};
}

Real3 times(const Real33& m, const Real3& v) {
  return {dot(m[0], v), dot(m[1], v), dot(m[2], v)};
}
Real3 transposed_times(const Real33& m, const Real3& v) {
  return v[0] * m[0] + v[1] * m[1] + v[2] * m[2];
}

bool moves(const Body& body) {
  return body.inertia.mass_kg > 0;
}
Real3 spin_in_body(const Body& body, const Twist& twist) {
  return transposed_times(axes_of(body.pose.orientation), real(twist.angular_velocity_radps));
}
Real3 spin_momentum(const Body& body, const Twist& twist) {
  Real3 spin = spin_in_body(body, twist);
  for (std::size_t i = 0; i < 3; ++i)
    spin[i] *= body.inertia.principal_kgm2[static_cast<Eigen::Index>(i)];
  return times(axes_of(body.pose.orientation), spin);
}
Real energy(const Body& body, const Twist& twist) {
  if (!moves(body)) return 0;
  const Real3 v = real(twist.velocity_mps);
  return 0.5L * body.inertia.mass_kg * dot(v, v) +
         0.5L * dot(real(twist.angular_velocity_radps), spin_momentum(body, twist));
}
Real3 arm(const Case& made, const Body& body) {
  return real(made.contact_m) - real(body.pose.position_m);
}
Real3 point_velocity(const Case& made, const Body& body, const Twist& twist) {
  if (!moves(body)) return {};
  return real(twist.velocity_mps) + cross(real(twist.angular_velocity_radps), arm(made, body));
}

Real3 spin_change(const Case& made, const Body& body, const Real3& impulse) {
  const Real33 axes = axes_of(body.pose.orientation);
  Real3 spin = transposed_times(axes, cross(arm(made, body), impulse));
  for (std::size_t i = 0; i < 3; ++i)
    spin[i] /= body.inertia.principal_kgm2[static_cast<Eigen::Index>(i)];
  return times(axes, spin);
}
Real3 response(const Case& made, const Real3& impulse) {
  Real3 sum{};
  for (const Body* body : {&made.a, &made.b}) {
    if (!moves(*body)) continue;
    sum = sum + (1 / static_cast<Real>(body->inertia.mass_kg)) * impulse +
          cross(spin_change(made, *body, impulse), arm(made, *body));
  }
  return sum;
}
/// Solves K P = v by Cramer's rule.
Real3 solved(const Case& made, const Real3& v) {
  const Real3 x = response(made, {1, 0, 0});
  const Real3 y = response(made, {0, 1, 0});
  const Real3 z = response(made, {0, 0, 1});
  const Real determinant = dot(x, cross(y, z));
  return {dot(v, cross(y, z)) / determinant, dot(x, cross(v, z)) / determinant,
          dot(x, cross(y, v)) / determinant};
}

Vec3 rounded(const Real3& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}
Twist pushed(const Case& made, const Body& body, const Real3& impulse) {
  if (!moves(body)) return body.twist;
  const Real3 v =
      real(body.twist.velocity_mps) + (1 / static_cast<Real>(body.inertia.mass_kg)) * impulse;
  const Real3 spin = real(body.twist.angular_velocity_radps) + spin_change(made, body, impulse);
  return {rounded(v), rounded(spin)};
}
ImpactOutput output_of(const Case& made, const Real3& impulse) {
  ImpactOutput out{.a = pushed(made, made.a, -1 * impulse), .b = pushed(made, made.b, impulse)};
  out.impulse_ns = rounded(impulse);
  out.normal_impulse_ns = static_cast<double>(dot(impulse, real(made.normal)));
  return out;
}

Real3 across(const Real3& v, const Real3& n) {
  return v - dot(v, n) * n;
}
bool in_cone(const Real3& impulse, const Real3& n, Real friction) {
  return norm(across(impulse, n)) <= friction * dot(impulse, n);
}

/// A body's mass, moments and place. The contact is at the origin.
Body random_body(Dice& dice, const CaseOptions& options) {
  Body body;
  const double root = std::sqrt(options.mass_ratio_max);
  const double length = dice.spread(1e-2, 1e1);
  body.inertia.mass_kg = dice.spread(1 / root, root);
  // Draw second moments of the mass, so that the moments of inertia satisfy the triangle
  // inequality. Some bodies are needles or plates.
  Vec3 squares;
  for (Eigen::Index i = 0; i < 3; ++i)
    squares[i] = dice.spread(1 / options.moment_ratio_max, 1) * length * length;
  squares[0] = length * length;
  if (dice.once_in(3)) squares[1] = squares[0];
  if (dice.once_in(3)) squares[2] = squares[1];
  body.inertia.principal_kgm2 =
      body.inertia.mass_kg *
      Vec3(squares[1] + squares[2], squares[0] + squares[2], squares[0] + squares[1]);
  body.pose.orientation = dice.rotation();
  body.pose.position_m = dice.spread(1e-2, options.arm_max) * length * dice.direction();
  body.twist.velocity_mps = dice.spread(1e-2, 1) * dice.direction();
  body.twist.angular_velocity_radps = dice.spread(1e-3, 1) / length * dice.direction();
  return body;
}

}  // namespace

Real3 real(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
Real3 operator+(const Real3& a, const Real3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Real3 operator-(const Real3& a, const Real3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Real3 operator*(Real factor, const Real3& a) {
  return {factor * a[0], factor * a[1], factor * a[2]};
}
Real dot(const Real3& a, const Real3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Real norm(const Real3& a) {
  return std::sqrt(dot(a, a));
}
Real3 cross(const Real3& a, const Real3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

RigidImpactInput input_of(const Case& made) {
  RigidImpactInput input{.contact_m = made.contact_m, .normal = made.normal, .law = made.law};
  for (const auto& [body, into] : {std::pair{&made.a, &input.a}, std::pair{&made.b, &input.b}}) {
    if (moves(*body)) into->mass = rigid_mass(body->inertia);
    into->pose = body->pose;
    into->twist = body->twist;
  }
  return input;
}

Case random_case(Dice& dice, const CaseOptions& options) {
  Case made{.a = random_body(dice, options), .b = random_body(dice, options)};
  if (dice.once_in(3)) (dice.once_in(2) ? made.a : made.b) = Body{};
  made.normal = dice.direction();
  const Real3 v = contact_velocity(made, made.a.twist, made.b.twist);
  if (dice.once_in(5)) {
    // Grazing: the normal is almost perpendicular to the velocity.
    const Real along = dot(v, real(made.normal)) / dot(v, v);
    const Real3 grazing = real(made.normal) - (along + dice.spread(1e-8, 1e-2) / norm(v)) * v;
    made.normal = rounded(1 / norm(grazing) * grazing);
  }
  if (dot(v, real(made.normal)) > 0) made.normal = -made.normal;
  ContactLaw& law = made.law;
  law.restitution = dice.once_in(4) ? 1 : dice.once_in(4) ? 0 : dice.uniform(0, 1);
  law.friction = dice.once_in(6) ? 0 : dice.once_in(6) ? 10 : dice.spread(1e-3, 10);
  if (options.floor_mps_max > 0) {
    law.separation_speed_floor_mps = dice.spread(1e-4, 1) * options.floor_mps_max;
  }
  return made;
}

Real kinetic_energy(const Case& made, const Twist& a, const Twist& b) {
  return energy(made.a, a) + energy(made.b, b);
}
Real3 momentum(const Case& made, const Twist& a, const Twist& b) {
  return made.a.inertia.mass_kg * real(a.velocity_mps) +
         made.b.inertia.mass_kg * real(b.velocity_mps);
}
Real3 angular_momentum(const Case& made, const Twist& a, const Twist& b) {
  Real3 sum{};
  for (const auto& [body, twist] : {std::pair{&made.a, &a}, std::pair{&made.b, &b}}) {
    if (!moves(*body)) continue;
    const Real3 linear = body->inertia.mass_kg * real(twist->velocity_mps);
    sum = sum + cross(real(body->pose.position_m), linear) + spin_momentum(*body, *twist);
  }
  return sum;
}
Real3 contact_velocity(const Case& made, const Twist& a, const Twist& b) {
  return point_velocity(made, made.b, b) - point_velocity(made, made.a, a);
}
Real contact_speed_scale(const Case& made, const Twist& a, const Twist& b) {
  Real sum = 0;
  for (const auto& [body, twist] : {std::pair{&made.a, &a}, std::pair{&made.b, &b}}) {
    if (!moves(*body)) continue;
    sum += norm(real(twist->velocity_mps)) +
           norm(arm(made, *body)) * norm(real(twist->angular_velocity_radps));
  }
  return sum;
}
Real relative_gain(const Case& made, const ImpactOutput& out) {
  const Real before = kinetic_energy(made, made.a.twist, made.b.twist);
  return (kinetic_energy(made, out.a, out.b) - before) / before;
}

namespace {

/// Separation speed for an approach at u. If `is_granted`, the speed is raised to the floor.
/// Otherwise, the speed is raised as far as gain_at(w) <= 0 allows.
template <class Gain>
Real separation_speed(const ContactLaw& law, Real u, bool is_granted, const Gain& gain_at) {
  const Real slow = law.restitution * u;
  const Real floor = law.separation_speed_floor_mps;
  if (slow >= floor) return slow;
  if (floor <= u || is_granted || gain_at(floor) <= 0) return floor;
  Real low = u;
  Real high = floor;
  for (int i = 0; i < 80; ++i) {
    const Real middle = (low + high) / 2;
    (gain_at(middle) <= 0 ? low : high) = middle;
  }
  return low;
}

/// Impulse with friction against the slip. Nothing if the slip reverses.
std::optional<Real3> slow_impulse_against_slip(const Case& made, Fault fault) {
  const Real3 n = real(made.normal);
  const Real3 v = contact_velocity(made, made.a.twist, made.b.twist);
  const Real u = -dot(v, n);
  const Real s = norm(across(v, n));
  if (s == 0 || made.law.friction == 0) return std::nullopt;
  const Real3 direction = n - made.law.friction / s * across(v, n);
  const Real k = dot(n, response(made, direction));
  if (k <= 0) return std::nullopt;
  const auto impulse_at = [&](Real w) { return (u + w) / k * direction; };
  const auto gain_at = [&](Real w) {
    const Real3 p = impulse_at(w);
    return dot(v, p) + dot(p, response(made, p)) / 2;
  };
  const Real w = separation_speed(made.law, u, fault == Fault::slip_unpaid, gain_at);
  const Real3 after = v + response(made, impulse_at(w));
  if (dot(after, across(v, n)) < 0 && fault != Fault::turned) return std::nullopt;
  return impulse_at(w);
}

}  // namespace

ImpactOutput slow_impact(const Case& made, Fault fault) {
  const Real3 n = real(made.normal);
  const Real3 v = contact_velocity(made, made.a.twist, made.b.twist);
  const Real u = -dot(v, n);
  if (u <= 0) return output_of(made, {});
  if (const auto against = slow_impulse_against_slip(made, fault)) return output_of(made, *against);
  const Real3 p1 = u / dot(n, response(made, n)) * n;
  Real3 q = solved(made, -1 * v) - p1;
  if (fault == Fault::uncoupled) q = across(q, n);
  // For each separation speed, find the greatest kappa in the convex cone.
  const auto impulse_at = [&](Real w) {
    const Real3 base = (1 + w / u) * p1;
    if (in_cone(base + q, n, made.law.friction)) return base + q;
    Real low = 0;
    Real high = 1;
    for (int i = 0; i < 80; ++i) {
      const Real middle = (low + high) / 2;
      (in_cone(base + middle * q, n, made.law.friction) ? low : high) = middle;
    }
    return base + low * q;
  };
  const auto gain_at = [&](Real w) {
    const Real3 p = impulse_at(w);
    return dot(v, p) + dot(p, response(made, p)) / 2;
  };
  const Real w = separation_speed(made.law, u, fault == Fault::unpaid, gain_at);
  return output_of(made, impulse_at(w));
}

ImpactOutput plain_newton_impact(const Case& made) {
  const Real3 n = real(made.normal);
  const Real3 v = contact_velocity(made, made.a.twist, made.b.twist);
  const Real u = -dot(v, n);
  const Real3 stick = solved(made, made.law.restitution * u * n - v);
  if (in_cone(stick, n, made.law.friction)) return output_of(made, stick);
  const Real3 slip = across(v, n);
  const Real3 direction = n - made.law.friction / norm(slip) * slip;
  const Real inverse_mass = dot(n, response(made, direction));
  // If friction jams the contact, this law has no solution.
  if (inverse_mass <= 0) return output_of(made, {});
  return output_of(made, (1 + made.law.restitution) * u / inverse_mass * direction);
}

}  // namespace sleight::physics::response_reference
