// Goal: the plausibility of kept animations is computed correctly from their starts, their table
// heights and the prior. Method: use two archives. The first archive is small and has known values.
// The animations of the second archive are drawn from the prior.
#include "clients/world_plots/dice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "clients/plot/svg.h"
#include "common/base/error.h"
#include "common/random/distributions.h"
#include "tests/archive/small_archive.h"
#include "tests/support/numbers.h"
#include "tests/support/refusals.h"
#include "tests/unit/clients/pictures/panel_series.h"
#include "worker/worlds/dice/dice.h"

namespace sleight::world_plots::dice_test {

using pictures::all_of;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using tests::failure_of;

/// Returns the counts of all bins. The first bin's count is `below`, and the last bin's count is
/// `above`. The bins at -1 and 0 standard deviations have the other two counts.
std::vector<double> in_bins(double below, double at_minus_one, double at_zero, double above) {
  std::vector<double> counts(k_offset_bins);
  counts.front() = below;
  counts[offset_bin_of(-1)] = at_minus_one;
  counts[offset_bin_of(0)] = at_zero;
  counts.back() = above;
  return counts;
}

std::vector<double> joined(std::vector<double> first, const std::vector<double>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// Returns a prior of two dice. Position x of both dice and velocity z of the second die are
/// random.
DicePrior small_prior() {
  const auto x = [](std::uint64_t die) {
    return StartComponent{.variable = "start_position_m",
                          .name = "position x",
                          .die = die,
                          .axis = 0,
                          .mean = 1,
                          .sd = 2};
  };
  return {.dice = 2,
          .start = {x(0),
                    x(1),
                    {.variable = "start_velocity_mps",
                     .name = "velocity z",
                     .die = 1,
                     .axis = 2,
                     .mean = 0,
                     .sd = 0.5}},
          .is_table_random = true};
}

/// Contents of a small archive. For each animation, positions and velocities list x, y and z of die
/// 0, then of die 1.
struct Contents {
  double animations = 2;
  std::vector<double> position_m{1, 7, 7, 3, 7, 7, -1, 7, 7, 5, 7, 7};
  std::vector<double> velocity_mps{7, 7, 7, 7, 7, 0.5, 7, 7, 7, 7, 7, -1};
  std::vector<double> offsets = joined(in_bins(0, 3, 1, 0), in_bins(1, 2, 0, 1));
  std::vector<double> offset_squares{2, 8};
  /// These fields describe the prior; a test can change them.
  bool has_prior = false;
  double dice = 2;
  std::vector<double> position_mean{1, 7, 7, 1, 7, 7};
  std::vector<double> position_sd{2, 0, k_nan, 2, 0, 0};
  double velocity_z_sd = 0.5;
  std::vector<double> squares_of_throws{0, 3, 0};
};

class SmallArchive final : public archive::StoredArchive {
 public:
  explicit SmallArchive(const Contents& contents = {})
      : StoredArchive("dice", "[sampler]\nchains = 2\n", contents.animations) {
    add_animations(0);
    const archive::Dimension die{"die", 2};
    const archive::Dimension xyz{"axis_xyz", 3};
    add_of_animations("start_position_m", {die, xyz}, contents.position_m);
    add_of_animations("start_velocity_mps", {die, xyz}, contents.velocity_mps);
    add_of_animations("offsets", {{"offset_bin", k_offset_bins}}, contents.offsets);
    add_of_animations("offset_squares", {}, contents.offset_squares);
    if (!contents.has_prior) return;
    const auto add_prior = [&](const char* name, const std::vector<double>& values) {
      add_anywhere("/prior", name, {{"die", static_cast<std::uint64_t>(contents.dice)}, xyz},
                   values);
    };
    add_prior("start_position_m_prior_mean", contents.position_mean);
    add_prior("start_position_m_prior_sd", contents.position_sd);
    add_prior("start_velocity_mps_prior_mean", {0, 0, 0, 0, 0, 0});
    add_prior("start_velocity_mps_prior_sd", {0, 0, 0, 0, 0, contents.velocity_z_sd});
    add_prior("start_spin_radps_prior_mean", {0, 0, 0, 0, 0, 0});
    add_prior("start_spin_radps_prior_sd", {0, 0, 0, 0, 0, 0});
    add_anywhere("/sample_stats_prior", "offset_squares",
                 {{"chain", 1}, {"draw", contents.squares_of_throws.size()}},
                 contents.squares_of_throws);
  }
};

TEST(DicePlausibility, AreScoresAndCosts) {
  // In the two animations, the scores of x are (0, 1) and (-1, 2), and the scores of velocity are 1
  // and -2. The squares of the three scores sum to 2 and 9. The mean of the sums is 5.5, so the
  // start's cost is (5.5 - 3)/2. The squares of the table's four heights sum to 2 and 8. The mean
  // of the sums is 5, so the table's cost is (5 - 4)/2.
  const DicePlausibility all = dice_plausibility(SmallArchive(), small_prior(), {});
  EXPECT_EQ(all.animations, 2U);
  ASSERT_EQ(all.start.size(), 2U);
  EXPECT_EQ(all.start[0].name, "position x");
  EXPECT_THAT(all.start[0].scores, ElementsAre(0, -1, 1, 2));
  EXPECT_THAT(all.start[1].scores, ElementsAre(1, -2));
  EXPECT_EQ(all.offsets, in_bins(1, 5, 1, 1));
  EXPECT_EQ(all.lineages, 2U);
  EXPECT_DOUBLE_EQ(all.start_cost.mean, 0.5 * (5.5 - 3));
  EXPECT_DOUBLE_EQ(all.start_cost.spread, std::sqrt(1.5));
  EXPECT_DOUBLE_EQ(all.table_cost.mean, 0.5 * (5 - 4));
  EXPECT_DOUBLE_EQ(all.table_cost.spread, std::sqrt(2));
  // The two animations' costs are -1/2 and 3 for the start, and -1 and 2 for the table. Each
  // animation's sum of costs is -3/2 or 5. The error of a mean of two values is half their
  // difference.
  EXPECT_DOUBLE_EQ(all.start_cost.error, 1.75);
  EXPECT_DOUBLE_EQ(all.table_cost.error, 1.5);
  EXPECT_DOUBLE_EQ(all.cost.mean, 1.75);
  EXPECT_DOUBLE_EQ(all.cost.error, 3.25);
  EXPECT_DOUBLE_EQ(all.cost.spread, std::sqrt(3.5));
  const DicePlausibility second = dice_plausibility(SmallArchive(), small_prior(), 1);
  EXPECT_EQ(second.animations, 1U);
  EXPECT_THAT(second.start[0].scores, ElementsAre(-1, 2));
  EXPECT_DOUBLE_EQ(second.start_cost.mean, 0.5 * (9 - 3));
  EXPECT_DOUBLE_EQ(second.table_cost.mean, 0.5 * (8 - 4));
  EXPECT_TRUE(std::isnan(second.cost.error));
}

TEST(DicePlausibility, WordsSayNoMoreThanIsKnown) {
  // Goal: the text states a verdict only if the mean cost differs from 0 by more than chance. Large
  // costs don't overflow.
  const auto words_of = [](double mean, double error) {
    const PlausibilityCost cost{.is_random = true, .mean = mean, .error = error, .spread = 2};
    return plausibility_words(
        {.animations = 7, .lineages = 5, .start_cost = cost, .table_cost = {}, .cost = cost});
  };
  EXPECT_THAT(words_of(1, 0.4), HasSubstr("7 kept animations of 5 lineages"));
  EXPECT_THAT(words_of(1, 0.4),
              ContainsRegex("starts: log probability 1.00 \\+- 0.40 below [^\n]*2.00\\)\n"));
  EXPECT_THAT(words_of(1, 0.4), HasSubstr("table:  nothing is normally distributed\n"));
  EXPECT_THAT(words_of(1, 0.4), HasSubstr("blind throws typically have 2.7 times"));
  EXPECT_THAT(words_of(-1, 0.4), HasSubstr("1.00 +- 0.40 above"));
  EXPECT_THAT(words_of(-1, 0.4), HasSubstr("these animations typically have 2.7 times"));
  EXPECT_THAT(words_of(1, 0.6), HasSubstr("due to chance"));
  EXPECT_THAT(words_of(1, k_nan), HasSubstr("probability 1.00 below"));
  EXPECT_THAT(words_of(1, k_nan), HasSubstr("A single lineage"));
  EXPECT_THAT(words_of(3000, 1), HasSubstr("blind throws typically have e^3000 times"));
}

TEST(DicePlausibility, OfThePriorItselfIsNothing) {
  // Goal: if animations are drawn from the prior, their mean cost is 0. Method: draw 4,000
  // animations, and allow an error of 5 standard errors.
  constexpr std::size_t k_animations = 4000;
  random::Stream stream({.seed = 20261122, .purpose = random::Purpose::prior}, 0);
  const auto normal = [&](double mean, double sd) {
    return random::Normal{.mean = mean, .sd = sd}.draw(stream);
  };
  Contents contents{.animations = k_animations,
                    .position_m = {},
                    .velocity_mps = {},
                    .offsets = {},
                    .offset_squares = {}};
  for (std::size_t i = 0; i < k_animations; ++i) {
    for (int k = 0; k < 6; ++k) {
      contents.position_m.push_back(normal(1, 2));
      contents.velocity_mps.push_back(normal(0, 0.5));
    }
    std::vector<double> bins(k_offset_bins);
    double squares = 0;
    for (int point = 0; point < 30; ++point) {
      const double height = normal(0, 1);
      ++bins[offset_bin_of(height)];
      squares += height * height;
    }
    contents.offsets.insert(contents.offsets.end(), bins.begin(), bins.end());
    contents.offset_squares.push_back(squares);
  }
  const DicePrior prior = small_prior();
  const DicePlausibility found = dice_plausibility(SmallArchive(contents), prior, {});
  const double root = std::sqrt(static_cast<double>(k_animations));
  for (const PlausibilityCost& cost : {found.start_cost, found.table_cost, found.cost}) {
    EXPECT_NEAR(cost.mean, 0, 5 * cost.spread / root);
    // Each animation is its own lineage, so the mean's error is the spread divided by the root of
    // the number of animations. The table's cost is half a chi-square variable with 30 degrees of
    // freedom, minus 15.
    EXPECT_NEAR(cost.error, cost.spread / root, 0.1 * cost.spread / root);
  }
  EXPECT_DOUBLE_EQ(found.table_cost.spread, std::sqrt(15));
  // Each panel's bars have a total area of 1. A bar's height is close to the curve's mean over the
  // bar.
  const plot::Figure figure = plausibility_figure(found, prior);
  ASSERT_EQ(figure.panels.size(), 3U);
  for (const plot::Panel& panel : figure.panels) {
    double area = 0;
    for (const plot::Rectangle& bar : all_of<plot::Rectangle>(panel))
      area += (bar.high.x - bar.low.x) * bar.high.y;
    EXPECT_NEAR(area, 1, 1e-9) << panel.title;
    const auto bars = all_of<plot::Rectangle>(panel);
    ASSERT_EQ(bars.size(), k_offset_bins);
    EXPECT_DOUBLE_EQ(bars[1].low.x, -3);
    EXPECT_DOUBLE_EQ(bars[5].low.x, -1);
    // Each bar is half a unit wide. The bar from -1 to -1/2 has an area of 0.1499, and the bar
    // beyond 3 has an area of 0.0013.
    EXPECT_NEAR(bars[5].high.y, 0.2998, 0.05);
    EXPECT_NEAR(bars[13].high.y, 0.0027, 0.01);
  }
  EXPECT_EQ(plot::to_svg(figure).find("nan"), std::string::npos);
}

TEST(DicePlausibility, WhatIsNotRandomCostsNothing) {
  DicePrior prior = small_prior();
  prior.is_table_random = false;
  const DicePlausibility found = dice_plausibility(SmallArchive(), prior, {});
  EXPECT_FALSE(found.table_cost.is_random);
  EXPECT_EQ(found.cost.mean, found.start_cost.mean);
  EXPECT_EQ(found.cost.error, found.start_cost.error);
  EXPECT_EQ(plausibility_figure(found, prior).panels.size(), 2U);
}

TEST(DicePlausibility, DamagedArchivesAreRefused) {
  const auto refused = [](const Contents& contents, const char* words) {
    EXPECT_EQ(
        failure_of([&] { dice_plausibility(SmallArchive(contents), small_prior(), {}); }, words),
        base::ExitCode::bad_archive);
  };
  refused({.position_m = {1, 7, 7, k_nan, 7, 7, -1, 7, 7, 5, 7, 7}}, "start_position_m:");
  refused({.offsets = joined(in_bins(0, 3, 1, -1), in_bins(1, 2, 0, 1))}, "offsets:");
  refused({.offsets = joined(in_bins(0, 3, 1, k_nan), in_bins(1, 2, 0, 1))}, "offsets:");
  refused({.offset_squares = {2, -8}}, "offset_squares:");
  refused({.offset_squares = {2, std::numeric_limits<double>::infinity()}}, "offset_squares:");
  refused({.position_m = {1, 7, 7, 1e200, 7, 7, -1, 7, 7, 5, 7, 7}}, "start_position_m:");
  refused({.offsets = joined(in_bins(0, 3, 1, 1e200), in_bins(1, 2, 0, 1))}, "offsets:");
  refused({.offsets = joined(in_bins(0, 3, 1, 0.5), in_bins(1, 2, 0, 1))}, "offsets:");
  refused({.offset_squares = {2, 1e200}}, "offset_squares:");
  DicePrior prior = small_prior();
  prior.dice = 3;
  EXPECT_EQ(failure_of([&] { dice_plausibility(SmallArchive(), prior, {}); },
                       "start_position_m: expected rows of 9 numbers"),
            base::ExitCode::bad_archive);
  Contents none{
      .animations = 0, .position_m = {}, .velocity_mps = {}, .offsets = {}, .offset_squares = {}};
  EXPECT_EQ(failure_of([&] { dice_plausibility(SmallArchive(none), small_prior(), {}); },
                       "no satisfying animation"),
            base::ExitCode::usage);
  EXPECT_EQ(failure_of([&] { dice_plausibility(SmallArchive(), small_prior(), 2); }, "no chain 2"),
            base::ExitCode::usage);
}

TEST(DicePlausibility, ThePriorIsTheArchives) {
  // Goal: dice_prior_of() finds which start components of an archive are random, and whether the
  // table is random. Method: read one archive whose priors are known, one that has no priors, and
  // several whose priors are invalid.
  const DicePrior prior = dice_prior_of(SmallArchive({.has_prior = true}));
  EXPECT_EQ(prior.dice, 2U);
  EXPECT_TRUE(prior.is_table_random);
  std::vector<std::string> found;
  for (const StartComponent& one : prior.start)
    found.push_back(one.name + " of " + std::to_string(one.die));
  EXPECT_THAT(found, ElementsAre("position x of 0", "position x of 1", "velocity z of 1"));
  EXPECT_EQ(prior.start[1].variable, "start_position_m");
  EXPECT_EQ(prior.start[1].mean, 1);
  EXPECT_EQ(prior.start[1].sd, 2);
  EXPECT_EQ(prior.start[2].axis, 2U);
  EXPECT_EQ(prior.start[2].sd, 0.5);
  EXPECT_FALSE(dice_prior_of(SmallArchive({.has_prior = true, .squares_of_throws = {0, 0}}))
                   .is_table_random);
  const pictures::Picture picture =
      Dice().draw("plausibility", SmallArchive({.has_prior = true}), {});
  EXPECT_EQ(picture.words,
            plausibility_words(dice_plausibility(SmallArchive(), small_prior(), {})));
  EXPECT_EQ(picture.figure.panels.size(), 3U);

  EXPECT_EQ(failure_of([&] { dice_prior_of(SmallArchive()); }, "missing group /prior"),
            base::ExitCode::bad_archive);
  const auto refused = [](const Contents& contents, const char* words) {
    EXPECT_EQ(failure_of([&] { dice_prior_of(SmallArchive(contents)); }, words),
              base::ExitCode::bad_archive);
  };
  refused({.has_prior = true, .position_mean = {k_nan, 7, 7, 1, 7, 7}},
          "start_position_m_prior_mean: |impossible");
  refused({.has_prior = true, .dice = 1e6}, "three numbers|1000 dice");
  EXPECT_EQ(
      failure_of([] { dice_prior_of(SmallArchive({.has_prior = true, .squares_of_throws = {}})); },
                 "has 0"),
      base::ExitCode::usage);
}

TEST(DicePlausibility, NothingRandomIsSaid) {
  // Goal: if nothing in the prior is random, the plot is refused.
  const SmallArchive fixed({.has_prior = true,
                            .position_sd = {0, 0, 0, 0, 0, 0},
                            .velocity_z_sd = 0,
                            .squares_of_throws = {0, 0}});
  EXPECT_EQ(failure_of([&] { Dice().draw("plausibility", fixed, {}); }, "nothing to plot"),
            base::ExitCode::environment);
}

TEST(DicePlausibility, BinsAreThoseOfTheWorld) {
  // Goal: plots use the same bins of heights as the world. Method: compare the bin numbers of both
  // functions, for heights inside and outside the bins.
  EXPECT_EQ(k_offset_bins, worlds::dice::k_offset_bins);
  EXPECT_EQ(k_offset_first_sd, worlds::dice::k_offset_first_sd);
  EXPECT_EQ(k_offset_step_sd, worlds::dice::k_offset_step_sd);
  for (int eighth = -80; eighth <= 80; ++eighth)
    EXPECT_EQ(offset_bin_of(eighth / 8.0), worlds::dice::offset_bin_of(eighth / 8.0)) << eighth;
}

}  // namespace sleight::world_plots::dice_test
