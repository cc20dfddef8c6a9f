// Goal: the pictures of dice show what an archive holds: each die where its motion puts it, with
// the face that is up, and where it is wanted. Method: a small archive of known motions, drawn; the
// figure's series are counted and measured.
#include "clients/cli/dice_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "clients/plot/layout.h"
#include "clients/plot/svg.h"
#include "common/base/error.h"
#include "tests/unit/clients/cli/failures.h"
#include "tests/unit/clients/cli/panel_series.h"
#include "tests/unit/clients/cli/small_archive.h"

namespace sleight::cli {
namespace {

using ::testing::HasSubstr;

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
const double k_half_root = std::sqrt(0.5);

DiceScene small_scene() {
  return {.dice = 2,
          .side_mm = 16,
          .spacing_mm = 21,
          .places = {{.die = 0, .centre_mm = {50, 3}, .tolerance_mm = 5}}};
}

/// What a test changes of an archive. Die 0 flies for half a second, turning by a quarter about y,
/// which brings its 6 up, and lies at (50, 0); die 1 lies at (0, 40) with its 3 up.
struct Contents {
  double animations = 2;
  std::vector<double> die{0, 0, 1};
  std::vector<double> start_s{0, 0.5, 0.1};
  std::vector<double> position_m{0, 0, 0.1, 0.05, 0, 0.008, 0, 0.04, 0.008};
  std::vector<double> velocity_mps{0.1, 0, 0, 0, 0, 0, 0, 0, 0};
  std::vector<double> acceleration_mps2{0, 0, -0.8, 0, 0, 0, 0, 0, 0};
  std::vector<double> orientation{1, 0, 0, 0, k_half_root, 0, k_half_root, 0, 1, 0, 0, 0};
  std::vector<double> spin_radps{0, M_PI, 0, 0, 0, 0, 0, 0, 0};
};

class SmallArchive final : public StoredArchive {
 public:
  explicit SmallArchive(const Contents& contents = {})
      : StoredArchive("dice", "[sampler]\nchains = 2\n", contents.animations) {
    const archive::Dimension xyz{"axis_xyz", 3};
    add_animations(contents.die.size());
    add_column("moving_die", {}, contents.die);
    add_column("start_s", {}, contents.start_s);
    add_column("position_m", {xyz}, contents.position_m);
    add_column("velocity_mps", {xyz}, contents.velocity_mps);
    add_column("acceleration_mps2", {xyz}, contents.acceleration_mps2);
    add_column("orientation", {{"quaternion_wxyz", 4}}, contents.orientation);
    add_column("angular_velocity_radps", {xyz}, contents.spin_radps);
  }
};

TEST(DiceMotions, FollowTheSegments) {
  // Goal: a die is where its segment in force puts it, turned about its axis since, and nowhere
  // before it is let go. Method: by hand, at and between the starts.
  const SmallArchive source;
  const std::vector<DieMotion> dice = read_dice_motions(source, 1, 2);
  ASSERT_EQ(dice.size(), 2U);
  EXPECT_EQ(dice[1].die(), 1U);
  EXPECT_FALSE(dice[1].pose_at(0.09).has_value());
  const DiePose flying = dice[0].pose_at(0.25).value();
  EXPECT_DOUBLE_EQ(flying.centre_mm.x(), 25);
  EXPECT_DOUBLE_EQ(flying.centre_mm.z(), 100 - 400 * 0.25 * 0.25);
  // An eighth of a turn about y.
  EXPECT_NEAR(flying.orientation.w(), std::cos(M_PI / 8), 1e-12);
  EXPECT_NEAR(flying.orientation.y(), std::sin(M_PI / 8), 1e-12);
  EXPECT_EQ(upper_face(dice[0].pose_at(0.1)->orientation), 3U);
  EXPECT_EQ(upper_face(dice[0].pose_at(0.49)->orientation), 6U);
  EXPECT_EQ(upper_face(dice[0].last_pose().orientation), 6U);
  EXPECT_DOUBLE_EQ(dice[0].pose_at(99)->centre_mm.x(), 50);
}

TEST(DiceMotions, DamagedOnesAreRefused) {
  // Goal: numbers of a hostile archive are refused by name. Method: one wrong number at a time.
  const auto refused = [](const Contents& contents, const char* words) {
    EXPECT_EQ(failure_of([&] { read_dice_motions(SmallArchive(contents), 0, 2); }, words),
              base::ExitCode::bad_archive);
  };
  for (const double die : {-1.0, 2.0, 1e300, k_nan})
    refused({.die = {0, 0, die}}, "moves dice that its request doesn't have");
  refused({.start_s = {0.6, 0.5, 0.1}}, "not in the order of time");
  for (const double number : {k_nan, 1e300, std::numeric_limits<double>::infinity()}) {
    refused({.start_s = {0, number, 0}}, "numbers that no motion of dice has");
    refused({.spin_radps = {0, number, 0, 0, 0, 0, 0, 0, 0}}, "numbers that no motion");
    refused({.position_m = {0, number, 0, 0, 0, 0, 0, 0, 0}}, "numbers that no motion");
  }
  refused({.orientation = {0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}}, "that are no rotations");
  refused({.die = {},
           .start_s = {},
           .position_m = {},
           .velocity_mps = {},
           .acceleration_mps2 = {},
           .orientation = {},
           .spin_radps = {}},
          "moves no die");
}

TEST(DiceFigures, ShowDiceAtRestFromAbove) {
  // Goal: dice lie where they lie, with the pips of the upper face, and a ring where one is wanted.
  // Method: the view from above alone, which is in millimetres.
  const SmallArchive source;
  const plot::Figure figure =
      dice_animations(source, small_scene(), {.chain = 1, .count = 4, .front = false});
  ASSERT_EQ(figure.panels.size(), 1U);
  const plot::Panel& panel = figure.panels.front();
  EXPECT_THAT(panel.title, HasSubstr("chain 1, scan 3"));
  EXPECT_THAT(panel.title, HasSubstr("up: 6, 3; 3.0 mm from the place, at rest after 0.50 s"));
  // Two faces, and nine pips.
  const auto polygons = all_of<plot::Polygon>(panel);
  ASSERT_EQ(polygons.size(), 2U + 6 + 3);
  std::vector<plot::Polygon> squares;
  for (const plot::Polygon& polygon : polygons) {
    if (polygon.corners.size() == 4) squares.push_back(polygon);
  }
  ASSERT_EQ(squares.size(), 2U);
  for (const plot::Point& corner : squares[0].corners) {
    EXPECT_NEAR(std::abs(corner.x - 50), 8, 1e-9);
    EXPECT_NEAR(std::abs(corner.y), 8, 1e-9);
  }
  const auto rings = all_of<plot::Disc>(panel);
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_EQ(rings[0].center, (plot::Point{50, 3}));
  EXPECT_DOUBLE_EQ(rings[0].radius_x, 5);
  // Die 0's centres are a sixtieth of a second apart, at 0.1 m/s.
  const auto centres = all_of<plot::Markers>(panel);
  ASSERT_EQ(centres.size(), 2U);
  ASSERT_GE(centres[0].points.size(), 30U);
  EXPECT_NEAR(centres[0].points[3].x - centres[0].points[2].x, 100.0 / 60, 1e-9);
}

TEST(DiceFigures, CubesFadeIn) {
  // Goal: later outlines of a moving die are stronger. Method: opacities of the lines of its
  // colour, in order.
  const SmallArchive source;
  const plot::Figure figure = dice_animations(source, small_scene(), {.count = 1, .front = false});
  std::vector<double> opacities;
  for (const plot::Line& line : all_of<plot::Line>(figure.panels.front())) {
    if (line.points.size() == 5 && line.color.opacity < 1) opacities.push_back(line.color.opacity);
  }
  ASSERT_GT(opacities.size(), 10U);
  EXPECT_LT(opacities[0], 0.2);
  // The second die's come after the first one's.
  const auto turn = std::ranges::is_sorted_until(opacities);
  EXPECT_GE(turn - opacities.begin(), 10);
}

TEST(DiceFigures, FitTheirPanels) {
  // Goal: nothing is cut off, animations stand beside each other, and a panel's units are pixels.
  // Method: extents of all that is drawn, for wide and deep scenes; the SVG's frames.
  for (const double y_m : {0.04, 0.4, 4.0}) {
    for (const double animations : {1.0, 2.0, 3.0}) {
      const SmallArchive source(
          {.animations = animations, .position_m = {0, 0, 0.1, 0.05, 0, 0.008, 0, y_m, 0.008}});
      const plot::Figure figure = dice_animations(source, small_scene(), {.count = 3});
      ASSERT_EQ(figure.panels.size(), static_cast<std::size_t>(animations));
      ASSERT_GE(figure.columns, std::min<std::size_t>(figure.panels.size(), 2));
      const plot::Panel& panel = figure.panels.front();
      const auto inside = [&](const plot::Point& point) {
        return point.x >= -1e-9 && point.y >= -1e-9 && point.x <= panel.x_range->high + 1e-9 &&
               point.y <= panel.y_range->high + 1e-9;
      };
      for (const plot::Polygon& polygon : all_of<plot::Polygon>(panel))
        ASSERT_TRUE(std::ranges::all_of(polygon.corners, inside));
      for (const plot::Line& line : all_of<plot::Line>(panel))
        ASSERT_TRUE(std::ranges::all_of(line.points, inside));
      const plot::PanelLayout layout = plot::layout_of(figure).panels.front();
      EXPECT_NEAR(layout.frame.width, panel.x_range->high, 0.01);
      EXPECT_NEAR(layout.frame.height, panel.y_range->high, 0.01);
      EXPECT_EQ(plot::to_svg(figure).find("nan"), std::string::npos);
    }
  }
}

TEST(DiceFigures, NothingToDrawIsSaid) {
  // Goal: without a kept animation one learns why and what to do. Method: none at all; no such
  // chain.
  const auto drawn = [](double animations, std::optional<std::uint64_t> chain) {
    return [=] {
      dice_animations(SmallArchive({.animations = animations}), small_scene(), {.chain = chain});
    };
  };
  EXPECT_EQ(failure_of(drawn(0, {}), "no satisfying animation to draw; run more scans"),
            base::ExitCode::environment);
  EXPECT_EQ(failure_of(drawn(1, 2), "no chain 2"), base::ExitCode::usage);
}

}  // namespace
}  // namespace sleight::cli
