#include "worker/worlds/dice/request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "tests/support/facts.h"
#include "worker/worlds/dice/dice.h"

namespace sleight::worlds::dice {
namespace {

using ::testing::HasSubstr;

base::Result<request::DirectionRequest, std::vector<request::Diagnostic>> read(
    const std::string& keys) {
  const std::array worlds{request_binding()};
  return request::read_request("[world]\nname = \"dice\"\n" + keys + "\n[stop]\nscans = 1\n",
                               "r.toml", worlds);
}

Parameters parameters_of(const std::string& keys) {
  const auto request = read(keys);
  EXPECT_TRUE(request.ok()) << (request.ok() ? "" : to_string(request.error().front()));
  return request.ok() ? request::parameters_of<Parameters>(request.value()) : Parameters();
}

/// The first diagnostic. Empty if none.
std::string complaint(const std::string& keys) {
  const auto request = read(keys);
  return request.ok() ? "" : to_string(request.error().front());
}

TEST(DiceRequest, DefaultsAreOneDieWithoutGoals) {
  // Goal: a request without keys has the default parameters.
  Parameters parameters = parameters_of("");
  const Parameters defaults;
  EXPECT_EQ(parameters.world.side_m, defaults.world.side_m);
  EXPECT_EQ(parameters.world.table.height_sd_m, defaults.world.table.height_sd_m);
  EXPECT_EQ(parameters.world.table.restitution.low, 0.5);
  EXPECT_EQ(parameters.proposal.turn_rad, defaults.proposal.turn_rad);
  EXPECT_EQ(parameters.proposal.height_m, defaults.proposal.height_m);
  EXPECT_EQ(parameters.numbering, Numbering::free);
  ASSERT_EQ(parameters.world.dice.size(), 1U);
  EXPECT_EQ(parameters.world.dice[0].position_m, defaults.world.dice[0].position_m);
  EXPECT_EQ(parameters.world.dice[0].position_sd_m, defaults.world.dice[0].position_sd_m);
  EXPECT_TRUE(parameters.goals.empty());
}

TEST(DiceRequest, DiceStandSideBySide) {
  // Goal: a request gives either the number of dice or a [[world.die]] table for each die. Dice
  // without a given place stand side by side.
  const Parameters three = parameters_of("dice = 3");
  ASSERT_EQ(three.world.dice.size(), 3U);
  EXPECT_DOUBLE_EQ(three.world.dice[0].position_m.y(), -k_dice_apart_m);
  EXPECT_DOUBLE_EQ(three.world.dice[2].position_m.y(), k_dice_apart_m);
  const Parameters two = parameters_of(
      "[[world.die]]\ny_mm = 5\nstart_s = 0.5\nspin_x_sd_radps = 0\nspin_x_radps = 3\n"
      "[[world.die]]\norientation = \"fixed\"\nup = 1\nyaw_deg = 90\nheight_sd_mm = 2");
  ASSERT_EQ(two.world.dice.size(), 2U);
  EXPECT_EQ(two.world.dice[0].position_m.y(), 0.005);
  EXPECT_EQ(two.world.dice[0].start_s, 0.5);
  EXPECT_EQ(two.world.dice[0].spin_radps, Vec3(3, 0, 0));
  EXPECT_EQ(two.world.dice[0].spin_sd_radps, Vec3(0, 20, 20));
  EXPECT_DOUBLE_EQ(two.world.dice[1].position_m.y(), 0.5 * k_dice_apart_m);
  EXPECT_EQ(two.world.dice[1].position_sd_m.z(), 0.002);
  EXPECT_EQ(two.world.dice[1].orientation, StartOrientation::fixed);
  const Vec3 up = math::rotated(two.world.dice[1].fixed_orientation, Vec3(1, 0, 0));
  EXPECT_NEAR(up.z(), 1, 1e-12);
}

TEST(DiceRequest, GoalsAreArraysOfTables) {
  // Goal: each sort of goal is read with its units. Reading the normalised text again gives the
  // same text.
  const std::string keys =
      "dice = 2\ntime_max_s = 4\n[constraint]\nnumbering = \"fixed\"\n"
      "[[constraint.place]]\nx_mm = 30\ny_mm = -20\nsigma_mm = 4\ntolerance_mm = 8\nat_s = 1.5\n"
      "[[constraint.region]]\ndie = 2\nx_low_mm = 1\nx_high_mm = 2\ny_low_mm = 3\ny_high_mm = 4\n"
      "[[constraint.face]]\ndie = 2\nup = 2\ntolerance_deg = 30\n"
      "[[constraint.yaw]]\nface = 5\nyaw_deg = 90\n"
      "[[constraint.orientation]]\nqw = 0\nqz = 0.5\n"
      "[[constraint.velocity]]\nz_mps = -1\nat_s = 0.1\n"
      "[[constraint.before]]\ntime_s = 1.25\nsigma_s = 0.5\n";
  const auto request = read(keys);
  ASSERT_TRUE(request.ok()) << to_string(request.error().front());
  const std::vector<Goal> goals = request::parameters_of<Parameters>(request.value()).goals;
  ASSERT_EQ(goals.size(), 7U);
  EXPECT_EQ(std::get<Place>(goals[0].wanted).centre_m, Vec2(0.03, -0.02));
  EXPECT_EQ(goals[0].sigma, 0.004);
  EXPECT_EQ(goals[0].tolerance, 0.008);
  EXPECT_EQ(goals[0].at_s, 1.5);
  EXPECT_EQ(goals[0].die, 0U);
  EXPECT_EQ(std::get<Region>(goals[1].wanted).high_m, Vec2(0.002, 0.004));
  EXPECT_EQ(goals[1].die, 1U);
  EXPECT_EQ(std::get<FaceDirection>(goals[2].wanted).face, 2U);
  EXPECT_EQ(std::get<FaceDirection>(goals[2].wanted).direction, Vec3(0, 0, 1));
  EXPECT_NEAR(goals[2].tolerance, 0.5235987755982988, 1e-15);
  EXPECT_NEAR(std::get<FaceDirection>(goals[3].wanted).direction.y(), 1, 1e-15);
  EXPECT_EQ(std::get<Turn>(goals[4].wanted).orientation.z(), 1);
  EXPECT_EQ(std::get<Velocity>(goals[5].wanted).velocity_mps, Vec3(0, 0, -1));
  EXPECT_EQ(std::get<RestBefore>(goals[6].wanted).time_s, 1.25);
  std::string names;
  for (const Goal& goal : goals)
    names += name_of(goal) + "_" + unit_of(goal) + " ";
  EXPECT_EQ(names, "place_m region_m face_rad yaw_rad orientation_rad velocity_mps before_s ");
  const std::string normal = normalised_text(request.value());
  const std::array worlds{request_binding()};
  const auto reread = request::read_request(normal, "n.toml", worlds);
  ASSERT_TRUE(reread.ok()) << to_string(reread.error().front());
  EXPECT_EQ(normalised_text(reread.value()), normal);
  EXPECT_EQ(request::parameters_of<Parameters>(reread.value()).goals.size(), 7U);
}

TEST(DiceRequest, NormalisedStartsReadBack) {
  // Goal: an archive stores the normalised request. For each way to orient a die, that request
  // gives the same start as the original request.
  for (const std::string start :
       {"x_mm = 1", "orientation = \"uniform\"", "orientation = \"fixed\"",
        "orientation = \"fixed\"\nup = 2\nyaw_deg = 30",
        "orientation = \"fixed\"\nqw = 0.6\nqz = 0.8"}) {
    const auto request = read("[[world.die]]\n" + start);
    ASSERT_TRUE(request.ok()) << start << ": " << to_string(request.error().front());
    const std::array worlds{request_binding()};
    const std::string normal = normalised_text(request.value());
    const auto reread = request::read_request(normal, "n.toml", worlds);
    ASSERT_TRUE(reread.ok()) << start << ": " << to_string(reread.error().front());
    EXPECT_EQ(normalised_text(reread.value()), normal);
    const auto die_of = [](const request::DirectionRequest& one) {
      return request::parameters_of<Parameters>(one).world.dice[0];
    };
    EXPECT_EQ(die_of(reread.value()).orientation, die_of(request.value()).orientation);
    EXPECT_EQ(die_of(reread.value()).fixed_orientation.coeffs(),
              die_of(request.value()).fixed_orientation.coeffs());
  }
}

TEST(DiceRequest, SlipsAreNamed) {
  // Goal: an error about a request names the key and says what to do. Method: test requests with
  // one mistake each.
  EXPECT_THAT(complaint("dice = 21"), HasSubstr("from 1 to 20"));
  EXPECT_THAT(complaint("dice = 2\n[[world.die]]\nx_mm = 1"), tests::HasFacts("1|[[world.die]]"));
  EXPECT_THAT(complaint("[[world.die]]\nx_mn = 1"), HasSubstr("did you mean 'x_mm'?"));
  EXPECT_THAT(complaint("[[world.die]]\nup = 2"), HasSubstr("must be \"fixed\" if `up`"));
  EXPECT_THAT(complaint("[[world.die]]\norientation = \"fixed\"\nup = 2\nqx = 1"),
              HasSubstr("not both"));
  EXPECT_THAT(complaint("[[world.die]]\norientation = \"fixed\"\nqw = 0"), HasSubstr("too small"));
  EXPECT_THAT(complaint("restitution_low = 0.7"), HasSubstr("must be at least restitution_low"));
  EXPECT_THAT(complaint("height_sd_mm = 11"), tests::HasFacts("10.5|spacing_mm"));
  EXPECT_THAT(complaint("columns = 10001"), HasSubstr("from 1 to 10000"));
  EXPECT_THAT(complaint("[[world.die]]\nstart_s = 6"), HasSubstr("start_s of every"));
  EXPECT_THAT(complaint("[[constraint.place]]\ndie = 2"),
              tests::HasFacts("r.toml:4:1: 'die' in [[constraint.place]]: |at most 1"));
  EXPECT_THAT(complaint("[[constraint.place]]\nat_s = 7"), HasSubstr("at most time_max_s"));
  EXPECT_THAT(complaint("[[constraint.region]]\nx_low_mm = 60"), HasSubstr("at least x_low_mm"));
  EXPECT_THAT(complaint("[[constraint.face]]\nup = 7"), HasSubstr("from 1 to 6"));
  EXPECT_THAT(complaint("[[constraint.face]]\ntolerance_deg = 45"), HasSubstr("to 44 degrees"));
  EXPECT_THAT(complaint("[[constraint.orientation]]\nqw = 0"), HasSubstr("too small"));
  EXPECT_THAT(complaint("[[constraint.face]]\nup = 6\n[[constraint.yaw]]\nface = 1"),
              tests::HasFacts("die 1|orientations|90 degrees"));
  EXPECT_THAT(complaint("[[constraint.place]]\nx_mm = 9\n[[constraint.region]]\nx_high_mm = -9"),
              tests::HasFacts("r.toml:5:1: 'die' in [[constraint.region]]: |die 1|18 mm|5 mm|line "
                              "3|[[constraint.place]]"));
  const std::string here = "[[constraint.place]]\ntolerance_mm = 2\ndie = ";
  EXPECT_THAT(complaint("dice = 2\n" + here + "1\n" + here + "2"), tests::HasFacts("4 mm|16 mm"));
  EXPECT_THAT(complaint("[[world.die]]\nstart_s = 1\n[[world.die]]\nstart_s = 4\n"
                        "[[constraint.before]]\ndie = 2\n[[constraint.before]]"),
              tests::HasFacts("r.toml:7:1: 'time_s' in [[constraint.before]]: |die 2|3 s"));
  const auto slip = read("[[constraint.face]]\nup = 2\n[[constraint.face]]\nup = 7");
  ASSERT_FALSE(slip.ok());
  EXPECT_EQ(slip.error().size(), 1U);
  // The distance between these places equals the sum of the tolerances, up to rounding.
  EXPECT_EQ(complaint(here + "1\nx_mm = 30\n" + here + "1\nx_mm = 34"), "");
  EXPECT_EQ(complaint("dice = 2\n" + here + "1\n" + here + "2\nx_mm = 5"), "");
  EXPECT_EQ(complaint("dice = 2\n" + here + "1\nat_s = 0.5\n" + here + "2\nat_s = 0.5"), "");
  EXPECT_EQ(complaint(here + "1\nat_s = 0.5\n" + here + "1\nx_mm = 90"), "");
  EXPECT_THAT(complaint("[sampler]\nchange_all = 0.5"), HasSubstr("add up to 1, found 1.48"));
  EXPECT_EQ(complaint("[[constraint.face]]\nup = 6\n[[constraint.yaw]]\nface = 2"), "");
}

TEST(DiceRequest, FreeNumberingNeedsAnyStartAndOneTime) {
  // Goal: dice with goals for faces can be numbered after the throw only if their start orientation
  // is random and all these goals have the same time. Method: test a fixed start orientation, and
  // goals at two times. Both are valid with fixed numbering.
  const std::string fixed_start = "[[world.die]]\norientation = \"fixed\"\nup = 1\n";
  const std::string face = "[[constraint.face]]\nup = 6\n";
  const std::string other_time = "[[constraint.yaw]]\nface = 2\nat_s = 0.2\n";
  const std::string fixed = "[constraint]\nnumbering = \"fixed\"\n";
  EXPECT_THAT(complaint(fixed_start + face),
              tests::HasFacts("'numbering' in [constraint]: |\"fixed\"|die 1"));
  EXPECT_EQ(complaint(fixed_start + fixed + face), "");
  EXPECT_EQ(complaint(fixed_start + "[[constraint.place]]\nx_mm = 3"), "");
  EXPECT_THAT(complaint(face + other_time), HasSubstr("at several times"));
  EXPECT_EQ(complaint(fixed + face + other_time), "");
}

}  // namespace
}  // namespace sleight::worlds::dice
