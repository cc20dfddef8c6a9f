#include "clients/plot/axis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/support/numbers.h"
#include "tests/unit/clients/plot/examples.h"

namespace sleight::plot {
namespace {

TEST(Ticks, AreOneTwoFiveMultiples) {
  // Goal: ticks have readable labels and are whole multiples of a step. The step is 1, 2 or 5 times
  // a power of ten.
  const Ticks ticks = nice_ticks({0.4, 1.8}, 8);
  EXPECT_EQ(ticks.values, (std::vector<double>{0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8}));
  EXPECT_EQ(ticks.labels.front(), "0.4");
  EXPECT_EQ(ticks.labels.back(), "1.8");
  EXPECT_EQ(nice_ticks({0, 1000}, 6).labels,
            (std::vector<std::string>{"0", "200", "400", "600", "800", "1000"}));
  EXPECT_EQ(nice_ticks({-1, 1}, 5).labels,
            (std::vector<std::string>{"−1.0", "−0.5", "0", "0.5", "1.0"}));
  EXPECT_EQ(nice_ticks({0, 3e6}, 4).labels,
            (std::vector<std::string>{"0", "1×10⁶", "2×10⁶", "3×10⁶"}));
  EXPECT_EQ(nice_ticks({-2e-9, 0}, 3).labels,
            (std::vector<std::string>{"−2×10⁻⁹", "−1×10⁻⁹", "0"}));
}

TEST(Ticks, StayInsideDifferAndAreFew) {
  // Goal: for any range, ticks ascend inside the range and have different labels. There are never
  // more ticks than requested. If five or more are requested, there are at least two. Method: use
  // 20,000 random ranges over 60 powers of ten, some far from zero.
  MadeUp made_up(3);
  for (int i = 0; i < 20000; ++i) {
    const double span = std::pow(10.0, -30 + 60 * made_up.uniform());
    const double low = span * (made_up.uniform() - 0.5) * std::pow(10.0, 6 * made_up.uniform());
    const auto count_max = static_cast<std::size_t>(5 + 10 * made_up.uniform());
    const Range range{low, low + span};
    const Ticks ticks = nice_ticks(range, count_max);
    ASSERT_GE(ticks.values.size(), 2U) << low << " " << span << " " << count_max;
    ASSERT_LE(ticks.values.size(), count_max) << low << " " << span;
    ASSERT_EQ(ticks.values.size(), ticks.labels.size());
    const std::set<std::string> different(ticks.labels.begin(), ticks.labels.end());
    ASSERT_EQ(different.size(), ticks.labels.size()) << low << " " << span << " " << count_max;
    for (std::size_t k = 0; k < ticks.values.size(); ++k) {
      ASSERT_GE(ticks.values[k], range.low);
      ASSERT_LE(ticks.values[k], range.high);
      if (k > 0) {
        ASSERT_LT(ticks.values[k - 1], ticks.values[k]);
      }
    }
  }
}

TEST(Ranges, FollowTheFinitePoints) {
  // Goal: gaps and infinities don't affect an axis. A trace fills the width of its panel. Other
  // shapes get a margin.
  Panel panel{
      .series = {Line{.points = {{0, 1}, {5, k_nan}, {10, k_infinity}, {8, 3}, {k_nan, 99}}}}};
  PanelRanges ranges = ranges_of(panel);
  EXPECT_EQ(ranges.x, (Range{0, 10}));
  EXPECT_DOUBLE_EQ(ranges.y.low, 0.9);
  EXPECT_DOUBLE_EQ(ranges.y.high, 3.1);
  panel.series.push_back(Disc{.center = {20, 2}, .radius_x = 1});
  ranges = ranges_of(panel);
  EXPECT_LT(ranges.x.low, 0);
  EXPECT_GT(ranges.x.high, 21);
  panel.x_range = Range{2, 4};
  EXPECT_EQ(ranges_of(panel).x, (Range{2, 4}));
}

TEST(Ranges, OfNothingOneAndConstantCanBeDrawn) {
  // Goal: any points give an axis with low < high and distinct ticks. Method: use panels that
  // contain no point, a constant, two neighbouring doubles, or only NaN.
  for (const double value : {0.0, 1.0, -7e8, 1e-300, -1e149, 3e-9}) {
    for (const double other : {value, std::nextafter(value, k_infinity)}) {
      const PanelRanges ranges =
          ranges_of(Panel{.series = {Line{.points = {{value, value}, {other, other}}}}});
      for (const Range range : {ranges.x, ranges.y}) {
        ASSERT_LT(range.low, range.high) << value;
        ASSERT_LE(range.low, value);
        ASSERT_GE(range.high, other);
        const Ticks ticks = nice_ticks(range, 6);
        ASSERT_GE(ticks.values.size(), 2U) << value;
        ASSERT_NE(ticks.labels[0], ticks.labels[1]) << value;
      }
    }
  }
  EXPECT_EQ(ranges_of(Panel{}).y, (Range{0, 1}));
  EXPECT_EQ(ranges_of(Panel{.series = {Line{.points = {{k_nan, k_nan}}}}}).x, (Range{0, 1}));
}

TEST(Ranges, EqualAspectGrowsTheOneWithRoom) {
  // Goal: with equal aspect, a unit has the same length on both axes. If an axis has room to spare,
  // its range grows, so nothing is cut off.
  const PanelRanges square{{0, 1}, {0, 1}};
  const PanelRanges wide = with_equal_aspect(square, 400, 100);
  EXPECT_EQ(wide.y, (Range{0, 1}));
  EXPECT_EQ(wide.x, (Range{-1.5, 2.5}));
  const PanelRanges high = with_equal_aspect(square, 100, 200);
  EXPECT_EQ(high.x, (Range{0, 1}));
  EXPECT_EQ(high.y, (Range{-0.5, 1.5}));
}

}  // namespace
}  // namespace sleight::plot
