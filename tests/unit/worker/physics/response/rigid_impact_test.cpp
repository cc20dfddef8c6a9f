// Tests the invariants of rigid_impact.h on random impacts, and compares impacts with a slow
// reference. energy_hunt_test.cpp searches for impacts that gain energy.
#include "worker/physics/response/rigid_impact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/response/reference.h"

namespace sleight::physics::rigid_impact_test {

using namespace response_reference;

/// Difference of two outputs: the square root of the quotient of two energies. The numerator is the
/// kinetic energy of the twists' difference, and the denominator is the energy before the impact.
Real difference(const Case& made, const ImpactOutput& left, const ImpactOutput& right) {
  const auto less = [](const Twist& a, const Twist& b) {
    return Twist{a.velocity_mps - b.velocity_mps,
                 a.angular_velocity_radps - b.angular_velocity_radps};
  };
  const Real apart = kinetic_energy(made, less(left.a, right.a), less(left.b, right.b));
  return std::sqrt(apart / kinetic_energy(made, made.a.twist, made.b.twist));
}

/// Sum of 1/m + r^2 / (least moment). K amplifies a rounding error of the impulse by at most this
/// sum.
Real inverse_mass_bound(const Case& made) {
  Real sum = 0;
  for (const Body* body : {&made.a, &made.b}) {
    if (body->inertia.mass_kg == 0) continue;
    const Real3 arm = real(made.contact_m - body->pose.position_m);
    sum += 1 / static_cast<Real>(body->inertia.mass_kg) +
           dot(arm, arm) / body->inertia.principal_kgm2.minCoeff();
  }
  return sum;
}

void expect_invariants(const Case& made) {
  const ImpactOutput out = rigid_impact(input_of(made));
  ASSERT_NE(out.regime, ImpactRegime::separating);
  ASSERT_NE(out.regime, ImpactRegime::unresolved);
  EXPECT_LE(relative_gain(made, out), 1e-13L);

  const Real3 n = real(made.normal);
  const Real3 p = real(out.impulse_ns);
  const Real rounding =
      16 * k_epsilon *
      (contact_speed_scale(made, made.a.twist, made.b.twist) +
       contact_speed_scale(made, out.a, out.b) + inverse_mass_bound(made) * norm(p));
  const Real before = dot(contact_velocity(made, made.a.twist, made.b.twist), n);
  const Real after = dot(contact_velocity(made, out.a, out.b), n);
  EXPECT_GE(after, -rounding);
  if (made.law.separation_speed_floor_mps == 0) {
    // The guard can reduce the impulse by 1e-13 of its size.
    expect_near(after, -made.law.restitution * before, rounding - 1e-12L * before);
  }

  const Real normal_impulse = dot(p, n);
  EXPECT_GE(normal_impulse, 0);
  expect_near(out.normal_impulse_ns, normal_impulse, 8 * k_epsilon * norm(p));
  EXPECT_LE(norm(p - normal_impulse * n),
            made.law.friction * normal_impulse * (1 + 1e-12L) + 8 * k_epsilon * norm(p));

  // Two bodies conserve both momenta. If one partner is static, the other partner gains the
  // impulse.
  const bool two = made.a.inertia.mass_kg > 0 && made.b.inertia.mass_kg > 0;
  const Real3 gained = made.a.inertia.mass_kg > 0 ? Real{-1} * p : p;
  const Real3 expected = two ? Real3{} : gained;
  const Real3 turn = two ? Real3{} : cross(real(made.contact_m), gained);
  Real linear_scale = norm(p);
  Real angular_scale = 0;
  for (const auto& [body, twist] :
       {std::pair{&made.a, &made.a.twist}, std::pair{&made.b, &made.b.twist},
        std::pair{&made.a, &out.a}, std::pair{&made.b, &out.b}}) {
    const Real linear = body->inertia.mass_kg * norm(real(twist->velocity_mps));
    const Real arm = norm(real(made.contact_m)) + norm(real(body->pose.position_m));
    linear_scale += linear;
    angular_scale +=
        linear * arm + norm(p) * arm +
        body->inertia.principal_kgm2.maxCoeff() * norm(real(twist->angular_velocity_radps));
  }
  EXPECT_LE(
      norm(momentum(made, out.a, out.b) - momentum(made, made.a.twist, made.b.twist) - expected),
      16 * k_epsilon * linear_scale);
  EXPECT_LE(norm(angular_momentum(made, out.a, out.b) -
                 angular_momentum(made, made.a.twist, made.b.twist) - turn),
            16 * k_epsilon * angular_scale);

  // Even without friction and loss, the guard and the impulse's rounding (through K) can take
  // energy.
  if (made.law.friction == 0 && made.law.restitution == 1) {
    const Real energy = kinetic_energy(made, made.a.twist, made.b.twist);
    const Real push = norm(p) * std::sqrt(inverse_mass_bound(made) / energy);
    EXPECT_GE(relative_gain(made, out), -1e-12L - 16 * k_epsilon * push);
  }
}

TEST(RigidImpact, KeepsItsInvariants) {
  // Goal: an impact gains no energy, separates the bodies at the right speed, stays in the friction
  // cone and conserves both momenta. Method: check impacts of random bodies in extended precision.
  // Moments of inertia differ by up to a factor of 1e4, and contacts are up to ten radii of
  // gyration away. One body in three hits static geometry. Some bodies graze each other; some
  // impacts have e of 0 or 1, or mu of 0 or 10.
  Dice dice(1);
  for ([[maybe_unused]] const std::uint64_t i :
       property::in_turn(property::of_tier(20'000, 100'000))) {
    if (HasFailure()) break;
    expect_invariants(random_case(dice, {}));
  }
}

TEST(RigidImpact, KeepsItsInvariantsWithAFloorOfTheSeparationSpeed) {
  // Goal: the invariants of an impact also hold if a floor raises the separation speed of slow
  // impacts. Method: use floors below and above all approach speeds.
  Dice dice(2);
  for ([[maybe_unused]] const std::uint64_t i :
       property::in_turn(property::of_tier(20'000, 100'000))) {
    if (HasFailure()) break;
    expect_invariants(random_case(dice, {.floor_mps_max = 2}));
  }
}

TEST(RigidImpact, KeepsItsInvariantsAtExtremeMassRatios) {
  // Goal: the invariants of an impact also hold for bodies with masses from 1e-6 to 1e6 kg.
  Dice dice(3);
  for ([[maybe_unused]] const std::uint64_t i :
       property::in_turn(property::of_tier(10'000, 50'000))) {
    if (HasFailure()) break;
    expect_invariants(random_case(dice, {.mass_ratio_max = 1e12, .floor_mps_max = 0.1}));
  }
}

TEST(RigidImpact, AgreesWithTheLawsDefinition) {
  // Goal: the whitened closed form gives the result that the law defines. Method: compare impacts
  // with the slow reference. The reference solves equations with K, and finds kappa and the raised
  // speed by bisection. Well-conditioned impacts must agree to 1e-11 of the square root of the
  // energy, and all regimes must occur.
  Dice dice(4);
  int sticking = 0;
  int raised = 0;
  const auto cases = static_cast<int>(property::of_tier(5'000, 20'000));
  Real worst = 0;
  for (int i = 0; i < cases; ++i) {
    const Case made = random_case(
        dice, {.moment_ratio_max = 30, .arm_max = 2, .mass_ratio_max = 100, .floor_mps_max = 0.5});
    const ImpactOutput out = rigid_impact(input_of(made));
    worst = std::max(worst, difference(made, out, slow_impact(made)));
    if (out.regime == ImpactRegime::sticking) ++sticking;
    const Real u = -dot(contact_velocity(made, made.a.twist, made.b.twist), real(made.normal));
    const Real w = dot(contact_velocity(made, out.a, out.b), real(made.normal));
    if (w > u * 1.0001L) ++raised;
  }
  EXPECT_LE(worst, 1e-11L);
  EXPECT_GT(sticking, cases / 20);
  EXPECT_LT(sticking, cases * 19 / 20);
  EXPECT_GT(raised, cases / 50);
}

TEST(RigidImpact, AgreesWithTheSlowLawForNeedlesToo) {
  // Goal: the closed form takes the right branch even for badly conditioned bodies. Method: compare
  // impacts with the slow reference. Moments of inertia differ by up to a factor of 1e4.
  Dice dice(5);
  Real worst = 0;
  for (int i = 0; i < 10'000; ++i) {
    const Case made = random_case(dice, {.floor_mps_max = 0.5});
    worst = std::max(worst, difference(made, rigid_impact(input_of(made)), slow_impact(made)));
  }
  EXPECT_LE(worst, 1e-8L);
}

TEST(RigidImpact, AgreesWithSpheresInCentralImpacts) {
  // Goal: rigid_impact() and sphere_impact() agree on spheres to 1e-12. Method: compute impacts of
  // random spheres with both functions. One sphere in three hits static geometry.
  Dice dice(8);
  int sticking = 0;
  constexpr int k_cases = 20'000;
  for (int i = 0; i < k_cases; ++i) {
    Case made = random_case(dice, {.moment_ratio_max = 1, .mass_ratio_max = 100});
    SphereImpactInput spheres{.normal = made.normal, .law = made.law};
    if (dice.once_in(2)) spheres.law.separation_speed_floor_mps = dice.spread(1e-3, 1);
    made.law = spheres.law;
    for (Body* body : {&made.a, &made.b}) {
      if (body->inertia.mass_kg == 0) continue;
      const double radius_m = dice.spread(0.1, 10);
      const double moment = dice.uniform(0.01, 0.66) * body->inertia.mass_kg * radius_m * radius_m;
      body->inertia.principal_kgm2 = Vec3::Constant(moment);
      body->pose.position_m = (body == &made.a ? -radius_m : radius_m) * made.normal;
      body->twist.angular_velocity_radps = dice.spread(1e-2, 1) / radius_m * dice.direction();
      (body == &made.a ? spheres.mass_a : spheres.mass_b) =
          sphere_mass(body->inertia.mass_kg, radius_m, moment);
    }
    spheres.a = made.a.twist;
    spheres.b = made.b.twist;
    const ImpactOutput expected = sphere_impact(spheres);
    const ImpactOutput out = rigid_impact(input_of(made));
    ASSERT_EQ(out.regime, expected.regime) << i;
    ASSERT_LE(difference(made, expected, out), 1e-12L) << i;
    if (out.regime == ImpactRegime::sticking) ++sticking;
  }
  EXPECT_GT(sticking, k_cases / 20);
  EXPECT_LT(sticking, k_cases / 2);
}

TEST(RigidImpact, SaysWhenItHasNoAnswer) {
  // Goal: a numerical failure is reported as `unresolved` and changes no motion. Method: let the
  // energy overflow.
  RigidImpactInput input;
  input.b.mass = rigid_mass({.mass_kg = 1, .principal_kgm2 = Vec3(1, 1, 1)});
  input.b.pose.position_m = Vec3(0.5, 0, 1);
  input.b.twist.velocity_mps = Vec3(1e160, 0, -1e160);
  input.law.friction = 0.5;
  const ImpactOutput out = rigid_impact(input);
  EXPECT_EQ(out.regime, ImpactRegime::unresolved);
  EXPECT_EQ(out.b.velocity_mps, input.b.twist.velocity_mps);
  EXPECT_EQ(out.impulse_ns, Vec3::Zero());
}

TEST(RigidImpact, HopsArePaidFromOtherMotion) {
  // Goal: rigid_hop() keeps the energy and separates a body at the requested speed. If half of the
  // other motion's energy doesn't suffice, the body separates as fast as this half allows. A body
  // that is already faster stays unchanged.
  Dice dice(11);
  int paid = 0;
  int poor = 0;
  for (int i = 0; i < 20'000; ++i) {
    Case made = random_case(dice, {});
    if (made.b.inertia.mass_kg == 0) continue;
    made.a = {};
    const Real3 v = contact_velocity(made, {}, made.b.twist);
    if (dot(v, real(made.normal)) < 0) made.normal = -made.normal;
    const double speed_mps = dice.spread(1e-4, 1);
    const Twist after = rigid_hop(input_of(made).b, made.contact_m, made.normal, speed_mps);
    const auto before_mps = static_cast<double>(dot(v, real(made.normal)));
    const auto after_mps =
        static_cast<double>(dot(contact_velocity(made, {}, after), real(made.normal)));
    const auto scale_mps = static_cast<double>(contact_speed_scale(made, {}, made.b.twist));
    if (before_mps >= speed_mps) {
      EXPECT_NEAR(after_mps, before_mps, 1e-12 * scale_mps);
      continue;
    }
    EXPECT_LT(std::abs(relative_gain(made, {.b = after})), 1e-12L);
    EXPECT_GE(after_mps, before_mps - 1e-12 * scale_mps);
    EXPECT_LE(after_mps, speed_mps + 1e-9 * scale_mps);
    ++(after_mps > speed_mps - 1e-9 * scale_mps ? paid : poor);
  }
  EXPECT_GT(paid, 1000);
  EXPECT_GT(poor, 100);
}

TEST(RigidImpact, LeavesSeparatingBodiesAlone) {
  // Goal: bodies that don't approach get no impulse. Method: reverse the normals of random impacts,
  // so that the bodies separate.
  Dice dice(9);
  for (int i = 0; i < 1000; ++i) {
    Case made = random_case(dice, {});
    made.normal = -made.normal;
    const ImpactOutput out = rigid_impact(input_of(made));
    EXPECT_EQ(out.regime, ImpactRegime::separating);
    EXPECT_EQ(out.a.velocity_mps, made.a.twist.velocity_mps);
    EXPECT_EQ(out.b.angular_velocity_radps, made.b.twist.angular_velocity_radps);
    EXPECT_EQ(out.impulse_ns, Vec3::Zero());
  }
}

}  // namespace sleight::physics::rigid_impact_test
