// Impacts with outcomes known from textbooks.
#include <gtest/gtest.h>

#include <cmath>

#include "common/math/angle.h"
#include "common/math/elementary.h"
#include "common/math/rotation.h"
#include "worker/physics/response/rigid_impact.h"
#include "worker/physics/response/sphere_impact.h"

namespace sleight::physics {
namespace {

constexpr double k_mass_kg = 0.8;
constexpr double k_length_m = 1.5;
constexpr double k_fall_mps = 2.0;

/// A thin uniform rod in the xz plane falls onto a static floor. The rod's lower end is at the
/// origin.
RigidImpactInput dropped_rod(double slope_rad, const ContactLaw& law) {
  const double moment = k_mass_kg * k_length_m * k_length_m / 12;
  RigidImpactInput input{.law = law};
  input.b.mass =
      rigid_mass({.mass_kg = k_mass_kg, .principal_kgm2 = {1e-4 * moment, moment, moment}});
  const math::SinCos slope = math::sincos(slope_rad);
  input.b.pose.position_m = 0.5 * k_length_m * Vec3(slope.cos, 0, slope.sin);
  input.b.pose.orientation = math::quaternion_of_rotation_vector(Vec3(0, -slope_rad, 0));
  input.b.twist.velocity_mps = Vec3(0, 0, -k_fall_mps);
  return input;
}

TEST(KnownAnswers, RodDroppedOnItsEnd) {
  // Goal: the end of a rod has the right effective mass. Method: compare the impulse without
  // friction with (1 + e) m v / (1 + 3 cos^2). This impulse follows from the inverse effective
  // mass, 1/m + (l/2 cos)^2 / (m l^2 / 12).
  for (const double slope_rad : {0.0, 0.3, 0.785, 1.2, 0.5 * math::k_pi}) {
    for (const double e : {0.0, 0.6, 1.0}) {
      const ImpactOutput out = rigid_impact(dropped_rod(slope_rad, {.restitution = e}));
      const double c = math::cos(slope_rad);
      const double impulse = (1 + e) * k_mass_kg * k_fall_mps / (1 + 3 * c * c);
      EXPECT_NEAR(out.normal_impulse_ns, impulse, 1e-14);
      EXPECT_NEAR(out.b.velocity_mps.z(), -k_fall_mps + impulse / k_mass_kg, 1e-14);
      EXPECT_NEAR(out.b.velocity_mps.x(), 0, 1e-15);
      // The impulse at the lower end turns the rod about +y.
      EXPECT_NEAR(out.b.angular_velocity_radps.y(), 6 * c * impulse / (k_mass_kg * k_length_m),
                  1e-13);
    }
  }
}

TEST(KnownAnswers, RodThatCatchesItsEnd) {
  // Goal: a plastic impact with high friction stops the rod's end. Method: the impact keeps the
  // angular momentum about the end, so the rod's spin omega must satisfy m v (l/2) cos = (1/3) m
  // l^2 omega.
  for (const double slope_rad : {0.1, 0.3, 0.785, 1.2}) {
    const ImpactOutput out =
        rigid_impact(dropped_rod(slope_rad, {.restitution = 0, .friction = 1e3}));
    EXPECT_EQ(out.regime, ImpactRegime::sticking);
    EXPECT_NEAR(out.b.angular_velocity_radps.y(),
                1.5 * k_fall_mps * math::cos(slope_rad) / k_length_m, 1e-13);
  }
}

TEST(KnownAnswers, SlidingBallGripsTheFloor) {
  // Goal: a solid ball that slides at the speed v without spin leaves the floor at 5/7 v and rolls.
  // A ball that spins without moving along the floor leaves with 2/7 of its rim's speed. Both balls
  // stick only if mu (1 + e) u is at least 2/7 of the slip, where u is the approach speed. Method:
  // test both impacts. Also test friction slightly above and slightly below the limit.
  SphereImpactInput input{.mass_b = solid_sphere_mass(0.17, 0.03),
                          .law = {.restitution = 0.5, .friction = 1}};
  input.b.velocity_mps = Vec3(0.7, 0, -1);
  const ImpactOutput slid = sphere_impact(input);
  EXPECT_EQ(slid.regime, ImpactRegime::sticking);
  EXPECT_NEAR(slid.b.velocity_mps.x(), 0.5, 1e-15);
  EXPECT_NEAR(slid.b.velocity_mps.z(), 0.5, 1e-15);
  EXPECT_NEAR(slid.b.angular_velocity_radps.y() * 0.03, 0.5, 1e-15);

  SphereImpactInput spun = input;
  spun.b.velocity_mps.x() = 0;
  spun.b.angular_velocity_radps = Vec3(0, 0.7 / 0.03, 0);
  const ImpactOutput out = sphere_impact(spun);
  EXPECT_NEAR(out.b.velocity_mps.x(), 0.2, 1e-15);
  EXPECT_NEAR(out.b.angular_velocity_radps.y() * 0.03, 0.2, 1e-15);

  // The border: 2/7 0.7 = 0.2 = mu 1.5.
  input.law.friction = 0.2 / 1.5 * (1 + 1e-12);
  EXPECT_EQ(sphere_impact(input).regime, ImpactRegime::sticking);
  input.law.friction = 0.2 / 1.5 * (1 - 1e-12);
  EXPECT_EQ(sphere_impact(input).regime, ImpactRegime::sliding);
  input.law.friction = 0.1;
  const ImpactOutput slides = sphere_impact(input);
  EXPECT_NEAR(slides.b.velocity_mps.x(), 0.7 - 0.15, 1e-15);
  EXPECT_NEAR(slides.b.angular_velocity_radps.y() * 0.03, 2.5 * 0.15, 1e-15);
}

TEST(KnownAnswers, Billiards) {
  // Goal: two equal billiard balls exchange their velocities in a head-on impact. After a cut shot,
  // the balls separate at a right angle, and the object ball moves along the line of centres.
  // Friction turns the object ball's path by atan(mu) towards the cue ball's slip, and makes the
  // object ball spin.
  SphereImpactInput input{.mass_a = solid_sphere_mass(0.17, 0.03),
                          .mass_b = solid_sphere_mass(0.17, 0.03),
                          .normal = Vec3::UnitX()};
  input.a.velocity_mps = Vec3(2, 0, 0);
  const ImpactOutput straight = sphere_impact(input);
  EXPECT_EQ(straight.a.velocity_mps, Vec3::Zero());
  EXPECT_EQ(straight.b.velocity_mps, Vec3(2, 0, 0));

  input.a.velocity_mps = Vec3(2, 1, 0);
  const ImpactOutput cut = sphere_impact(input);
  EXPECT_EQ(cut.a.velocity_mps, Vec3(0, 1, 0));
  EXPECT_EQ(cut.b.velocity_mps, Vec3(2, 0, 0));

  input.law.friction = 0.06;
  const ImpactOutput thrown = sphere_impact(input);
  EXPECT_EQ(thrown.regime, ImpactRegime::sliding);
  EXPECT_NEAR(thrown.b.velocity_mps.x(), 2, 1e-15);
  EXPECT_NEAR(thrown.b.velocity_mps.y(), 0.12, 1e-15);
  EXPECT_NEAR(thrown.a.velocity_mps.y(), 0.88, 1e-15);
  EXPECT_NEAR(thrown.b.angular_velocity_radps.z() * 0.03, -2.5 * 0.12, 1e-14);
  EXPECT_NEAR(thrown.a.angular_velocity_radps.z() * 0.03, -2.5 * 0.12, 1e-14);
}

TEST(KnownAnswers, BallStopsDeadOnANeedlesEnd) {
  // Goal: if a ball hits the end of a resting rod and the end's effective mass equals the ball's
  // mass, the ball stops. The end leaves at the ball's speed. Method: let a ball of mass m hit the
  // end of a rod of mass 4 m. The end's effective mass is m.
  RigidImpactInput input{.contact_m = Vec3::Zero(), .normal = Vec3::UnitZ()};
  input.a.mass = rigid_mass({.mass_kg = 0.2, .principal_kgm2 = Vec3::Constant(1e-3)});
  input.a.pose.position_m = Vec3(0, 0, -0.1);
  input.a.twist.velocity_mps = Vec3(0, 0, 3);
  input.b.mass = rigid_mass({.mass_kg = 0.8, .principal_kgm2 = {1e-5, 0.15, 0.15}});
  input.b.pose.position_m = Vec3(0.75, 0, 0);
  input.law.friction = 0.5;
  const ImpactOutput out = rigid_impact(input);
  EXPECT_NEAR(out.a.velocity_mps.z(), 0, 1e-14);
  EXPECT_NEAR(out.b.velocity_mps.z(), 0.75, 1e-14);
  EXPECT_NEAR(out.b.velocity_mps.z() + 0.75 * out.b.angular_velocity_radps.y(), 3, 1e-14);
}

}  // namespace
}  // namespace sleight::physics
