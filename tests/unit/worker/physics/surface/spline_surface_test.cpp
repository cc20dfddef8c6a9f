// Goal: SplineSurface returns the spline's heights, slopes and fields at any place. Earlier queries
// don't matter. SplineSurface builds only the patches that it needs. Method: use surfaces of
// infinitely many random control points. Compare them with sums over basis functions in long double
// (reference_surface.h). Count the requests for control points. surface_bounds_test.cpp tests
// bounds.
#include "worker/physics/surface/spline_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <set>
#include <stdexcept>
#include <vector>

#include "tests/support/numbers.h"
#include "tests/unit/worker/physics/simulator/dice.h"
#include "tests/unit/worker/physics/surface/reference_surface.h"

namespace sleight::physics {
namespace {

using testing::controls_of;
using testing::Dice;
using testing::height_error_m;
using testing::k_unit;
using testing::random_controls;
using testing::reference_at;
using testing::ReferencePlace;
using testing::slope_error;
using testing::surface_of;

constexpr double k_height_m = 0.02;
constexpr double k_spacings_m[] = {1e-3, 0.0037, 0.01, 0.125, 1};
constexpr double k_reaches[] = {3, 300, 1e6};  ///< cells from the origin

bool same(const SurfacePlace& a, const SurfacePlace& b) {
  return a.height_m == b.height_m && a.slope_x == b.slope_x && a.slope_y == b.slope_y;
}

bool same(const SurfaceBounds& a, const SurfaceBounds& b) {
  return a.top_m == b.top_m && a.slope == b.slope && a.hollow_per_m == b.hollow_per_m &&
         a.bump_per_m == b.bump_per_m;
}

/// Calls take(surface, x_m, y_m) on fine and coarse grids, for places near the origin and far from
/// it. Some places are on grid lines.
template <class Take>
void for_each_place(std::uint64_t seed, int per_reach, Take&& take) {
  Dice dice(seed, 0);
  for (const double spacing_m : k_spacings_m) {
    const StaticSurface surface =
        surface_of(random_controls(dice.below(1000), k_height_m), spacing_m);
    for (const double reach : k_reaches) {
      for (int n = 0; n < per_reach; ++n) {
        double column = dice.within(reach);
        double row = dice.within(reach);
        if (dice.one_in(8)) column = std::floor(column);
        if (dice.one_in(8)) row = std::floor(row);
        take(surface, column * spacing_m, row * spacing_m);
      }
    }
  }
}

TEST(SplineSurface, HasTheHeightsAndSlopesOfTheDefinition) {
  // Goal: heights and slopes are right for grid indices of both signs, up to a million. Method:
  // compare heights and slopes with the reference's sums. The tolerance is the rounding error for
  // heights and indices of this size.
  int places = 0;
  for_each_place(1, 400, [&](const StaticSurface& surface, double x_m, double y_m) {
    SplineSurface spline(surface);
    const SurfacePlace got = spline.at(x_m, y_m);
    const ReferencePlace expected = reference_at(surface, x_m, y_m);
    const double slope_room = slope_error(surface, k_height_m, x_m, y_m);
    ASSERT_NEAR(got.height_m, static_cast<double>(expected.height),
                height_error_m(surface, k_height_m, x_m, y_m))
        << x_m << ' ' << y_m << " spacing " << surface.spacing_m;
    ASSERT_NEAR(got.slope_x, static_cast<double>(expected.slope_x), slope_room);
    ASSERT_NEAR(got.slope_y, static_cast<double>(expected.slope_y), slope_room);
    ++places;
  });
  EXPECT_EQ(places, 5 * 3 * 400);
}

TEST(SplineSurface, HasTheFieldsOfTheDefinition) {
  // Goal: restitution and friction are right and stay in their ranges. Method: compare both with
  // the reference's sums.
  for_each_place(2, 200, [&](const StaticSurface& surface, double x_m, double y_m) {
    const SurfaceControl got = SplineSurface(surface).fields_at(x_m, y_m);
    const ReferencePlace expected = reference_at(surface, x_m, y_m);
    const double room = height_error_m(surface, 1, x_m, y_m);
    ASSERT_NEAR(got.restitution, static_cast<double>(expected.restitution), room);
    ASSERT_NEAR(got.friction, static_cast<double>(expected.friction), 2 * room);
    ASSERT_EQ(got.height_m, 0);
    ASSERT_TRUE(got.restitution >= 0 && got.restitution <= 1 && got.friction >= 0);
  });
}

TEST(SplineSurface, WeightsAreTheDefinitions) {
  // Goal: weights_at() returns how much the values at a place depend on each control point. Method:
  // test that no weight is negative, that the sum of the weights is 1, and that weighted sums give
  // heights and fields. If a single point is raised by 1, the height must be that point's weight.
  Dice dice(6, 0);
  for_each_place(6, 50, [&](const StaticSurface& surface, double x_m, double y_m) {
    SplineSurface spline(surface);
    const GridIndex patch = spline.patch_at(x_m, y_m);
    const std::array<GridIndex, 16> points = SplineSurface::support(patch);
    const std::array<double, 16> weights = spline.weights_at(x_m, y_m);
    double sum = 0;
    double height_m = 0;
    double friction = 0;
    for (std::size_t k = 0; k < 16; ++k) {
      ASSERT_EQ(points[k].i, patch.i - 1 + static_cast<std::int32_t>(k / 4));
      ASSERT_EQ(points[k].j, patch.j - 1 + static_cast<std::int32_t>(k % 4));
      ASSERT_GE(weights[k], 0);
      sum += weights[k];
      height_m += weights[k] * surface.controls->at(points[k]).height_m;
      friction += weights[k] * surface.controls->at(points[k]).friction;
    }
    ASSERT_NEAR(sum, 1, 16 * k_unit);
    ASSERT_NEAR(height_m, spline.at(x_m, y_m).height_m, 32 * k_unit * k_height_m);
    ASSERT_NEAR(friction, spline.fields_at(x_m, y_m).friction, 32 * k_unit);

    const std::size_t chosen = dice.below(16);
    const GridIndex only = points[chosen];
    SplineSurface raised(surface_of(controls_of([only](GridIndex at) {
                                      return SurfaceControl{.height_m = at == only ? 1.0 : 0.0};
                                    }),
                                    surface.spacing_m));
    ASSERT_NEAR(raised.at(x_m, y_m).height_m, weights[chosen], 16 * k_unit);
  });
}

TEST(SplineSurface, TakesPlacesThatRoundIntoTheNextCell) {
  // Goal: heights, slopes and weights are right just below a grid line, where a place's offset in
  // its cell rounds to 1. Method: test places that are below 0 by less than the offset's last bit.
  const StaticSurface surface = surface_of(random_controls(7, k_height_m), 0.01);
  SplineSurface spline(surface);
  const SurfacePlace at_zero = spline.at(0, 0);
  for (const double x_m : {-1e-20, -1e-300, -0.0, -5e-324}) {
    const SurfacePlace place = spline.at(x_m, x_m);
    EXPECT_NEAR(place.height_m, at_zero.height_m, 16 * k_unit * k_height_m);
    EXPECT_NEAR(place.slope_x, at_zero.slope_x, 64 * k_unit * k_height_m / 0.01);
    for (const double weight : spline.weights_at(x_m, x_m))
      EXPECT_TRUE(weight >= 0 && weight <= 1);
  }
}

TEST(SplineSurface, OfEqualPointsIsConstant) {
  // Goal: a surface of equal control points has the points' values and slopes of 0 everywhere, up
  // to rounding. Restitution and friction stay exactly in range.
  Dice dice(8, 0);
  for (const SurfaceControl all : {SurfaceControl{0.3, 1, 0}, SurfaceControl{-17, 0, 0.7},
                                   SurfaceControl{1.0 / 3, 0.1, 1e-3}, SurfaceControl{}}) {
    const double spacing_m = k_spacings_m[dice.below(5)];
    SplineSurface spline(surface_of(controls_of([all](GridIndex) { return all; }), spacing_m));
    const double height_m = std::fabs(all.height_m);
    for (int n = 0; n < 1000; ++n) {
      const double x_m = dice.within(100);
      const double y_m = dice.within(1);
      const SurfacePlace place = spline.at(x_m, y_m);
      ASSERT_NEAR(place.height_m, all.height_m, 8 * k_unit * height_m);
      ASSERT_NEAR(place.slope_x, 0, 32 * k_unit * height_m / spacing_m);
      ASSERT_NEAR(place.slope_y, 0, 32 * k_unit * height_m / spacing_m);
      const SurfaceControl fields = spline.fields_at(x_m, y_m);
      ASSERT_NEAR(fields.restitution, all.restitution, 8 * k_unit * all.restitution);
      ASSERT_NEAR(fields.friction, all.friction, 8 * k_unit * all.friction);
      ASSERT_TRUE(fields.restitution >= 0 && fields.restitution <= 1 && fields.friction >= 0);
    }
  }
}

struct Question {
  double x_m = 0;
  double y_m = 0;
  double width_m = 0;
};

struct Answer {
  SurfacePlace place;
  SurfaceBounds bounds;
  SurfaceControl fields;
};

Answer answer_of(SplineSurface& spline, const Question& q) {
  // For x < 0, query the place before the bounds.
  Answer answer;
  if (q.x_m < 0) answer.place = spline.at(q.x_m, q.y_m);
  answer.bounds = spline.bounds_in(q.x_m, q.x_m + q.width_m, q.y_m - q.width_m, q.y_m);
  answer.place = spline.at(q.x_m, q.y_m);
  answer.fields = spline.fields_at(q.x_m, q.y_m);
  return answer;
}

void expect_same(const Answer& a, const Answer& b) {
  EXPECT_TRUE(same(a.place, b.place));
  EXPECT_TRUE(same(a.bounds, b.bounds));
  EXPECT_EQ(a.fields, b.fields);
}

TEST(SplineSurface, AnswersDoNotDependOnWhatWasAskedBefore) {
  // Goal: answers don't depend on earlier queries (spline_surface.h, invariant 1), even with so
  // many patches that their table grows several times. Method: make the same queries in two orders
  // and on new surfaces, and compare the bits of the answers. Multiples of powers of two are common
  // in grids and bad for hashes, so use them for some indices.
  constexpr double k_spacing_m = 0.01;
  const StaticSurface surface = surface_of(random_controls(9, k_height_m), k_spacing_m);
  Dice dice(9, 0);
  std::vector<Question> questions;
  for (int n = 0; n < 4000; ++n) {
    const double far = n % 4 == 0 ? 65536 * std::floor(dice.within(20'000)) : 0;
    questions.push_back(
        {.x_m = (far + dice.within(60)) * k_spacing_m,
         .y_m = dice.within(n % 3 == 0 ? 1e6 : 60) * k_spacing_m,
         .width_m = dice.one_in(3) ? 0.0 : 3 * k_spacing_m * dice.stream.uniform()});
  }
  SplineSurface first(surface);
  std::vector<Answer> answers;
  for (const Question& question : questions)
    answers.push_back(answer_of(first, question));
  EXPECT_GT(first.patches_made(), 8000U);

  SplineSurface second(surface);
  for (int n = 0; n < 8000; ++n) {
    const std::size_t k = dice.below(questions.size());
    expect_same(answer_of(second, questions[k]), answers[k]);
    if (dice.one_in(4)) expect_same(answer_of(second, questions[k]), answers[k]);
  }
  EXPECT_GT(second.patches_made(), 4000U);
  for (std::size_t k = 0; k < questions.size(); k += 3) {
    SplineSurface fresh(surface);
    expect_same(answer_of(fresh, questions[k]), answers[k]);
  }
}

TEST(SplineSurface, MakesOnlyThePatchesAskedFor) {
  // Goal: a surface builds only the patches that queries need, and requests each control point
  // once. Method: count the requests to a table of 10,000 x 10,000 points. Flat ground surrounds
  // the table.
  constexpr double k_spacing_m = 0.005;
  const auto table = controls_of([](GridIndex at) {
    const bool inside = at.i >= 0 && at.i < 10'000 && at.j >= 0 && at.j < 10'000;
    return SurfaceControl{.height_m = inside ? 1e-3 * ((at.i * 7 + at.j * 3) % 11) : 0.0};
  });
  SplineSurface spline(surface_of(table, k_spacing_m));
  EXPECT_EQ(table->calls(), 0U);
  Dice dice(10, 0);
  std::set<GridIndex> asked;
  for (int n = 0; n < 5000; ++n) {
    const double centre_m = n % 2 == 0 ? 25 : 0;
    const double x_m = centre_m + dice.within(0.1);
    const double y_m = centre_m + dice.within(0.1);
    const SurfacePlace place = spline.at(x_m, y_m);
    EXPECT_TRUE(x_m > -3 * k_spacing_m || same(place, {}));
    asked.insert(spline.patch_at(x_m, y_m));
  }
  EXPECT_EQ(spline.patches_made(), asked.size());
  std::set<GridIndex> points;
  const auto hang_on = [&](GridIndex patch) {
    for (const GridIndex point : SplineSurface::support(patch))
      points.insert(point);
  };
  std::ranges::for_each(asked, hang_on);
  EXPECT_EQ(table->calls(), points.size());
  // bounds_in() builds the patches that a rectangle or line touches. A second call builds nothing.
  spline.bounds_in(10, 10 + 3.5 * k_spacing_m, 10, 10);
  spline.bounds_in(10, 10 + 3.5 * k_spacing_m, 10, 10);
  spline.at(10 + 2.2 * k_spacing_m, 10);
  EXPECT_EQ(spline.patches_made(), asked.size() + 4);
  for (std::int32_t i = 0; i < 4; ++i)
    hang_on({2000 + i, 2000});
  EXPECT_EQ(table->calls(), points.size());
}

TEST(SplineSurface, OutlivesPointsThatFail) {
  // Goal: an exception while a patch is built leaves no incomplete patch. Method: use control
  // points that throw at the first request of each patch.
  const auto points = random_controls(11, k_height_m);
  bool fails = false;
  const auto failing = controls_of([&](GridIndex index) {
    if (fails) throw std::runtime_error("no memory");
    return points->at(index);
  });
  SplineSurface spline(surface_of(failing, 0.01));
  SplineSurface expected(surface_of(points, 0.01));
  for (int n = 0; n < 300; ++n) {
    const double x_m = 0.013 * n;
    fails = true;
    EXPECT_THROW(spline.at(x_m, x_m), std::runtime_error);
    fails = false;
    EXPECT_TRUE(same(spline.at(x_m, x_m), expected.at(x_m, x_m)));
    EXPECT_EQ(spline.patches_made(), expected.patches_made());
  }
}

TEST(SplineSurfaceDeathTest, RefusesPlacesBeyondItsIndices) {
  // Goal: if a place has no valid patch index, a query for it stops the process. All other places
  // have heights. Method: test the last valid patch on each side, places beyond these patches,
  // infinity and NaN.
  SplineSurface spline(surface_of(random_controls(12, k_height_m), 0.5));
  constexpr double k_cells = k_patch_index_max;
  for (const double column : {k_cells, -k_cells}) {
    const double x_m = 0.5 * (column + 0.25);
    EXPECT_EQ(spline.patch_at(x_m, 0).i, static_cast<std::int32_t>(column));
    EXPECT_LE(std::fabs(spline.at(x_m, x_m).height_m), k_height_m);
    EXPECT_LE(spline.at(x_m, x_m).height_m, spline.bounds_in(x_m, x_m, x_m, x_m).top_m);
    EXPECT_LE(spline.fields_at(x_m, x_m).restitution, 1);
  }
  for (const double x_m : {0.5 * (k_cells + 1), -0.5 * (k_cells + 0.5), 1e300, -1e300, k_infinity,
                           std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_DEATH(spline.at(x_m, 0), "check failed");
    EXPECT_DEATH(spline.at(0, x_m), "check failed");
    EXPECT_DEATH(static_cast<void>(spline.patch_at(x_m, 0)), "check failed");
    EXPECT_DEATH(static_cast<void>(spline.fields_at(0, x_m)), "check failed");
    EXPECT_DEATH(spline.bounds_in(0, x_m, 0, 0), "check failed");
  }
  EXPECT_DEATH(spline.bounds_in(1, 0, 0, 0), "check failed");
}

}  // namespace
}  // namespace sleight::physics
