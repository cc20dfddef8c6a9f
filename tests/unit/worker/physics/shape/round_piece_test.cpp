#include "worker/physics/shape/round_piece.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "common/random/angular_distributions.h"
#include "common/random/distributions.h"
#include "common/random/stream.h"
#include "worker/physics/shape/round_solids.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

using std::numbers::pi;

class Dice {
 public:
  explicit Dice(std::uint64_t n)
      : stream_({.seed = 20'261'128, .purpose = random::Purpose::prior}, n) {}
  double uniform(double low, double high) { return low + (high - low) * stream_.uniform(); }
  Vec3 direction() { return random::UniformDirection3{}.draw(stream_); }
  std::size_t below(std::size_t count) {
    return static_cast<std::size_t>(stream_.uniform() * static_cast<double>(count));
  }

 private:
  random::Stream stream_;
};

/// Some rings about a random axis. If `balls` is set, also some balls.
RoundDescription random_description(Dice& dice, bool balls) {
  RoundDescription description{.origin_m = dice.uniform(0, 0.1) * dice.direction(),
                               .axis = dice.direction(),
                               .rings = {},
                               .balls = {}};
  for (std::size_t i = 1 + dice.below(6); i > 0; --i) {
    description.rings.push_back({.height_m = dice.uniform(-0.1, 0.1),
                                 .circle_m = dice.below(3) == 0 ? 0 : dice.uniform(0, 0.1),
                                 .radius_m = dice.uniform(0.001, 0.05)});
  }
  for (std::size_t i = balls ? 1 + dice.below(4) : 0; i > 0; --i) {
    description.balls.push_back({.centre_m = dice.uniform(0, 0.1) * dice.direction(),
                                 .radius_m = dice.uniform(0.001, 0.05)});
  }
  return description;
}

TEST(RoundPiece, ReachesAsFarAsItsPoints) {
  // Goal: reach_m() is the reach of the piece's furthest point in any direction. Method: compare
  // the reach with the furthest of many points on the rings' circles.
  for (std::uint64_t n = 0; n < 200; ++n) {
    Dice dice(n);
    const RoundDescription description = random_description(dice, n % 2 == 0);
    const RoundPiece piece = RoundPiece::make(description).value();
    const Vec3 u = dice.direction();
    const Vec3 first = math::normalized(
        math::cross(description.axis, std::fabs(description.axis.x()) < 0.9 ? Vec3(Vec3::UnitX())
                                                                            : Vec3(Vec3::UnitY())));
    const Vec3 second = math::cross(description.axis, first);
    double most_m = -1;
    for (const RoundRing& ring : description.rings) {
      for (int i = 0; i < 20'000; ++i) {
        const double angle = 2 * pi * i / 20'000;
        const Vec3 at = description.origin_m + ring.height_m * description.axis +
                        ring.circle_m * (std::cos(angle) * first + std::sin(angle) * second);
        most_m = std::max(most_m, math::dot(at, u) + ring.radius_m);
      }
    }
    for (const RoundBall& ball : description.balls)
      most_m = std::max(most_m, math::dot(ball.centre_m, u) + ball.radius_m);
    ASSERT_NEAR(piece.reach_m(u), most_m, 1e-8) << n;
    ASSERT_LE(piece.reach_m(u), piece.r_outer_m() * (1 + 1e-12)) << n;
  }
}

TEST(RoundPiece, HasTheProfileOfItsHull) {
  // Goal: radius_at_m() and the normals of straight parts are right. Method: use random pieces of
  // revolution and many directions. For each direction, compute the largest radius that the reach
  // allows at a height. The least of these radii must equal radius_at_m(). Along the normal of a
  // straight part, two rings must share the greatest reach, unless the part is an end.
  for (std::uint64_t n = 0; n < 200; ++n) {
    Dice dice(n);
    const RoundDescription description = random_description(dice, false);
    const RoundPiece piece = RoundPiece::make(description).value();
    ASSERT_TRUE(piece.of_revolution());
    const auto reach_m = [&](double across, double along) {
      double most_m = -1;
      for (const RoundRing& ring : description.rings)
        most_m = std::max(most_m, across * ring.circle_m + along * ring.height_m + ring.radius_m);
      return most_m;
    };
    const double top_m = reach_m(0, 1);
    const double bottom_m = -reach_m(0, -1);
    for (int i = 0; i < 20; ++i) {
      const double height_m = bottom_m + (top_m - bottom_m) * dice.uniform(0.02, 0.98);
      const auto allowed_m = [&](double angle) {
        const double along = std::cos(angle);
        return (reach_m(std::sin(angle), along) - along * height_m) / std::sin(angle);
      };
      double best = 0.5;
      for (int k = 1; k < 2000; ++k) {
        if (allowed_m(pi * k / 2000) < allowed_m(best)) best = pi * k / 2000;
      }
      for (double step = 1e-3; step > 1e-10; step *= 0.5) {
        for (const double other : {best - step, best + step}) {
          if (other > 0 && other < pi && allowed_m(other) < allowed_m(best)) best = other;
        }
      }
      const double least_m = allowed_m(best);
      ASSERT_NEAR(piece.radius_at_m(height_m), least_m, 1e-6) << n;
    }
    ASSERT_EQ(piece.radius_at_m(top_m + 1e-6), 0);
    ASSERT_EQ(piece.radius_at_m(bottom_m - 1e-6), 0);
    for (const ProfileNormal& flat : piece.flats()) {
      ASSERT_NEAR(std::hypot(flat.across, flat.along), 1, 1e-12);
      int touching = flat.across < 1e-12 ? 1 : 0;
      for (const RoundRing& ring : description.rings) {
        const double own_m =
            flat.across * ring.circle_m + flat.along * ring.height_m + ring.radius_m;
        touching += reach_m(flat.across, flat.along) - own_m < 1e-12 ? 1 : 0;
      }
      ASSERT_GE(touching, 2) << n;
    }
  }
}

TEST(RoundPiece, WhatAnotherFeatureHoldsIsLeftOut) {
  // Goal: a ring's disc that is inside another disc doesn't change the profile, even if it touches
  // the other disc from inside. Method: test all pairs of rings whose sizes are small whole numbers
  // of millimetres. The profile's arcs must reach as far as both rings.
  for (int n = 0; n < 6 * 5 * 4 * 6 * 5 * 4; ++n) {
    const auto ring_of = [](int i) {
      return RoundRing{.height_m = 1e-3 * (i % 6),
                       .circle_m = 1e-3 * (i / 6 % 5),
                       .radius_m = 1e-3 * (1 + i / 30 % 4)};
    };
    const RoundRing rings[] = {ring_of(n % 120), ring_of(n / 120)};
    const RoundPiece piece = RoundPiece::make({.rings = {rings[0], rings[1]}, .balls = {}}).value();
    for (int k = 0; k <= 24; ++k) {
      const double across = std::sin(pi * k / 24);
      const double along = std::cos(pi * k / 24);
      double most_m = -1;
      for (const RoundRing& ring : rings)
        most_m = std::max(most_m, across * ring.circle_m + along * ring.height_m + ring.radius_m);
      double arcs_m = -1;
      for (const ProfileArc& arc : piece.arcs()) {
        const RoundFeature& one = piece.features()[arc.feature];
        arcs_m = std::max(arcs_m, across * one.circle_m + along * one.height_m + one.radius_m);
      }
      ASSERT_NEAR(arcs_m, most_m, 1e-13) << n;
    }
  }
}

TEST(RoundPiece, RefusesWhatIsNone) {
  // Goal: an invalid description of a piece gives an error of the right kind.
  using Kind = ShapeError::Kind;
  const auto kind_of = [](const RoundDescription& description) {
    const auto made = RoundPiece::make(description);
    return made ? std::optional<Kind>() : made.error().kind;
  };
  const RoundRing good{.height_m = 0, .circle_m = 0.1, .radius_m = 0.01};
  EXPECT_EQ(kind_of({.rings = {good}, .balls = {}}), std::nullopt);
  EXPECT_EQ(kind_of({.rings = {}, .balls = {}}), Kind::no_parts);
  EXPECT_EQ(kind_of({.rings = std::vector<RoundRing>(65, good), .balls = {}}),
            Kind::too_many_features);
  EXPECT_EQ(kind_of({.axis = {0, 0, 2}, .rings = {good}, .balls = {}}), Kind::no_axis);
  RoundRing bad = good;
  bad.radius_m = 0;
  EXPECT_EQ(kind_of({.rings = {good, bad}, .balls = {}}), Kind::dimension_not_positive);
  bad = good;
  bad.circle_m = -0.1;
  EXPECT_EQ(kind_of({.rings = {bad}, .balls = {}}), Kind::dimension_not_positive);
  bad = good;
  bad.height_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(kind_of({.rings = {bad}, .balls = {}}), Kind::not_finite);
  bad = good;
  bad.radius_m = 1e-6;
  EXPECT_EQ(kind_of({.rings = {good, bad}, .balls = {}}), Kind::sharp);
  EXPECT_EQ(kind_of({.rings = {}, .balls = {{.centre_m = {0, 0, 0}, .radius_m = -1}}}),
            Kind::dimension_not_positive);
}

TEST(RoundSolids, HaveTheMassesOfTheTextbooks) {
  // Goal: the masses, centres of mass and moments of inertia of round solids are right. Method:
  // compare capsules, balls and rounded boxes with closed forms. Compare slightly rounded
  // cylinders, cones and boxes with the closed forms of sharp solids.
  const double rho = 1000;
  {
    const double r = 0.03;
    const double l = 0.08;
    const RoundSolid solid = capsule(r, l, rho).value();
    const double m_tube = rho * pi * r * r * l;
    const double m_ball = rho * 4 / 3 * pi * r * r * r;
    EXPECT_NEAR(solid.inertia.mass_kg, m_tube + m_ball, 1e-10);
    EXPECT_NEAR(solid.inertia.principal_kgm2.z(), 0.5 * m_tube * r * r + 0.4 * m_ball * r * r,
                1e-13);
    // Each cap is half a ball, with its centre of mass 3/8 r beyond the tube's end.
    const double across =
        m_tube * (r * r / 4 + l * l / 12) + m_ball * (0.4 * r * r + l * l / 4 + 0.375 * l * r);
    EXPECT_NEAR(solid.inertia.principal_kgm2.x(), across, 1e-12);
    EXPECT_NEAR(solid.foot_m, l / 2 + r, 1e-12);
  }
  {
    const RoundSolid solid = cylinder(0.05, 0.2, 1e-4, rho).value();
    const double m = rho * pi * 0.05 * 0.05 * 0.2;
    EXPECT_NEAR(solid.inertia.mass_kg / m, 1, 1e-5);
    EXPECT_NEAR(solid.inertia.principal_kgm2.z() / (0.5 * m * 0.05 * 0.05), 1, 1e-5);
    EXPECT_NEAR(solid.inertia.principal_kgm2.x() / (m * (0.05 * 0.05 / 4 + 0.04 / 12)), 1, 1e-5);
  }
  {
    const RoundSolid solid = cone(0.05, 0.12, 1e-4, rho).value();
    const double m = rho * pi * 0.05 * 0.05 * 0.12 / 3;
    EXPECT_NEAR(solid.inertia.mass_kg / m, 1, 0.01);
    EXPECT_NEAR(solid.foot_m, 0.03, 3e-4);
    EXPECT_NEAR(solid.inertia.principal_kgm2.z() / (0.3 * m * 0.05 * 0.05), 1, 0.01);
    EXPECT_NEAR(
        solid.inertia.principal_kgm2.x() / (m * (0.15 * 0.05 * 0.05 + 0.0375 * 0.12 * 0.12)), 1,
        0.02);
  }
  {
    const RoundSolid ball = rounded_box({0.1, 0.1, 0.1}, 0.05, rho).value();
    const double m = rho * 4 / 3 * pi * 0.05 * 0.05 * 0.05;
    EXPECT_NEAR(ball.inertia.mass_kg / m, 1, 1e-9);
    EXPECT_NEAR(ball.inertia.principal_kgm2.x() / (0.4 * m * 0.05 * 0.05), 1, 1e-9);
    EXPECT_EQ(ball.inertia.symmetry, InertiaSymmetry::spherical);
  }
  {
    // Steiner's formula. Moments approach the box's moments.
    const RoundSolid solid = rounded_box({0.1, 0.06, 0.04}, 0.01, rho).value();
    const double a = 0.08;
    const double b = 0.04;
    const double c = 0.02;
    const double e = 0.01;
    const double volume = a * b * c + 2 * e * (a * b + b * c + c * a) + pi * e * e * (a + b + c) +
                          4 * pi / 3 * e * e * e;
    EXPECT_NEAR(solid.inertia.mass_kg / (rho * volume), 1, 1e-9);
    const RoundSolid sharp = rounded_box({0.1, 0.06, 0.04}, 2e-5, rho).value();
    const double m = rho * 0.1 * 0.06 * 0.04;
    EXPECT_NEAR(sharp.inertia.principal_kgm2.x() / (m * (0.06 * 0.06 + 0.04 * 0.04) / 12), 1, 1e-5);
    EXPECT_NEAR(sharp.inertia.principal_kgm2.z() / (m * (0.1 * 0.1 + 0.06 * 0.06) / 12), 1, 1e-5);
  }
  EXPECT_EQ(cylinder(0.05, 0, 0.001, rho).error().index, 1U);
  EXPECT_EQ(cylinder(0.05, 0.1, 0.06, rho).error().index, 2U);
  EXPECT_EQ(rounded_box({0.1, 0.1, 0.01}, 0.006, rho).error().index, 3U);
  EXPECT_EQ(coin(0.01, -1, rho).error().index, 1U);
}

TEST(RoundSolids, AHullReachesAsFarAsTheParts) {
  // Goal: the hull of a compound reaches as far as its parts in every direction. Compounds without
  // a common axis, single parts and polyhedra have no hull. Method: test a bowling pin in random
  // directions.
  const Compound pin{.parts = {}, .round_parts = bowling_pin(1.55).value().parts};
  const auto hull = hull_of(pin);
  ASSERT_TRUE(hull.has_value());
  Dice dice(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 u = dice.direction();
    double most_m = -1;
    for (const RoundPiece& part : pin.round_parts)
      most_m = std::max(most_m, part.reach_m(u));
    ASSERT_NEAR(hull->reach_m(u), most_m, 1e-15);
  }
  Compound bent = pin;
  bent.round_parts.push_back(
      RoundPiece::make({.axis = {1, 0, 0},
                        .rings = {{.height_m = 0, .circle_m = 0.01, .radius_m = 0.01}},
                        .balls = {}})
          .value());
  EXPECT_FALSE(hull_of(bent).has_value());
  EXPECT_FALSE(hull_of({.parts = {}, .round_parts = {pin.round_parts.front()}}).has_value());
  EXPECT_FALSE(hull_of({.parts = {cube(1).value()}}).has_value());
}

TEST(RoundSolids, ThePinIsThatOfTheRules) {
  // Goal: a bowling pin of 1.55 kg has the right shape to 0.4 mm. The pin's centre of mass is at
  // 147.2 mm, and the moments of inertia are 0.00193 and 0.0131 kg m^2. Method: compare the profile
  // with the specification's diameters and the spline through them.
  const RoundSolid pin = bowling_pin(1.55).value();
  EXPECT_NEAR(pin.foot_m, 0.1472, 2e-4);
  EXPECT_NEAR(pin.inertia.principal_kgm2.z(), 0.00193, 0.00001);
  EXPECT_NEAR(pin.inertia.principal_kgm2.x(), 0.0131, 0.0001);
  const auto radius_m = [&](double height_m) {
    double widest_m = 0;
    for (const RoundPiece& part : pin.parts)
      widest_m = std::max(widest_m, part.radius_at_m(height_m - pin.foot_m));
    return widest_m;
  };
  double worst_m = 0;
  for (double height_m = 5.0 / 32 * 0.0254; height_m < 15 * 0.0254 - 2e-3; height_m += 1e-4) {
    const double off_m = std::fabs(radius_m(height_m) - bowling_pin_radius_m(height_m));
    worst_m = std::max(worst_m, off_m);
  }
  RecordProperty("worst_um", static_cast<int>(1e6 * worst_m));
  EXPECT_LT(worst_m, 4e-4);
  const double inch_m = 0.0254;
  EXPECT_NEAR(2 * radius_m(4.5 * inch_m), 4.766 * inch_m, 2e-5);
  EXPECT_NEAR(2 * radius_m(13.5 * inch_m), 2.547 * inch_m, 2e-4);
  EXPECT_NEAR(2 * radius_m(10 * inch_m), 1.797 * inch_m, 8e-4);
  EXPECT_NEAR(bowling_pin_radius_m(7.25 * inch_m), 0.5 * 3.703 * inch_m, 1e-9);
}

}  // namespace
}  // namespace sleight::physics
