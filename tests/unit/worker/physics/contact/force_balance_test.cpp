#include "worker/physics/contact/force_balance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "common/math/vector.h"
#include "common/random/stream.h"
#include "tests/support/property.h"
#include "worker/physics/contact/resting.h"

namespace sleight::physics {
namespace {

using std::numbers::pi;

constexpr double k_g_mps2 = 9.81;

/// Bodies given by their centres, and the contacts that support them.
struct Structure {
  std::vector<Vec3> centres_m;
  std::vector<HeldBody> bodies;
  std::vector<HoldingContact> contacts;

  std::uint32_t add(const Vec3& centre_m, double mass_kg, double reach_m,
                    const Vec3& down = -Vec3::UnitZ()) {
    centres_m.push_back(centre_m);
    bodies.push_back({.weight_n = mass_kg * k_g_mps2 * down, .reach_m = reach_m});
    return static_cast<std::uint32_t>(bodies.size() - 1);
  }
  void touch(std::uint32_t body, std::uint32_t partner, const Vec3& normal, const Vec3& place_m,
             double friction) {
    HoldingContact contact{.body = body,
                           .partner = partner,
                           .friction = friction,
                           .normal = normal,
                           .arm_m = place_m - centres_m[body]};
    if (partner != HoldingContact::k_fixed) contact.partner_arm_m = place_m - centres_m[partner];
    contacts.push_back(contact);
  }
  void touch_level(std::uint32_t body, std::uint32_t partner, double x0, double x1, double y,
                   double z, double friction) {
    for (const double place_x : {x0, x1}) {
      for (const double place_y : {-y, y})
        touch(body, partner, Vec3::UnitZ(), {place_x, place_y, z}, friction);
    }
  }
  bool holds() const { return ForceBalance().holds(bodies, contacts); }
};

TEST(ForceBalance, ABlockOnASlopeHoldsUpToTheAngleOfFriction) {
  // Goal: a block stays on a slope exactly if tan(angle) <= mu. The limit's error is below 0.3
  // degrees. The direction of the slope doesn't matter, because friction cones are round. Method:
  // test angles 0.3 degrees below and above the limit in twelve directions.
  for (const double friction : {0.2, 0.7}) {
    for (int i = 0; i < 12; ++i) {
      for (const double off : {-0.3, 0.3}) {
        const double angle = std::atan(friction) + off * pi / 180;
        const Vec3 down(std::sin(angle) * std::cos(0.5 * i), std::sin(angle) * std::sin(0.5 * i),
                        -std::cos(angle));
        Structure block;
        block.add({0, 0, 0.01}, 1, 0.15, down);
        block.touch_level(0, HoldingContact::k_fixed, -0.1, 0.1, 0.1, 0, friction);
        EXPECT_EQ(block.holds(), off < 0) << friction << " " << i;
      }
    }
  }
}

/// Blocks of width 1. Each block is shifted by `step` from the block below.
Structure overhanging(int count, double step) {
  Structure stack;
  for (int i = 0; i < count; ++i) {
    const auto block = stack.add({step * i, 0, 0.25 + 0.5 * i}, 1, 0.7);
    const bool lowest = i == 0;
    stack.touch_level(block, lowest ? HoldingContact::k_fixed : block - 1,
                      lowest ? -0.5 : step * i - 0.5, lowest ? 0.5 : step * (i - 1) + 0.5, 0.5,
                      0.5 * i, 0.5);
  }
  return stack;
}

TEST(ForceBalance, FourBlocksStandAtAFifthAndFallAtThreeTenths) {
  // Goal: a stack of shifted blocks can fall although each block alone would stand on the block
  // below. The upper n blocks have a common centre, which is (n + 1) / 2 steps beyond the centre of
  // the block below. So four blocks stand if the step is at most a quarter of a block's width.
  // Method: test steps slightly and clearly below this limit, and slightly and clearly above it.
  // For twenty blocks, also test steps on both sides of the limit.
  EXPECT_TRUE(overhanging(4, 0.2).holds());
  EXPECT_FALSE(overhanging(4, 0.3).holds());
  EXPECT_TRUE(overhanging(4, 0.245).holds());
  EXPECT_FALSE(overhanging(4, 0.255).holds());
  EXPECT_TRUE(overhanging(20, 0.049).holds());
  EXPECT_FALSE(overhanging(20, 0.051).holds());
}

TEST(ForceBalance, ABallOnTwoNeedsTheirFriction) {
  // Goal: a ball on two touching balls stays if friction at the floor and between balls is at least
  // tan 15 degrees. Method: test friction slightly below and slightly above this limit.
  for (const double friction : {0.258, 0.278}) {
    Structure three;
    for (const double x : {-0.5, 0.5}) {
      const auto ball = three.add({x, 0, 0.5}, 1, 0.5);
      three.touch(ball, HoldingContact::k_fixed, Vec3::UnitZ(), {x, 0, 0}, friction);
    }
    const auto top = three.add({0, 0, 0.5 + std::sqrt(0.75)}, 1, 0.5);
    for (const std::uint32_t under : {0U, 1U}) {
      const Vec3 normal = three.centres_m[top] - three.centres_m[under];
      three.touch(top, under, normal, 0.5 * (three.centres_m[top] + three.centres_m[under]),
                  friction);
    }
    EXPECT_EQ(three.holds(), friction > std::tan(pi / 12)) << friction;
  }
}

/// Stones in a semicircle of mean radius 1.
Structure arch(int count, double thickness, double friction) {
  Structure stones;
  const double inner = 1 - 0.5 * thickness;
  const double outer = 1 + 0.5 * thickness;
  const double half = 0.5 * pi / count;
  const double centre = 2.0 / 3 * (std::pow(outer, 3) - std::pow(inner, 3)) /
                        (outer * outer - inner * inner) * std::sin(half) / half;
  for (int i = 0; i <= count; ++i) {
    const double middle = (2 * i + 1) * half;
    if (i < count) stones.add({centre * std::cos(middle), 0, centre * std::sin(middle)}, 1, 0.15);
    // The joint below stone i. The last joint is at the ground on the other side.
    const double angle = 2 * i * half;
    const Vec3 normal(-std::sin(angle), 0, std::cos(angle));
    const auto body = static_cast<std::uint32_t>(i < count ? i : count - 1);
    const bool last = i == count;
    const std::uint32_t partner =
        i == 0 || last ? HoldingContact::k_fixed : static_cast<std::uint32_t>(i - 1);
    for (const double r : {inner, outer}) {
      for (const double y : {-0.1, 0.1})
        stones.touch(body, partner, last ? Vec3(-normal) : normal,
                     {r * std::cos(angle), y, r * std::sin(angle)}, friction);
    }
  }
  return stones;
}

TEST(ForceBalance, AnArchStandsDownToItsLeastThickness) {
  // Goal: a semicircular arch of 15 stones stands if its thickness is 0.13 radii, and falls if its
  // thickness is 0.09 radii. The friction is 0.7. If joints may be anywhere, the limit is 0.1075
  // radii (Heyman, International Journal of Solids and Structures 5, 1969, as corrected by
  // Milankovitch). Method: test both thicknesses. Then use a bisection to find the thickness at
  // which the verdict changes.
  EXPECT_TRUE(arch(15, 0.13, 0.7).holds());
  EXPECT_FALSE(arch(15, 0.09, 0.7).holds());
  EXPECT_FALSE(arch(15, 0.13, 0.1).holds());
  double falls = 0.09;
  double stands = 0.13;
  while (stands - falls > 2e-4) {
    const double middle = 0.5 * (falls + stands);
    (arch(15, middle, 0.7).holds() ? stands : falls) = middle;
  }
  std::printf("an arch of 15 stones stands from %.4f on\n", stands);
  EXPECT_NEAR(stands, 0.1075, 0.006);
}

/// Returns the least imbalance that remains. Uses plain projected gradient steps, which are slow
/// but reliable.
double left_by_descent(const Structure& structure) {
  const std::size_t n = structure.bodies.size();
  std::vector<Vec3> forces(structure.contacts.size(), Vec3::Zero());
  std::vector<Vec3> push(n);
  std::vector<Vec3> turn(n);
  double left = 0;
  for (int round = 0; round < 40'000; ++round) {
    for (std::size_t b = 0; b < n; ++b) {
      push[b] = structure.bodies[b].weight_n;
      turn[b] = Vec3::Zero();
    }
    const auto sides = [&](std::size_t c, const auto& visit) {
      const HoldingContact& contact = structure.contacts[c];
      visit(contact.body, 1.0, contact.arm_m / structure.bodies[contact.body].reach_m);
      if (contact.partner != HoldingContact::k_fixed)
        visit(contact.partner, -1.0,
              contact.partner_arm_m / structure.bodies[contact.partner].reach_m);
    };
    for (std::size_t c = 0; c < forces.size(); ++c) {
      sides(c, [&](std::uint32_t b, double sign, const Vec3& lever) {
        push[b] += sign * forces[c];
        turn[b] += sign * math::cross(lever, forces[c]);
      });
    }
    left = 0;
    for (std::size_t b = 0; b < n; ++b)
      left += math::dot(push[b], push[b]) + math::dot(turn[b], turn[b]);
    for (std::size_t c = 0; c < forces.size(); ++c) {
      Vec3 slope = Vec3::Zero();
      sides(c, [&](std::uint32_t b, double sign, const Vec3& lever) {
        slope += sign * (push[b] + math::cross(turn[b], lever));
      });
      Vec3 force = forces[c] - 0.02 * slope;
      const HoldingContact& contact = structure.contacts[c];
      const double mu = contact.friction;
      const double along = math::dot(force, contact.normal);
      const Vec3 across = force - along * contact.normal;
      const double size = math::norm(across);
      if (size > mu * along) {
        const double load = std::max(0.0, (along + mu * size) / (1 + mu * mu));
        force = load * contact.normal;
        if (size > 0) force += (mu * load / size) * across;
      }
      forces[c] = force;
    }
  }
  return std::sqrt(left) / k_g_mps2;
}

TEST(ForceBalance, AgreesWithASlowSearch) {
  // Goal: the verdict is right for any contacts of up to three bodies. Method: for random contacts,
  // compare the verdict with the result of a plain gradient descent. Use only cases in which the
  // descent leaves an imbalance that is almost zero or large.
  int held = 0;
  int fell = 0;
  for (const std::uint64_t seed : property::cases(property::long_run() ? 2'000 : 40)) {
    random::Stream stream({.seed = seed, .purpose = random::Purpose::prior}, 0);
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * stream.uniform();
    };
    Structure any;
    const int count = 1 + static_cast<int>(seed % 3);
    for (int b = 0; b < count; ++b) {
      any.add({uniform(-1, 1), uniform(-1, 1), 1.0 * b}, uniform(0.5, 2), 1);
      const int touches = 3 + static_cast<int>(uniform(0, 4));
      for (int i = 0; i < touches; ++i) {
        const Vec3 normal =
            math::normalized(Vec3(uniform(-0.5, 0.5), uniform(-0.5, 0.5), uniform(0.5, 1)));
        const Vec3 place = any.centres_m.back() + Vec3(uniform(-1, 1), uniform(-1, 1), -0.5);
        const auto body = static_cast<std::uint32_t>(b);
        any.touch(body, b > 0 && i % 2 == 0 ? body - 1 : HoldingContact::k_fixed, normal, place,
                  uniform(0, 0.8));
      }
    }
    const double left = left_by_descent(any);
    const bool holds = any.holds();
    if (left < 2e-4) {
      EXPECT_TRUE(holds) << seed << ", " << left << " left";
      ++held;
    } else if (left > 0.05) {
      EXPECT_FALSE(holds) << seed << ", " << left << " left";
      ++fell;
    }
  }
  if (property::all_cases()) {
    EXPECT_GT(held, 2);
    EXPECT_GT(fell, 2);
  }
}

}  // namespace
}  // namespace sleight::physics
