#include "worker/worlds/dice/random_table.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/normal.hpp>
#include <cmath>

#include "common/random/distributions.h"
#include "tests/statistical/support/chi_square.h"
#include "tests/unit/worker/worlds/dice/support.h"
#include "worker/physics/surface/spline_surface.h"

namespace sleight::worlds::dice {
namespace {

TableParameters table_of() {
  return testing::all_random().world.table;
}

TEST(RandomTable, IsAFunctionOfKeyAndPlace) {
  // Goal: a control point depends only on the table's key and the point's place. When and in which
  // order points are read doesn't matter. Method: give two tables the same key, and read them in
  // opposite orders. Also compare with a table that has another key.
  const TableParameters parameters = table_of();
  const RandomTable one(parameters, 7, {});
  const RandomTable same(parameters, 7, {});
  const RandomTable other(parameters, 8, {});
  std::vector<SurfaceControl> there;
  for (std::int32_t i = -5; i < 5; ++i)
    there.push_back(one.at({i, -i}));
  for (std::int32_t i = 4; i >= -5; --i) {
    EXPECT_EQ(same.at({i, -i}), there[static_cast<std::size_t>(i + 5)]);
    EXPECT_NE(other.at({i, -i}).height_m, same.at({i, -i}).height_m);
    EXPECT_NE(one.at({i, 1 - i}).height_m, one.at({i, -i}).height_m);
  }
  // A larger table has the same points where both have points.
  TableParameters larger = parameters;
  larger.columns = 1000;
  EXPECT_EQ(RandomTable(larger, 7, {}).at({3, 3}), one.at({3, 3}));
}

TEST(RandomTable, DrawsItsDistributions) {
  // Goal: heights are normal, restitution and friction are uniform, and neighbours and fields are
  // independent. Method: test 40,000 points by chi-square, with twenty equally likely cells for
  // each field. Also test pairs of neighbours and pairs of fields. Each test fails by chance once
  // in 10^4 runs.
  const TableParameters parameters = table_of();
  constexpr int k_cells = 20;
  const auto cell = [](double p) {
    return std::min(static_cast<std::size_t>(p * k_cells), std::size_t{k_cells - 1});
  };
  const boost::math::normal normal(0, parameters.height_sd_m);
  std::vector<std::vector<double>> counts(3, std::vector<double>(k_cells, 0));
  std::vector<double> pairs(16, 0);
  std::vector<double> fields(16, 0);
  for (std::uint64_t key = 0; key < 10; ++key) {
    const RandomTable table(parameters, key, {});
    for (std::int32_t i = -32; i < 31; ++i) {
      for (std::int32_t j = -32; j < 32; ++j) {
        const SurfaceControl point = table.at({i, j});
        const auto height_p = [&](const SurfaceControl& c) {
          return boost::math::cdf(normal, c.height_m);
        };
        const double restitution_p = (point.restitution - 0.3) / 0.4;
        counts[0][cell(height_p(point))] += 1;
        counts[1][cell(restitution_p)] += 1;
        counts[2][cell((point.friction - 0.2) / 0.4)] += 1;
        const auto quarter = [](double p) {
          return std::min(static_cast<std::size_t>(4 * p), std::size_t{3});
        };
        fields[4 * quarter(height_p(point)) + quarter(restitution_p)] += 1;
        if (i % 2 == 0)
          pairs[4 * quarter(height_p(point)) + quarter(height_p(table.at({i + 1, j})))] += 1;
      }
    }
  }
  for (const auto& one : counts)
    EXPECT_GT(statistical::chi_square_p(one, std::vector<double>(k_cells, 1.0 / k_cells)), 1e-4);
  EXPECT_GT(statistical::chi_square_p(pairs, std::vector<double>(16, 1.0 / 16)), 1e-4);
  EXPECT_GT(statistical::chi_square_p(fields, std::vector<double>(16, 1.0 / 16)), 1e-4);
}

TEST(RandomTable, CostsNothingWhereNobodyLooks) {
  // Goal: a table of a hundred million points costs as little as a table of ten points. Method:
  // create such a table, and read two of its corners and one place on its surface.
  TableParameters parameters = table_of();
  parameters.columns = 10'000;
  parameters.rows = 10'000;
  const auto table = std::make_shared<RandomTable>(parameters, 1, Overrides{});
  EXPECT_NE(table->at(first_of(parameters)).height_m, 0);
  EXPECT_NE(table->at(last_of(parameters)).height_m, 0);
  physics::SplineSurface surface(
      {.name = "table", .controls = table, .spacing_m = parameters.spacing_m});
  EXPECT_NE(surface.at(100, -100).height_m, 0);
  EXPECT_EQ(surface.patches_made(), 1U);
}

TEST(RandomTable, HasAnApron) {
  // Goal: beyond its sides, the table is flat and has the mean restitution and the mean friction.
  // Method: read points just beyond each side, for an even number of columns and an odd number of
  // rows.
  TableParameters parameters = table_of();
  parameters.columns = 4;
  parameters.rows = 3;
  EXPECT_EQ(first_of(parameters), (GridIndex{-2, -1}));
  EXPECT_EQ(last_of(parameters), (GridIndex{1, 1}));
  const RandomTable table(parameters, 3, {});
  for (const GridIndex beyond :
       {GridIndex{-3, 0}, GridIndex{2, 0}, GridIndex{0, -2}, GridIndex{0, 2}}) {
    EXPECT_EQ(table.at(beyond).height_m, 0);
    EXPECT_DOUBLE_EQ(table.at(beyond).restitution, 0.5);
    EXPECT_DOUBLE_EQ(table.at(beyond).friction, 0.4);
  }
  EXPECT_NE(table.at({-2, -1}).height_m, 0);
  EXPECT_NE(table.at({1, 1}).height_m, 0);
}

TEST(RandomTable, ConstantFieldsAreConstant) {
  // Goal: a field without uncertainty has its fixed value and doesn't contribute to the density.
  // Any other value has zero density.
  const TableParameters parameters = Parameters{}.world.table;
  const SurfaceControl point = control_of_key(parameters, 5, {0, 0});
  EXPECT_EQ(point.restitution, 0.5);
  EXPECT_EQ(point.friction, 0.4);
  EXPECT_EQ(log_density_of(parameters, point),
            (random::Normal{.mean = 0, .sd = parameters.height_sd_m}.log_density(point.height_m)));
  EXPECT_EQ(log_density_of(parameters, {.height_m = 0, .restitution = 0.6, .friction = 0.4}),
            -std::numeric_limits<double>::infinity());
}

TEST(RandomTable, OverridesTakeTheirPlaces) {
  // Goal: an override affects only its own point, and lists of overrides stay sorted. Method: set
  // three overrides, and set one of them twice. Compare with a table that has no overrides.
  const TableParameters parameters = table_of();
  Overrides overrides;
  for (const GridIndex index :
       {GridIndex{3, 1}, GridIndex{-2, 5}, GridIndex{3, 0}, GridIndex{-2, 5}})
    set_override(overrides, {.index = index,
                             .control = {.height_m = 0.001 * static_cast<double>(overrides.size()),
                                         .restitution = 0.5,
                                         .friction = 0.5}});
  ASSERT_EQ(overrides.size(), 3U);
  EXPECT_EQ(overrides[0].index, (GridIndex{-2, 5}));
  EXPECT_EQ(overrides[0].control.height_m, 0.003);
  EXPECT_EQ(overrides[1].index, (GridIndex{3, 0}));
  const RandomTable plain(parameters, 4, {});
  const RandomTable table(parameters, 4, overrides);
  for (std::int32_t i = -4; i < 5; ++i) {
    for (std::int32_t j = -4; j < 6; ++j) {
      const Override* one = find_override(overrides, {i, j});
      EXPECT_EQ(table.at({i, j}), one != nullptr ? one->control : plain.at({i, j}));
    }
  }
}

TEST(RandomTable, SaysWhatChanged) {
  // Goal: if two tables have the same key and size, changed_from() lists the points whose overrides
  // differ. Otherwise, it returns nothing. Method: compare lists of overrides in which points were
  // added, removed or changed.
  const TableParameters parameters = table_of();
  const auto point = [](double height_m) {
    return SurfaceControl{.height_m = height_m, .restitution = 0.5, .friction = 0.5};
  };
  const Overrides before{{{0, 0}, point(1e-3)}, {{1, 0}, point(2e-3)}, {{2, 0}, point(3e-3)}};
  const Overrides after{{{-1, 0}, point(1e-3)}, {{1, 0}, point(2e-3)}, {{2, 0}, point(4e-3)}};
  const RandomTable old_table(parameters, 4, before);
  const RandomTable new_table(parameters, 4, after);
  EXPECT_EQ(new_table.changed_from(old_table), (std::vector<GridIndex>{{-1, 0}, {0, 0}, {2, 0}}));
  EXPECT_EQ(old_table.changed_from(old_table), std::vector<GridIndex>{});
  EXPECT_EQ(RandomTable(parameters, 5, after).changed_from(old_table), std::nullopt);
  TableParameters larger = parameters;
  larger.columns += 1;
  EXPECT_EQ(RandomTable(larger, 4, before).changed_from(old_table), std::nullopt);
}

}  // namespace
}  // namespace sleight::worlds::dice
