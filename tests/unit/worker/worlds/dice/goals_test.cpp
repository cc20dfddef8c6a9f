#include "worker/worlds/dice/goals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/random/distributions.h"
#include "tests/support/property.h"
#include "tests/unit/worker/worlds/dice/support.h"

namespace sleight::worlds::dice {
namespace {

constexpr double k_degree_rad = 0.017453292519943295;

Goal goal_of(std::variant<Place, Region, FaceDirection, Turn, Velocity, RestBefore> wanted,
             double sigma = 1, double tolerance = 0.5) {
  return {.wanted = wanted, .sigma = sigma, .tolerance = tolerance};
}

Goal face_up(std::uint32_t face) {
  return goal_of(FaceDirection{.face = face}, 10 * k_degree_rad, 20 * k_degree_rad);
}
Goal yaw_of(std::uint32_t face, double yaw_rad) {
  return goal_of(
      FaceDirection{.face = face, .direction = {std::cos(yaw_rad), std::sin(yaw_rad), 0}},
      5 * k_degree_rad, 10 * k_degree_rad);
}

Views view(const DieView& die, double rest_s = 1) {
  return {.at_end = {die}, .rest_s = {rest_s}, .at_times = {}};
}

double distance(const Goal& goal, const DieView& die, double rest_s = 1) {
  return distance_of(goal, view(die, rest_s), {}, 0);
}

TEST(DiceGoals, MeasureDistances) {
  // Goal: distance_of() measures each sort of goal as goals.h specifies. Method: use poses whose
  // distances are known.
  DieView die{.position_m = {3, 4, 9}};
  EXPECT_EQ(distance(goal_of(Place{.centre_m = {0, 0}}), die), 5);
  EXPECT_EQ(distance(goal_of(Region{.low_m = {0, 0}, .high_m = {3, 5}}), die), 0);
  EXPECT_EQ(distance(goal_of(Region{.low_m = {0, 0}, .high_m = {1, 1}}), die), std::sqrt(13.0));
  EXPECT_EQ(distance(goal_of(RestBefore{.time_s = 0.25}), die), 0.75);
  EXPECT_EQ(distance(goal_of(RestBefore{.time_s = 2}), die), 0);
  die.velocity_mps = {1, 2, 2};
  EXPECT_EQ(distance(goal_of(Velocity{.velocity_mps = {0, 0, 0}}), die), 3);
  die.orientation = math::quaternion_of_rotation_vector({0.3, 0, 0});
  EXPECT_NEAR(distance(face_up(3), die), 0.3, 1e-15);
  EXPECT_NEAR(distance(face_up(1), die), 90 * k_degree_rad, 1e-15);
  EXPECT_NEAR(distance(face_up(4), die), 180 * k_degree_rad - 0.3, 1e-15);
  EXPECT_NEAR(distance(yaw_of(1, 0.2), die), 0.2, 1e-15);
  EXPECT_NEAR(distance(goal_of(Turn{}), die), 0.3, 1e-15);
  // The measure depends on the rotation, not on a quaternion's sign.
  die.orientation =
      Quat(-die.orientation.w(), -die.orientation.x(), -die.orientation.y(), -die.orientation.z());
  EXPECT_NEAR(distance(goal_of(Turn{}), die), 0.3, 1e-15);
}

TEST(DiceGoals, LookAtTheirTimes) {
  // Goal: if a goal has a time, the goal is measured at that time. A goal without a time is
  // measured at the end. Method: for two dice, use three goals with times and one goal without a
  // time.
  std::vector<Goal> goals(4, goal_of(Place{}));
  goals[0].at_s = 2;
  goals[1].at_s = 0.5;
  goals[2].at_s = 2;
  goals[2].die = 1;
  const std::vector<double> times = goal_times(goals);
  EXPECT_EQ(times, (std::vector<double>{0.5, 2}));
  const auto at = [](double x) { return DieView{.position_m = {x, 0, 0}}; };
  const Views views{
      .at_end = {at(9), at(10)}, .rest_s = {1, 1}, .at_times = {at(1), at(2), at(3), at(4)}};
  EXPECT_EQ(distance_of(goals[0], views, times, 0), 3);
  EXPECT_EQ(distance_of(goals[1], views, times, 0), 1);
  EXPECT_EQ(distance_of(goals[2], views, times, 0), 4);
  EXPECT_EQ(distance_of(goals[3], views, times, 0), 9);
}

TEST(DiceGoals, AreGaussianAndMetWithinTolerances) {
  // Goal: log p_c is the sum of -d^2 / (2 sigma^2), and goals are met if each distance d is within
  // its tolerance. Method: use two goals, and move a distance from its tolerance to just beyond it.
  const std::vector<Goal> goals{goal_of(Place{.centre_m = {1, 0}}, 2, 3),
                                goal_of(RestBefore{.time_s = 0}, 0.5, 1)};
  const Judgement near = judge(goals, Numbering::free, view({}, 1), {});
  EXPECT_NEAR(near.log_constraint, -0.125 - 2, 1e-15);
  EXPECT_TRUE(near.all_met);
  EXPECT_EQ(near.distances, (std::vector<double>{1, 1}));
  EXPECT_FALSE(judge(goals, Numbering::free, view({}, 1.1), {}).all_met);
  const Judgement none = judge({}, Numbering::free, view({}), {});
  EXPECT_EQ(none.log_constraint, 0);
  EXPECT_TRUE(none.all_met);
}

TEST(DiceGoals, OneNumberingOfFourOrOneMeetsFaces) {
  // Goal: in each of its 24 orientations, a die can be numbered so that it meets its goals for
  // faces. The judgement uses the smallest such numbering. numberings_that_meet() returns the
  // number of such numberings. Method: turn a die slightly from each orientation. Use goals for no
  // face, for one face, for two faces and for the whole orientation.
  const Quat bit = math::quaternion_of_rotation_vector({0.03, -0.02, 0.04});
  struct Case {
    std::vector<Goal> goals;
    std::uint32_t meet = 0;
  };
  const std::vector<Case> cases{
      {{goal_of(Place{})}, 24},      {{face_up(6)}, 4},
      {{yaw_of(2, 0)}, 4},           {{face_up(6), yaw_of(2, 0)}, 1},
      {{face_up(5), face_up(5)}, 4}, {{goal_of(Turn{}, 5 * k_degree_rad, 10 * k_degree_rad)}, 1}};
  for (const Case& one : cases) {
    EXPECT_EQ(numberings_that_meet(one.goals, 0), one.meet);
    for (std::uint32_t way = 0; way < k_numberings; ++way) {
      const DieView die{.orientation = math::composed(bit, rotation_of_numbering(way))};
      const Judgement judgement = judge(one.goals, Numbering::free, view(die), {});
      EXPECT_TRUE(judgement.all_met);
      std::uint32_t meet = 0;
      std::uint32_t least = k_numberings;
      double sum = 0;
      for (std::uint32_t s = 0; s < k_numberings; ++s) {
        bool all = true;
        double log_p = 0;
        for (const Goal& goal : one.goals) {
          const double d = distance_of(goal, view(die), {}, s);
          all = all && d <= goal.tolerance;
          log_p -= d * d / (2 * goal.sigma * goal.sigma);
        }
        sum += std::exp(log_p) / 24;
        if (!all) continue;
        ++meet;
        least = std::min(least, s);
      }
      EXPECT_EQ(meet, one.meet);
      EXPECT_EQ(judgement.numberings[0], least);
      EXPECT_NEAR(judgement.log_constraint, std::log(sum), 1e-12);
    }
  }
}

TEST(DiceGoals, WhatOneThrowMeetsIsNoContradiction) {
  // Goal: contradiction_of() accepts goals that one throw can meet. Method: use random dice and
  // pairs of random goals. The goals' tolerances are barely wide enough for the dice.
  constexpr double k_side_m = 0.016;
  for (const std::uint64_t draw : property::cases(2000)) {
    random::Stream stream = testing::stream_of(6, draw);
    const auto number = [&](double low, double high) {
      return random::Uniform(low, high).draw(stream);
    };
    const auto somewhere = [&](double reach) {
      return Vec3(number(-reach, reach), number(-reach, reach), number(-reach, reach));
    };
    DieView die{.position_m = somewhere(0.1),
                .orientation = random::UniformRotation{}.draw(stream),
                .velocity_mps = somewhere(2)};
    const auto turned = [&] {
      return math::composed(math::quaternion_of_rotation_vector(somewhere(0.3)), die.orientation);
    };
    const auto goal = [&](int sort) -> Goal {
      const Vec3 centre_m = die.position_m + somewhere(0.004);
      const Vec2 place_m(centre_m.x(), centre_m.y());
      const auto face = static_cast<std::uint32_t>(number(1, 6.999));
      switch (sort) {
        case 0:
          return goal_of(Place{.centre_m = place_m});
        case 1:
          return goal_of(Region{.low_m = place_m, .high_m = place_m + Vec2(0.01, 0.02)});
        case 2:
          return goal_of(FaceDirection{
              .face = face,
              .direction =
                  math::rotated(turned(), testing::vector_of(direction_of_face(face, 0)))});
        case 3:
          return goal_of(Turn{turned()});
        default:
          return goal_of(Velocity{die.velocity_mps + somewhere(0.1)});
      }
    };
    const auto first = static_cast<int>(number(0, 4.999));
    Goal a = goal(first);
    Goal b = goal(number(0, 1) < 0.5 ? first : static_cast<int>(number(0, 4.999)));
    for (Goal* one : {&a, &b})
      one->tolerance = distance(*one, die) * (1 + 1e-9) + 1e-12;
    EXPECT_EQ(contradiction_of(a, b, k_side_m), "");
    const Vec3 away(k_side_m * std::cos(number(0, 6.3)), k_side_m, 0);
    if (first > 1) continue;
    die.position_m += away;
    Goal other = goal(first);
    other.tolerance = distance(other, die) * (1 + 1e-9) + 1e-12;
    other.die = 1;
    EXPECT_EQ(contradiction_of(a, other, k_side_m), "");
  }
}

TEST(DiceGoals, MarginalsAreDirectSums) {
  // Goal: with free numbering, log p_c sums over each die's numberings, whatever the die's
  // orientation. Method: compare with direct sums of long doubles, for two dice in random
  // orientations.
  std::vector<Goal> goals{face_up(2), yaw_of(1, 0.4), face_up(6)};
  goals[2].die = 1;
  for (const std::uint64_t draw : property::cases(200)) {
    random::Stream stream = testing::stream_of(5, draw);
    Views views{.at_end = {}, .rest_s = {1, 1}, .at_times = {}};
    for (int die = 0; die < 2; ++die)
      views.at_end.push_back({.orientation = random::UniformRotation{}.draw(stream)});
    long double log_p = 0;
    for (std::uint32_t die = 0; die < 2; ++die) {
      long double sum = 0;
      for (std::uint32_t s = 0; s < k_numberings; ++s) {
        long double exponent = 0;
        for (const Goal& goal : goals) {
          if (goal.die != die) continue;
          const long double z = distance_of(goal, views, {}, s) / goal.sigma;
          exponent -= z * z / 2;
        }
        sum += std::exp(exponent) / 24;
      }
      log_p += std::log(sum);
    }
    const Judgement judgement = judge(goals, Numbering::free, views, {});
    EXPECT_NEAR(judgement.log_constraint, static_cast<double>(log_p),
                1e-12 * (1 + std::fabs(static_cast<double>(log_p))));
    EXPECT_LE(judgement.log_constraint, 0);
    // With fixed numbering, the sum has only one term.
    double fixed = 0;
    for (const Goal& goal : goals) {
      const double z = distance_of(goal, views, {}, 0) / goal.sigma;
      fixed -= z * z / 2;
    }
    EXPECT_NEAR(judge(goals, Numbering::fixed, views, {}).log_constraint, fixed,
                1e-12 * std::fabs(fixed));
  }
}

}  // namespace
}  // namespace sleight::worlds::dice
