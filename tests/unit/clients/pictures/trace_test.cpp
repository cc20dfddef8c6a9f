// Goal: long traces are thinned in bounded memory, and no spike is lost. If a dataset has a wrong
// shape, it is refused, and the error names it. Method: read a source that computes its values and
// records its longest read.
#include "clients/pictures/trace.h"
#include "clients/analysis/archive_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "common/archive/format.h"
#include "common/base/error.h"
#include "tests/support/refusals.h"

namespace sleight::pictures {
namespace {

constexpr std::uint64_t k_chains = 2;

/// A source of /sample_stats. A function of (chain, draw) computes the values.
class ComputedSource final : public archive::Source {
 public:
  using Value = std::function<double(std::uint64_t chain, std::uint64_t draw)>;

  ComputedSource(std::uint64_t draws, Value value) : draws_(draws), value_(std::move(value)) {
    archive::Group stats{.name = std::string(archive::k_sample_stats)};
    stats.datasets = {
        {.name = "chain", .type = archive::ElementType::i64, .dims = {{"chain", k_chains}}},
        {.name = "draw", .type = archive::ElementType::i64, .dims = {{"draw", draws}}},
        {.name = "lp", .dims = {{"chain", k_chains}, {"draw", draws}}},
        {.name = "flat", .dims = {{"draw", draws}}}};
    groups_ = {stats};
  }

  std::string name() const override { return "computed"; }
  const std::vector<archive::Group>& groups() const override { return groups_; }
  archive::Values read(std::string_view, std::string_view, std::uint64_t first,
                       std::uint64_t count) const override {
    longest_read = std::max(longest_read, count);
    std::vector<double> values(count);
    for (std::uint64_t i = 0; i < count; ++i) {
      values[i] = value_((first + i) / draws_, (first + i) % draws_);
    }
    return values;
  }

  mutable std::uint64_t longest_read = 0;

 private:
  std::uint64_t draws_;
  Value value_;
  std::vector<archive::Group> groups_;
};

TEST(Trace, ShortOnesAreWhole) {
  const ComputedSource source(k_trace_points_max, [](std::uint64_t chain, std::uint64_t draw) {
    return static_cast<double>(1'000'000 * chain + draw);
  });
  const auto points = trace(source, "lp", {.chain = 1, .draws = 0}, 2);
  ASSERT_EQ(points.size(), k_trace_points_max);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(points[i].x, static_cast<double>(i));
    EXPECT_EQ(points[i].y, 2.0 * static_cast<double>(1'000'000 + i));
  }
  EXPECT_EQ(trace(source, "lp", {.chain = 0, .draws = 7}, 1).size(), 7U);
}

TEST(Trace, LongOnesAreThinnedAndKeepSpikesAndEnds) {
  constexpr std::uint64_t draws = 1'000'003;
  const ComputedSource source(draws, [](std::uint64_t, std::uint64_t draw) {
    if (draw == 123'456) return 50.0;
    if (draw == 765'432) return -50.0;
    if (draw % 3 == 0) return std::numeric_limits<double>::quiet_NaN();
    return static_cast<double>(draw % 5);
  });
  const auto points = trace(source, "lp", {.chain = 1, .draws = 0}, 1);
  EXPECT_LE(points.size(), k_trace_points_max);
  EXPECT_GT(points.size(), k_trace_points_max / 2);
  EXPECT_LE(source.longest_read, 65536U);
  EXPECT_EQ(points.front().x, 0);
  EXPECT_EQ(points.back().x, static_cast<double>(draws - 1));
  const auto has = [&](double x, double y) {
    return std::ranges::any_of(points, [&](const auto& p) { return p.x == x && p.y == y; });
  };
  EXPECT_TRUE(has(123'456, 50));
  EXPECT_TRUE(has(765'432, -50));
  EXPECT_TRUE(std::ranges::is_sorted(points, std::less_equal<>{}, &plot::Point::x));
}

TEST(Trace, WrongShapesAreRefused) {
  const ComputedSource source(10, [](std::uint64_t, std::uint64_t) { return 0.0; });
  using base::ExitCode;
  EXPECT_EQ(tests::failure_of([&] { trace(source, "lp", {.chain = 2}, 1); }, "no chain 2"),
            ExitCode::usage);
  EXPECT_EQ(tests::failure_of([&] { trace(source, "none", {}, 1); }, "/sample_stats/none"),
            ExitCode::bad_archive);
  EXPECT_EQ(tests::failure_of([&] { trace(source, "flat", {}, 1); }, "/sample_stats/flat"),
            ExitCode::bad_archive);
  const auto rows = [&](const char* dataset, std::uint64_t columns, const analysis::Rows& range) {
    return tests::failure_of(
        [&] { read_rows(source, archive::k_sample_stats, dataset, columns, range); }, dataset);
  };
  EXPECT_EQ(analysis::read_rows(source, archive::k_sample_stats, "lp", 10, {1, 1}).size(), 10U);
  EXPECT_EQ(rows("lp", 2, {0, 1}), ExitCode::bad_archive);
  EXPECT_EQ(rows("lp", 10, {1, 2}), ExitCode::bad_archive);
  EXPECT_EQ(rows("flat", 1, {11, 0}), ExitCode::bad_archive);
  EXPECT_EQ(rows("flat", 1, {1, ~std::uint64_t{0}}), ExitCode::bad_archive);
}

}  // namespace
}  // namespace sleight::pictures
