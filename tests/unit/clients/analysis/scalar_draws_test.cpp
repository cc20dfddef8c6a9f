// Goal: scalars are read entry by entry in bounded memory, and draws without a finite value rank
// below all others. Method: read a source in which each value is its own index, check every value,
// and limit the longest read.
#include "clients/analysis/scalar_draws.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/archive/format.h"
#include "common/base/error.h"
#include "tests/support/numbers.h"
#include "tests/support/refusals.h"

namespace sleight::analysis::scalar_draws_test {

struct Shape {
  std::uint64_t chains = 2;
  std::uint64_t draws = 100;
  std::vector<archive::Dimension> inner;
};

/// A source with one variable. The value of element n is n.
class CountingSource final : public archive::Source {
 public:
  explicit CountingSource(const Shape& shape) {
    archive::DatasetSpec spec{.name = "x",
                              .dims = {{"chain", shape.chains}, {"draw", shape.draws}}};
    spec.dims.insert(spec.dims.end(), shape.inner.begin(), shape.inner.end());
    groups_ = {{.name = std::string(archive::k_posterior), .datasets = {spec}}};
  }
  std::string name() const override { return "counting"; }
  const std::vector<archive::Group>& groups() const override { return groups_; }
  archive::Values read(std::string_view, std::string_view, std::uint64_t first,
                       std::uint64_t count) const override {
    longest_read = std::max(longest_read, count);
    std::vector<double> values(count);
    for (std::uint64_t i = 0; i < count; ++i)
      values[i] = static_cast<double>(first + i);
    return values;
  }
  mutable std::uint64_t longest_read = 0;

 private:
  std::vector<archive::Group> groups_;
};

void expect_right(const Shape& shape, const DrawRange& range) {
  const CountingSource source(shape);
  const Quantity quantity = state_variables(source).at(0);
  std::uint64_t expected_entry = 0;
  for_each_scalar(source, quantity, quantity.entries(), range,
                  [&](std::uint64_t entry, std::vector<double>& values) {
                    EXPECT_EQ(entry, expected_entry++);
                    ASSERT_EQ(values.size(), range.chains * range.count);
                    for (std::uint64_t i = 0; i < values.size(); ++i) {
                      const std::uint64_t draw = range.first + (i % range.count) * range.stride;
                      const std::uint64_t row = i / range.count * shape.draws + draw;
                      ASSERT_EQ(values[i], static_cast<double>(row * quantity.entries() + entry));
                    }
                  });
  EXPECT_EQ(expected_entry, quantity.entries());
  EXPECT_LE(source.longest_read, 65536U);
}

TEST(ScalarDraws, EveryValueIsOfItsEntryChainAndDraw) {
  expect_right({.inner = {}}, {.chains = 2, .first = 50, .count = 50, .stride = 1});
  expect_right({.inner = {{"a", 3}, {"b", 5}}},
               {.chains = 2, .first = 1, .count = 33, .stride = 3});
  // The draws' values are too far apart in the dataset to be read together.
  expect_right({.draws = 50, .inner = {{"a", 9000}}},
               {.chains = 2, .first = 2, .count = 5, .stride = 9});
  expect_right({.chains = 1, .draws = 70000, .inner = {{"a", 70}}},
               {.chains = 1, .first = 0, .count = 70000, .stride = 1});
}

TEST(ScalarDraws, WhatIsLookedAtIsBounded) {
  for (const std::uint64_t chains : {std::uint64_t{1}, std::uint64_t{3}, k_chains_max}) {
    for (const std::uint64_t available : {1ULL, 6ULL, 12345ULL, 1'000'000'000ULL}) {
      for (const std::uint64_t scalars : {1ULL, 20ULL, 5000ULL, 1'000'000'000ULL}) {
        const DrawRange range = bounded_range(chains, 7, available, scalars);
        EXPECT_LE(chains * range.count, k_scalar_draws_max);
        EXPECT_LE((range.count - 1) * range.stride, available - 1);
        EXPECT_GE(range.count, std::min(available, k_chain_draws_min / 2));
        EXPECT_LE(scalars_max(range) * chains * range.count, k_all_draws_max);
        EXPECT_GE(scalars_max(range), 1U);
      }
    }
  }
  EXPECT_EQ(bounded_range(4, 0, 10000, 20).stride, 1U);
  EXPECT_EQ(bounded_range(4, 5, 0, 20).count, 0U);
}

TEST(ScalarDraws, EntriesAreNamed) {
  const CountingSource source({.inner = {{"a", 3}, {"b", 5}}});
  const Quantity quantity = state_variables(source).at(0);
  EXPECT_EQ(quantity.entry_name(0), "x[0, 0]");
  EXPECT_EQ(quantity.entry_name(7), "x[1, 2]");
  EXPECT_EQ((Quantity{.group = archive::k_posterior, .name = "y"}).entry_name(0), "y");
}

TEST(ScalarDraws, OtherShapesAreRefused) {
  const CountingSource source({.inner = {}});
  const auto refused = [&](const Quantity& quantity, const DrawRange& range) {
    return tests::failure_of(
        [&] { for_each_scalar(source, quantity, 1, range, [](auto, auto&) {}); },
        "/posterior/|one number|chain|draw");
  };
  const Quantity right{.group = archive::k_posterior, .name = "x"};
  EXPECT_EQ(refused({.group = archive::k_posterior, .name = "y"}, {.chains = 2, .count = 1}),
            base::ExitCode::bad_archive);
  EXPECT_EQ(refused(right, {.chains = 3, .count = 1}), base::ExitCode::bad_archive);
  EXPECT_EQ(refused(right, {.chains = 2, .first = 99, .count = 2}), base::ExitCode::bad_archive);
  EXPECT_EQ(refused({.group = archive::k_posterior, .name = "x", .inner = {{"a", 2}}},
                    {.chains = 2, .count = 1}),
            base::ExitCode::bad_archive);
}

TEST(StandIn, LiesBelowAllAndFurthestFromTheMiddle) {
  std::vector<double> values{3, -k_infinity, 5, k_nan, 4, -k_infinity};
  const StandIns found = with_stand_in(values);
  EXPECT_EQ(found.minus_infinite, 2U);
  EXPECT_EQ(found.nan, 1U);
  EXPECT_EQ(values[0], 3);
  EXPECT_EQ(values[1], values[3]);
  EXPECT_EQ(values[1], values[5]);
  // The substitute for -inf is farther from the median than every finite value.
  EXPECT_LT(values[1], 3 - (5 - 3));
}

TEST(StandIn, ManyCasesStayApart) {
  std::vector<double> equal{1e300, -k_infinity};
  with_stand_in(equal);
  EXPECT_LT(equal[1], equal[0]);
  std::vector<double> none{-k_infinity, k_nan};
  EXPECT_EQ(with_stand_in(none).all(), 2U);
  EXPECT_EQ(none, (std::vector<double>{0, 0}));
  std::vector<double> finite{1, 2};
  EXPECT_EQ(with_stand_in(finite).all(), 0U);
  EXPECT_EQ(finite, (std::vector<double>{1, 2}));
}

}  // namespace sleight::analysis::scalar_draws_test
