// Goal: the pictures of balls that spell show what an archive holds: which bins shall be filled,
// each ball where its motion puts it, instants in order. Method: a small archive of known motions,
// drawn; the figure's series and the SVG's elements are counted and measured.
#include "clients/cli/spelling_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "clients/cli/spelling_motions.h"
#include "clients/plot/layout.h"
#include "clients/plot/svg.h"
#include "common/base/error.h"
#include "tests/unit/clients/cli/failures.h"
#include "tests/unit/clients/cli/panel_series.h"
#include "tests/unit/clients/cli/small_archive.h"

namespace sleight::cli {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Le;

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

/// Two of three bins in a row.
SpellingBox small_box() {
  return {.columns = 3,
          .rows = 1,
          .designated = {true, false, true},
          .bin_mm = 20,
          .partition_mm = 2,
          .partition_height_mm = 12,
          .box_height_mm = 36,
          .drop_height_mm = 72,
          .ball_diameter_mm = 16};
}

/// What a test changes of an archive.
struct Contents {
  double animations = 2;
  std::vector<double> ball{0, 0, 1, 1};
  std::vector<double> start_s{0, 0.4, 0.15, 1.0};
  /// Ball 0 flies for 0.4 s, then lies in the left bin; ball 1 hangs for 0.85 s, then lies in the
  /// right one.
  std::vector<double> position_m{0.01, 0,    0.08, -0.022, 0.001, 0.009,
                                 0.02, 0.01, 0.08, 0.022,  0,     0.009};
  std::vector<double> velocity_mps{0.01, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  std::vector<double> acceleration_mps2{0, 0, -0.2, 0, 0, 0, 0, 0, 0, 0, 0, 0};
};

/// Of two balls; ten iterations to a scan.
class SmallArchive final : public StoredArchive {
 public:
  explicit SmallArchive(const Contents& contents = {})
      : StoredArchive("spelling", "[sampler]\niterations_per_scan = 10\n", contents.animations) {
    const archive::Dimension xyz{"axis_xyz", 3};
    add_statistic("filled", {0, 1, 1, 2, 0, 0, 0, 1});
    add_animations(contents.ball.size());
    add_column("moving_ball", {}, contents.ball);
    add_column("start_s", {}, contents.start_s);
    add_column("position_m", {xyz}, contents.position_m);
    add_column("velocity_mps", {xyz}, contents.velocity_mps);
    add_column("acceleration_mps2", {xyz}, contents.acceleration_mps2);
  }
};

/// Where filled discs stand, as (x, y).
std::vector<plot::Point> balls_of(const plot::Panel& panel) {
  std::vector<plot::Point> centers;
  for (const plot::Disc& disc : all_of<plot::Disc>(panel)) {
    if (disc.filled) centers.push_back(disc.center);
  }
  return centers;
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

TEST(SpellingMotions, FollowTheSegments) {
  // Goal: a ball is where its segment in force puts it, and nowhere before its drop. Method: by
  // hand, at and between the starts.
  const SmallArchive source;
  const std::vector<BallMotion> balls = read_motions(source, 1, 2);
  ASSERT_EQ(balls.size(), 2U);
  EXPECT_EQ(balls[1].ball(), 1U);
  EXPECT_EQ(balls[1].place_at(0.149), std::nullopt);
  const PlaceMm start = balls[1].place_at(0.15).value();
  EXPECT_DOUBLE_EQ(start[0], 20);
  EXPECT_DOUBLE_EQ(start[1], 10);
  EXPECT_DOUBLE_EQ(start[2], 80);
  const PlaceMm flying = balls[0].place_at(0.3).value();
  EXPECT_DOUBLE_EQ(flying[0], 10 + 10 * 0.3);
  EXPECT_DOUBLE_EQ(flying[2], 80 - 100 * 0.3 * 0.3);
  EXPECT_DOUBLE_EQ(balls[0].place_at(0.4).value()[0], -22);
  EXPECT_DOUBLE_EQ(balls[0].place_at(99).value()[0], -22);
}

TEST(SpellingMotions, DamagedOnesAreRefused) {
  // Goal: numbers of a hostile archive are refused by name. Method: one wrong number at a time.
  const auto refused = [](const Contents& contents, const char* words) {
    EXPECT_EQ(failure_of([&] { read_motions(SmallArchive(contents), 0, 2); }, words),
              base::ExitCode::bad_archive);
  };
  for (const double ball : {-1.0, 2.0, 1e300, k_nan})
    refused({.ball = {0, 0, 1, ball}}, "moves balls that its request doesn't have");
  for (const double start : {-1.0, k_nan, std::numeric_limits<double>::infinity()})
    refused({.start_s = {0, start, 0, 1}}, "not in the order of time");
  refused(
      {.ball = {}, .start_s = {}, .position_m = {}, .velocity_mps = {}, .acceleration_mps2 = {}},
      "moves no ball");
}

TEST(SpellingFigures, ShowBinsAndBallsFromAbove) {
  // Goal: bins to fill are tinted, others not, and balls at rest lie where they lie. Method: the
  // view from above alone, which is in millimetres of the box.
  const SmallArchive source;
  const plot::Figure figure =
      spelling_animations(source, small_box(), {.chain = 1, .count = 4, .frames = false});
  ASSERT_EQ(figure.panels.size(), 1U);
  const plot::Panel& panel = figure.panels.front();
  EXPECT_EQ(panel.title, "chain 1, iteration 30");
  const auto rectangles = all_of<plot::Rectangle>(panel);
  ASSERT_EQ(rectangles.size(), 5U);  // the partitions' colour, three bins, the walls
  EXPECT_EQ(rectangles[1].color, rectangles[3].color);
  EXPECT_NE(rectangles[1].color, rectangles[2].color);
  EXPECT_DOUBLE_EQ(rectangles[1].low.x, -32);
  EXPECT_DOUBLE_EQ(rectangles[3].high.x, 32);
  EXPECT_THAT(balls_of(panel), ElementsAre(plot::Point{-22, 1}, plot::Point{22, 0}));
  const auto discs = all_of<plot::Disc>(panel);
  EXPECT_THAT(discs, Each(::testing::Field(&plot::Disc::radius_x, 8)));
  EXPECT_NE(discs.front().color, discs.back().color);
  std::vector<std::string> numbers;
  for (const plot::Text& text : all_of<plot::Text>(panel))
    numbers.push_back(text.text);
  EXPECT_THAT(numbers, ElementsAre("1", "2"));
}

TEST(SpellingFigures, ShowInstantsInOrder) {
  // Goal: eight frames from the first drop to rest, each with the balls dropped by then. Method:
  // times and circles out of the SVG, of which there are two of each ball and view.
  const SmallArchive source;
  const plot::Figure figure = spelling_animations(source, small_box(), {.count = 1});
  const std::string svg = plot::to_svg(figure);
  std::vector<double> times;
  // A number before " s", as of ">0.29 s<" and ">from the front, 0.00 s<". Not by std::regex, of
  // which GCC 12 says under sanitizers that it may be uninitialised.
  for (std::size_t at = svg.find(" s"); at != std::string::npos; at = svg.find(" s", at + 1)) {
    const std::size_t before = svg.find_last_not_of("0123456789.", at - 1);
    const bool is_time =
        before + 1 < at && (svg[before] == '>' || svg.compare(before - 1, 2, ", ") == 0);
    if (is_time) times.push_back(std::stod(svg.substr(before + 1, at - before - 1)));
  }
  ASSERT_EQ(times.size(), 8U);
  EXPECT_TRUE(std::ranges::is_sorted(times));
  EXPECT_EQ(times.front(), 0);
  EXPECT_EQ(times.back(), 1);
  EXPECT_THAT(svg, HasSubstr(">1.00 s, at rest<"));
  EXPECT_EQ(occurrences(svg, "from above, at rest"), 1U);
  // Of the times 0, 0.09, 0.18, ... the first two are before the second drop.
  EXPECT_EQ(occurrences(svg, "<ellipse"), 2U * (2 + 8 + 6));
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  // The last frame shows what the view from above does, mirrored nowhere.
  const std::vector<plot::Point> balls = balls_of(figure.panels.front());
  const auto last = std::span(balls).last(2);
  EXPECT_NE(last[0].x, last[1].x);
  EXPECT_DOUBLE_EQ(last[0].y, last[1].y);
}

TEST(SpellingFigures, FitTheirPanelsForAnyBox) {
  // Goal: nothing of an animation is cut off and its scale is that of the panel's units, for the
  // narrowest box to the largest. Method: extents of all that is drawn; the SVG's frame.
  const SmallArchive source;
  for (const auto& [columns, rows] :
       {std::pair{2U, 1U}, {1U, 12U}, {7U, 5U}, {15U, 7U}, {40U, 1U}, {40U, 12U}}) {
    SpellingBox box = small_box();
    box.columns = columns;
    box.rows = rows;
    box.designated = std::vector<bool>(std::size_t{columns} * rows, true);
    for (const double drop_height_mm : {20.0, 72.0, 1000.0}) {
      box.drop_height_mm = drop_height_mm;
      const plot::Figure figure = spelling_animations(source, box, {.count = 2});
      ASSERT_EQ(figure.panels.size(), 2U);
      const plot::Panel& panel = figure.panels.front();
      for (const plot::Rectangle& rectangle : all_of<plot::Rectangle>(panel)) {
        ASSERT_LT(rectangle.low.x, rectangle.high.x);
        ASSERT_LT(rectangle.low.y, rectangle.high.y);
        ASSERT_GE(rectangle.low.x, -1e-9) << columns << " x " << rows << ", " << drop_height_mm;
        ASSERT_GE(rectangle.low.y, -1e-9);
        ASSERT_LE(rectangle.high.x, panel.x_range->high + 1e-9);
        ASSERT_LE(rectangle.high.y, panel.y_range->high + 1e-9);
      }
      const plot::PanelLayout layout = plot::layout_of(figure).panels.front();
      EXPECT_NEAR(layout.frame.width, panel.x_range->high, 0.01);
      EXPECT_NEAR(layout.frame.height, panel.y_range->high, 0.01);
    }
  }
}

TEST(SpellingFigures, TraceCountsIterations) {
  // Goal: filled bins stand over iterations, not scans, below a line at all of them. Method: the
  // series of one chain and of all.
  const SmallArchive source;
  const plot::Figure one = spelling_trace(source, small_box(), 0, 3);
  ASSERT_EQ(one.panels.size(), 2U);
  const auto steps = all_of<plot::Steps>(one.panels[0]);
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_THAT(steps[0].points,
              ElementsAre(plot::Point{0, 0}, plot::Point{10, 1}, plot::Point{20, 1}));
  const auto lines = all_of<plot::HorizontalLine>(one.panels[0]);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].y, 2);
  EXPECT_EQ(lines[0].label, "all 2");
  EXPECT_EQ(all_of<plot::Steps>(spelling_trace(source, small_box(), {}, 0).panels[1]).size(), 2U);
  EXPECT_EQ(failure_of([&] { spelling_trace(source, small_box(), 2, 0); }, "no chain 2"),
            base::ExitCode::usage);
}

TEST(SpellingFigures, NothingToDrawIsSaid) {
  // Goal: without a kept animation one learns why and what to do. Method: none at all; none of a
  // chain; no such chain.
  const auto drawn = [](double animations, std::optional<std::uint64_t> chain) {
    return [=] {
      spelling_animations(SmallArchive({.animations = animations}), small_box(),
                          {.chain = chain, .count = 4});
    };
  };
  EXPECT_EQ(failure_of(drawn(0, {}), "no satisfying animation to draw; run more scans"),
            base::ExitCode::environment);
  EXPECT_EQ(failure_of(drawn(1, 1), "no satisfying animation of chain 1"),
            base::ExitCode::environment);
  EXPECT_EQ(failure_of(drawn(1, 2), "no chain 2"), base::ExitCode::usage);
}

}  // namespace
}  // namespace sleight::cli
