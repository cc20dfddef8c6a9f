#include "clients/plot/decimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "tests/support/numbers.h"
#include "tests/unit/clients/plot/examples.h"

namespace sleight::plot {
namespace {

TEST(Decimation, KeepsTheExtremesOfEachColumn) {
  // Goal: thinning keeps the lowest and the highest value of each pixel column, in order. At most
  // four points of a column remain. Method: thin a million random points on 800 columns. A few
  // points are spikes. Compare each column's extremes before and after thinning.
  MadeUp made_up(5);
  std::vector<Point> points;
  constexpr std::size_t k_count = 1'000'000;
  constexpr std::size_t k_columns = 800;
  for (std::size_t i = 0; i < k_count; ++i) {
    const double spike = made_up.uniform() < 1e-5 ? 100 : 1;
    points.push_back(
        {static_cast<double>(i) * k_columns / k_count, spike * (made_up.uniform() - 0.5)});
  }
  const std::vector<Point> thin = decimated_line(points, 1.0);
  EXPECT_LE(thin.size(), 4 * k_columns);
  EXPECT_TRUE(std::ranges::is_sorted(thin, {}, &Point::x));
  const auto extremes = [](const std::vector<Point>& all) {
    std::vector<Range> out(k_columns, {1e9, -1e9});
    for (const Point point : all) {
      Range& range = out[static_cast<std::size_t>(point.x)];
      range = {std::min(range.low, point.y), std::max(range.high, point.y)};
    }
    return out;
  };
  EXPECT_EQ(extremes(thin), extremes(points));
  EXPECT_EQ(thin.front(), points.front());
  EXPECT_EQ(thin.back(), points.back());
}

TEST(Decimation, LeavesShortLinesAndPathsThatTurnBack) {
  // Goal: thinning keeps all points of a sparse line, and all points of a path that turns back. A
  // vertical stroke keeps only its ends and extremes.
  const std::vector<Point> sparse = {{0, 0}, {1, 5}, {2, -5}, {3, 0}};
  EXPECT_EQ(decimated_line(sparse, 1.0), sparse);
  const std::vector<Point> back = {{0, 0}, {3, 1}, {0, 2}, {3, 3}};
  EXPECT_EQ(decimated_line(back, 1.0), back);
  const std::vector<Point> vertical = {{0.5, 0}, {0.5, 2}, {0.5, 9}, {0.5, -1}, {0.5, 3}};
  EXPECT_EQ(decimated_line(vertical, 1.0),
            (std::vector<Point>{{0.5, 0}, {0.5, 9}, {0.5, -1}, {0.5, 3}}));
  EXPECT_TRUE(decimated_line({}, 1.0).empty());
  const std::vector<Point> one = {{4, 4}};
  EXPECT_EQ(decimated_line(one, 1.0), one);
}

TEST(Decimation, BoundsMarkersByTheArea) {
  // Goal: if a million dots lie on 100 x 50 pixels, one dot per pixel remains.
  MadeUp made_up(9);
  std::vector<Point> points;
  for (int i = 0; i < 1'000'000; ++i)
    points.push_back({100 * made_up.uniform(), 50 * made_up.uniform()});
  points.push_back({k_nan, 1});
  EXPECT_EQ(decimated_markers(points, 1.0).size(), 5000U);
  EXPECT_EQ(decimated_markers(std::vector<Point>{{1, 1}, {-1, 1}, {1, -1}}, 1.0).size(), 3U);
}

TEST(Runs, AreWhatLiesBetweenGaps) {
  // Goal: a NaN or an infinity splits a line, and neither part contains the invalid point.
  const std::vector<Point> points = {{k_nan, 0},      {1, 1}, {2, 2},    {3, k_nan},
                                     {4, -1.0 / 0.0}, {5, 5}, {6, k_nan}};
  const auto runs = drawable_runs(points);
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[0].size(), 2U);
  EXPECT_EQ(runs[1].front(), (Point{5, 5}));
  EXPECT_TRUE(drawable_runs({}).empty());
}

TEST(Steps, HoldEachValueToTheNext) {
  // Goal: a stepped line has a corner at each change of value, but no corner beside a gap.
  const auto corners = stepped(std::vector<Point>{{0, 1}, {1, 2}, {2, k_nan}, {3, 4}});
  ASSERT_EQ(corners.size(), 5U);
  EXPECT_EQ(corners[1], (Point{1, 1}));
  EXPECT_EQ(corners[2], (Point{1, 2}));
  EXPECT_TRUE(std::isnan(corners[3].y));
  EXPECT_EQ(corners[4], (Point{3, 4}));
}

}  // namespace
}  // namespace sleight::plot
