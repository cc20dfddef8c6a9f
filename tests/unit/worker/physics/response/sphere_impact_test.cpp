// Tests the invariants of sphere_impact.h. rigid_impact_test.cpp compares spheres with rigid
// bodies, and known_answers_test.cpp compares impacts with known answers.
#include "worker/physics/response/sphere_impact.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/response/reference.h"

namespace sleight::physics::sphere_impact_test {

using namespace response_reference;

struct Spheres {
  SphereImpactInput input;
  Case made;  ///< the same spheres for the reference
};

/// Two spheres, or a sphere and static geometry in either order. Both touch at the origin and
/// approach each other.
Spheres random_spheres(Dice& dice) {
  Spheres spheres;
  Case& made = spheres.made;
  made.normal = dice.direction();
  made.law.restitution = dice.once_in(4) ? 1 : dice.once_in(4) ? 0 : dice.uniform(0, 1);
  made.law.friction = dice.once_in(6) ? 0 : dice.once_in(6) ? 1e6 : dice.spread(1e-3, 10);
  if (dice.once_in(2)) made.law.separation_speed_floor_mps = dice.spread(1e-4, 1);
  const bool alone = dice.once_in(3);
  const bool static_a = dice.once_in(2);
  for (Body* body : {&made.a, &made.b}) {
    const bool is_a = body == &made.a;
    if (alone && is_a == static_a) continue;
    const double radius_m = dice.spread(1e-3, 10);
    const double mass_kg = dice.spread(1e-6, 1e6);
    // Moments range from a heavy core's moment to a hollow shell's moment.
    const double moment = dice.spread(1e-3, 2.0 / 3) * mass_kg * radius_m * radius_m;
    body->inertia = {.mass_kg = mass_kg, .principal_kgm2 = Vec3::Constant(moment)};
    body->pose.position_m = (is_a ? -radius_m : radius_m) * made.normal;
    body->twist = {dice.spread(1e-3, 1) * dice.direction(),
                   dice.spread(1e-3, 1) / radius_m * dice.direction()};
    (is_a ? spheres.input.mass_a : spheres.input.mass_b) = sphere_mass(mass_kg, radius_m, moment);
  }
  const Real3 v = contact_velocity(made, made.a.twist, made.b.twist);
  if (dot(v, real(made.normal)) > 0) {
    for (Body* body : {&made.a, &made.b})
      body->twist.velocity_mps = -body->twist.velocity_mps;
  }
  spheres.input.a = made.a.twist;
  spheres.input.b = made.b.twist;
  spheres.input.normal = made.normal;
  spheres.input.law = made.law;
  return spheres;
}

TEST(SphereImpact, KeepsItsInvariants) {
  // Goal: an impact of spheres gains no energy, separates the spheres at the right speed and stays
  // in the friction cone. Spheres stick or slide as the law says. Method: check impacts of random
  // spheres in extended precision. Masses are 1e-6 to 1e6 kg, and moments of inertia range from a
  // heavy core's to a hollow shell's.
  Dice dice(11);
  int sticking = 0;
  constexpr int k_cases = 100'000;
  for ([[maybe_unused]] const std::uint64_t i : property::in_turn(k_cases)) {
    if (HasFailure()) break;
    const Spheres spheres = random_spheres(dice);
    const Case& made = spheres.made;
    const ImpactOutput out = sphere_impact(spheres.input);
    ASSERT_NE(out.regime, ImpactRegime::separating);
    EXPECT_LE(relative_gain(made, out), 1e-14L);

    const Real3 n = real(made.normal);
    const Real scale = contact_speed_scale(made, made.a.twist, made.b.twist) +
                       contact_speed_scale(made, out.a, out.b);
    const Real3 v = contact_velocity(made, made.a.twist, made.b.twist);
    const Real3 after = contact_velocity(made, out.a, out.b);
    EXPECT_GE(dot(after, n), -8 * k_epsilon * scale);
    if (made.law.separation_speed_floor_mps == 0) {
      expect_near(dot(after, n), -made.law.restitution * dot(v, n), 8 * k_epsilon * scale);
    }

    const Real3 p = real(out.impulse_ns);
    const Real along = dot(p, n);
    const Real across = norm(p - along * n);
    EXPECT_LE(across, made.law.friction * along * (1 + 1e-12L) + 8 * k_epsilon * norm(p));
    if (out.regime == ImpactRegime::sticking) {
      ++sticking;
      EXPECT_LE(norm(after - dot(after, n) * n), 64 * k_epsilon * scale);
    } else {
      // The sphere continues to slide in the same direction.
      expect_near(across, made.law.friction * along,
                  1e-12L * made.law.friction * along + 8 * k_epsilon * norm(p));
      EXPECT_GE(dot(after - dot(after, n) * n, v - dot(v, n) * n), -64 * k_epsilon * scale * scale);
    }
    if (made.law.friction == 0) {
      EXPECT_EQ(out.a.angular_velocity_radps, made.a.twist.angular_velocity_radps);
      EXPECT_EQ(out.b.angular_velocity_radps, made.b.twist.angular_velocity_radps);
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(sticking, k_cases / 20);
  EXPECT_LT(sticking, k_cases * 19 / 20);
}

TEST(SphereImpact, FloorIsReachedIfSomeonePays) {
  // Goal: a slow impact is raised to the separation speed v_c only as far as the energy of the slip
  // allows. Method: let a ball hit the floor at 1 mm/s with v_c = 10 mm/s. With a slip of 1 m/s,
  // the ball leaves at v_c. Without slip, the ball leaves at its approach speed. If the slip's
  // energy suffices for only a part of v_c, the ball leaves with this part of v_c. The ball's
  // energy then stays constant.
  SphereImpactInput input{.mass_b = solid_sphere_mass(1, 0.01),
                          .law = {.restitution = 0.5, .friction = 0.3}};
  const auto leaves = [&](double slip_mps, double floor_mps) {
    input.b.velocity_mps = Vec3(slip_mps, 0, -1e-3);
    input.law.separation_speed_floor_mps = floor_mps;
    return sphere_impact(input).b.velocity_mps.z();
  };
  EXPECT_NEAR(leaves(1, 0), 0.5e-3, 1e-17);
  EXPECT_NEAR(leaves(1, 1e-2), 1e-2, 1e-16);
  EXPECT_NEAR(leaves(0, 1e-2), 1e-3, 1e-17);
  EXPECT_NEAR(leaves(1, 0.7e-3), 0.7e-3, 1e-17);
  EXPECT_NEAR(leaves(1, 0.3e-3), 0.5e-3, 1e-17);

  // If the slip is 2 mm/s and mu = 0.3, the ball sticks: sticking begins at w = 2 mm/s 2/7 / 0.3 -
  // 1 mm/s = 0.905 mm/s. So w^2 = u^2 + (2/7) slip^2.
  EXPECT_NEAR(leaves(2e-3, 1e-2), std::sqrt(1e-6 + 2.0 / 7 * 4e-6), 1e-17);
  const ImpactOutput out = sphere_impact(input);
  EXPECT_EQ(out.regime, ImpactRegime::sticking);
  Case made;
  made.b.inertia = {.mass_kg = 1, .principal_kgm2 = Vec3::Constant(0.4e-4)};
  made.b.twist = input.b;
  expect_near(relative_gain(made, out), 0, 1e-15L);

  // With mu = 0.01 the ball slides: kappa = (u + w) c, c = mu / (2/7 slip) = 17.5 s/m, b = 2/7
  // slip^2 = 8/7e-6 J: w = u + 2 c b (1 - u c) / (1 + c^2 b), slightly more than u.
  input.law.friction = 0.01;
  const double w = 1e-3 + 35.0 * 8 / 7e6 * (1 - 0.0175) / (1 + 17.5 * 17.5 * 8 / 7e6);
  EXPECT_NEAR(leaves(2e-3, 1e-2), w, 1e-17);
  expect_near(relative_gain(made, sphere_impact(input)), 0, 1e-15L);
}

}  // namespace sleight::physics::sphere_impact_test
