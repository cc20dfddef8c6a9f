// Goal: what bounds_in says holds at every place of a rectangle, rounding included, and is not
// idle. Method: rectangles of all sizes over rough and smooth control points, at many places
// against heights and slopes as they are computed and against the definition's, its eigenvalues of
// second derivatives included; planes and paraboloids, for which the bounds are known.
#include <gtest/gtest.h>
#include <array>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/unit/worker/physics/simulator/dice.h"
#include "tests/unit/worker/physics/surface/reference_surface.h"
#include "worker/physics/surface/spline_surface.h"

namespace sleight::physics {
namespace {

using testing::controls_of;
using testing::Dice;
using testing::heights_of;
using testing::k_unit;
using testing::random_controls;
using testing::reference_at;
using testing::ReferencePlace;
using testing::surface_of;

struct Rectangle {
  double x_low_m = 0;
  double x_high_m = 0;
  double y_low_m = 0;
  double y_high_m = 0;
};

SurfaceBounds bounds_in(SplineSurface& spline, const Rectangle& r) {
  return spline.bounds_in(r.x_low_m, r.x_high_m, r.y_low_m, r.y_high_m);
}

/// Across up to so many patches; one in four is thin, one in eight a place.
Rectangle random_rectangle(Dice& dice, double reach_m, double size_m) {
  const auto length_m = [&] { return dice.one_in(4) ? 0.0 : size_m * dice.stream.uniform(); };
  Rectangle r;
  r.x_low_m = dice.within(reach_m);
  r.y_low_m = dice.within(reach_m);
  r.x_high_m = r.x_low_m + length_m();
  r.y_high_m = r.y_low_m + length_m();
  return r;
}

/// The greatest that was found at the places of a rectangle.
struct Found {
  double top_m = -1e300;
  double slope = 0;
  double hollow_per_m = 0;
  double bump_per_m = 0;

  void hold(const ReferencePlace& place, const SurfacePlace& computed) {
    top_m = std::max({top_m, static_cast<double>(place.height), computed.height_m});
    slope = std::max(
        {slope, static_cast<double>(place.slope()),
         std::sqrt(computed.slope_x * computed.slope_x + computed.slope_y * computed.slope_y)});
    hollow_per_m = std::max(hollow_per_m, static_cast<double>(place.second_most()));
    bump_per_m = std::max(bump_per_m, -static_cast<double>(place.second_least()));
  }
  bool within(const SurfaceBounds& bounds) const {
    return top_m <= bounds.top_m && slope <= bounds.slope && hollow_per_m <= bounds.hollow_per_m &&
           bump_per_m <= bounds.bump_per_m;
  }
};

/// Looks at the corners, at lines of the grid between them, and at random places.
Found found_in(SplineSurface& spline, const StaticSurface& surface, const Rectangle& r, int places,
               Dice& dice) {
  const auto coordinate = [&](double low_m, double high_m) {
    const std::uint64_t kind = dice.below(6);
    if (kind == 0) return low_m;
    if (kind == 1) return high_m;
    const double somewhere_m = low_m + (high_m - low_m) * dice.stream.uniform();
    if (kind > 2) return std::clamp(somewhere_m, low_m, high_m);
    const double line_m = std::round(somewhere_m / surface.spacing_m) * surface.spacing_m;
    return std::clamp(line_m, low_m, high_m);
  };
  Found found;
  for (int n = 0; n < places; ++n) {
    const double x_m = coordinate(r.x_low_m, r.x_high_m);
    const double y_m = coordinate(r.y_low_m, r.y_high_m);
    found.hold(reference_at(surface, x_m, y_m), spline.at(x_m, y_m));
  }
  return found;
}

/// Smooth waves some sixteen cells long.
std::shared_ptr<const SurfaceControls> waves(double height_m) {
  return heights_of([height_m](double i, double j) {
    return height_m * (std::sin(0.4 * i + 0.1 * j) + 0.5 * std::cos(0.15 * i - 0.35 * j));
  });
}

TEST(SurfaceBounds, HoldInEveryRectangle) {
  // Goal: no place of a rectangle is beyond its bounds, and over smooth ground, in rectangles of
  // about a patch, they are attained but for a share that control points between places explain.
  // Method: random rectangles of a place up to some hundred patches.
  for (const bool rough : {true, false}) {
    for (const double spacing_m : {1e-3, 0.0037, 0.125, 1.0}) {
      Dice dice(21, rough ? 0 : 1);
      const double height_m = 0.1 * spacing_m;
      const StaticSurface surface =
          surface_of(rough ? random_controls(21, height_m) : waves(height_m), spacing_m);
      SplineSurface spline(surface);
      for (int n = 0; n < 60; ++n) {
        const double cells = n % 3 == 0 ? 12 : 1.5;
        const Rectangle r = random_rectangle(dice, 200 * spacing_m, cells * spacing_m);
        const SurfaceBounds bounds = bounds_in(spline, r);
        const Found found = found_in(spline, surface, r, cells > 2 ? 300 : 80, dice);
        ASSERT_TRUE(found.within(bounds))
            << found.top_m << ' ' << bounds.top_m << ", " << found.slope << ' ' << bounds.slope
            << ", " << found.hollow_per_m << ' ' << bounds.hollow_per_m << ", " << found.bump_per_m
            << ' ' << bounds.bump_per_m;
        if (rough) continue;
        // Points two cells away from a lone place count too: slopes are up to 0.6 amplitudes per
        // cell, curvatures to 0.24, which themselves change by a third or so over two cells.
        EXPECT_LT(bounds.top_m - found.top_m, 1.1 * height_m);
        EXPECT_LT(bounds.slope - found.slope, 0.3 * height_m / spacing_m);
        EXPECT_LT(bounds.hollow_per_m - found.hollow_per_m,
                  0.15 * height_m / spacing_m / spacing_m);
        EXPECT_LT(bounds.bump_per_m - found.bump_per_m, 0.15 * height_m / spacing_m / spacing_m);
      }
    }
  }
}

TEST(SurfaceBounds, TheCheckSeesWhatIsBeyond) {
  // Goal: the test above can fail, by each of the four. Method: bounds that are a half too low, and
  // the bounds of another rectangle.
  const StaticSurface surface = surface_of(waves(0.001), 0.01);
  SplineSurface spline(surface);
  Dice dice(22, 0);
  const Rectangle all{0, 0.3, 0, 0.3};
  const SurfaceBounds bounds = bounds_in(spline, all);
  const Found found = found_in(spline, surface, all, 3000, dice);
  EXPECT_TRUE(found.within(bounds));
  for (double SurfaceBounds::*one : {&SurfaceBounds::top_m, &SurfaceBounds::slope,
                                     &SurfaceBounds::hollow_per_m, &SurfaceBounds::bump_per_m}) {
    SurfaceBounds low = bounds;
    low.*one *= 0.5;
    EXPECT_FALSE(found.within(low));
  }
  EXPECT_FALSE(found.within(bounds_in(spline, {0, 0.01, 0, 0.01})));
}

TEST(SurfaceBounds, OfPlanesAreTheirSlopes) {
  // Goal: planes have their slope as bound, no curvature, and no height above the corners of the
  // patches touched. Method: random planes, far rectangles too; the room is the documented margin
  // and, for curvature, the rounding of heights.
  Dice dice(23, 0);
  for (int n = 0; n < 200; ++n) {
    const double spacing_m = dice.one_in(2) ? 0.01 : 0.3;
    const double rise_i_m = dice.within(spacing_m);
    const double rise_j_m = dice.within(spacing_m);
    SplineSurface spline(surface_of(
        heights_of([=](double i, double j) { return 0.2 + rise_i_m * i + rise_j_m * j; }),
        spacing_m));
    const Rectangle r = random_rectangle(dice, 50 * spacing_m, 4 * spacing_m);
    const SurfaceBounds bounds = bounds_in(spline, r);
    const double slope = std::sqrt(rise_i_m * rise_i_m + rise_j_m * rise_j_m) / spacing_m;
    EXPECT_GE(bounds.slope, slope * (1 - 1e-12));
    EXPECT_LE(bounds.slope, slope * (1 + 1e-8) + 1e-10);
    // 6 second differences and 9 mixed ones of Bezier points, 64 units for each and their own.
    const double rounding_per_m = 15 * 72 * k_unit * 100 * spacing_m / spacing_m / spacing_m;
    EXPECT_LE(bounds.hollow_per_m, rounding_per_m);
    EXPECT_LE(bounds.bump_per_m, rounding_per_m);
    const GridIndex low = spline.patch_at(r.x_low_m, r.y_low_m);
    const GridIndex high = spline.patch_at(r.x_high_m, r.y_high_m);
    const double top_m = 0.2 + rise_i_m * (rise_i_m > 0 ? high.i + 1 : low.i) +
                         rise_j_m * (rise_j_m > 0 ? high.j + 1 : low.j);
    EXPECT_NEAR(bounds.top_m, top_m, 128 * k_unit * (0.2 + 120 * spacing_m));
  }
}

TEST(SurfaceBounds, OfParaboloidsAreTheirCurvatures) {
  // Goal: curvature bounds are attained where discs around rows (Gershgorin) are the eigenvalues.
  // Method: control points on z = a x^2 + b x y + c y^2, whose spline has these second derivatives
  // everywhere, with equal a and c or without b; in general they exceed by less than |b|.
  Dice dice(24, 0);
  for (int n = 0; n < 300; ++n) {
    constexpr double k_spacing_m = 0.05;
    const double a = dice.within(2);
    const double c = n % 3 == 0 ? a : dice.within(2);
    const double b = n % 3 == 1 ? 0 : dice.within(2);
    SplineSurface spline(surface_of(heights_of([=](double i, double j) {
                                      const double x = i * k_spacing_m;
                                      const double y = j * k_spacing_m;
                                      return a * x * x + b * x * y + c * y * y;
                                    }),
                                    k_spacing_m));
    const SurfaceBounds bounds = bounds_in(spline, random_rectangle(dice, 1, 0.2));
    const double gap = std::sqrt((a - c) * (a - c) + b * b);
    const double hollow = std::max(0.0, a + c + gap);
    const double bump = std::max(0.0, gap - a - c);
    constexpr double k_room = 1e-8;
    EXPECT_GE(bounds.hollow_per_m, hollow * (1 - 1e-12));
    EXPECT_GE(bounds.bump_per_m, bump * (1 - 1e-12));
    const double over = n % 3 == 2 ? std::fabs(b) : 0;
    EXPECT_LE(bounds.hollow_per_m, hollow + over + k_room);
    EXPECT_LE(bounds.bump_per_m, bump + over + k_room);
  }
}

/// The Bezier points of the cubic over four points of a B-spline, from where it begins and ends,
/// and how it leaves and comes there.
std::array<double, 4> bezier_of(const std::array<double, 4>& p) {
  const auto value = [&](std::size_t k) { return (p[k] + 4 * p[k + 1] + p[k + 2]) / 6; };
  const auto rise = [&](std::size_t k) { return (p[k + 2] - p[k]) / 2; };
  return {value(0), value(0) + rise(0) / 3, value(1) - rise(1) / 3, value(1)};
}

TEST(SurfaceBounds, OfOnePatchComeFromAllItsDifferences) {
  // Goal: each difference of the patch's sixteen Bezier points counts, also those that hardly weigh
  // where others would hide them. Method: one patch over random control points, over one line of
  // points and over one point, against the formulas of the bounds taken over all pairs, triples and
  // squares of neighbours.
  Dice dice(27, 0);
  for (int n = 0; n < 600; ++n) {
    const auto line = static_cast<double>(dice.below(4)) - 1;
    const auto other = static_cast<double>(dice.below(4)) - 1;
    const auto noises = random_controls(27 + dice.below(1000), 1);
    const auto given = [&](int i, int j) {
      if (n % 4 == 0) return i == line ? 1.0 : 0.0;
      if (n % 4 == 1) return j == line ? -1.0 : 0.0;
      if (n % 4 == 2) return i == line && j == other ? 1.0 : 0.0;
      return noises->at({i, j}).height_m;
    };
    std::array<std::array<double, 4>, 4> points{};
    for (int i = 0; i < 4; ++i)
      points[static_cast<std::size_t>(i)] =
          bezier_of({given(i - 1, -1), given(i - 1, 0), given(i - 1, 1), given(i - 1, 2)});
    for (std::size_t j = 0; j < 4; ++j) {
      const auto in_i = bezier_of({points[0][j], points[1][j], points[2][j], points[3][j]});
      for (std::size_t i = 0; i < 4; ++i)
        points[i][j] = in_i[i];
    }
    const auto p = [&](int i, int j) {
      return points[static_cast<std::size_t>(i + 1)][static_cast<std::size_t>(j + 1)];
    };
    double top = -1e300;
    double x = 0;
    double y = 0;
    double xy = 0;
    double second_most = -1e300;
    double second_least = 1e300;
    for (int i = -1; i <= 2; ++i) {
      for (int j = -1; j <= 2; ++j) {
        top = std::max(top, p(i, j));
        if (i > -1) x = std::max(x, std::fabs(p(i, j) - p(i - 1, j)));
        if (j > -1) y = std::max(y, std::fabs(p(i, j) - p(i, j - 1)));
        if (i > -1 && j > -1)
          xy = std::max(xy, std::fabs(p(i, j) - p(i - 1, j) - p(i, j - 1) + p(i - 1, j - 1)));
        const bool inner_i = i == 0 || i == 1;
        const bool inner_j = j == 0 || j == 1;
        const auto hold = [&](double second) {
          second_most = std::max(second_most, second);
          second_least = std::min(second_least, second);
        };
        if (inner_i) hold(p(i - 1, j) - 2 * p(i, j) + p(i + 1, j));
        if (inner_j) hold(p(i, j - 1) - 2 * p(i, j) + p(i, j + 1));
      }
    }
    SplineSurface spline(surface_of(
        controls_of([&](GridIndex at) { return SurfaceControl{.height_m = given(at.i, at.j)}; }),
        0.5));
    const SurfaceBounds bounds = spline.bounds_in(0.1, 0.3, 0.2, 0.2);
    EXPECT_NEAR(bounds.top_m, top, 1e-13);
    EXPECT_NEAR(bounds.slope, 3 * 2 * std::sqrt(x * x + y * y), 1e-7);
    EXPECT_NEAR(bounds.hollow_per_m, 4 * std::max(0.0, 6 * second_most + 9 * xy), 1e-6);
    EXPECT_NEAR(bounds.bump_per_m, 4 * std::max(0.0, 9 * xy - 6 * second_least), 1e-6);
  }
}

TEST(SurfaceBounds, AreOfThePatchesTouchedAndNoOthers) {
  // Goal: a rectangle's bounds are the greatest over its patches, one by one; a bump elsewhere
  // doesn't enter. Method: each patch asked alone; and flat ground with one point raised, which
  // sixteen patches hang on.
  Dice dice(25, 0);
  constexpr double k_spacing_m = 0.25;
  const StaticSurface surface = surface_of(random_controls(25, 1), k_spacing_m);
  SplineSurface spline(surface);
  for (int n = 0; n < 200; ++n) {
    const Rectangle r = random_rectangle(dice, 20, 2);
    const SurfaceBounds bounds = bounds_in(spline, r);
    const GridIndex low = spline.patch_at(r.x_low_m, r.y_low_m);
    const GridIndex high = spline.patch_at(r.x_high_m, r.y_high_m);
    SurfaceBounds all{.top_m = -1};
    for (std::int32_t i = low.i; i <= high.i; ++i) {
      for (std::int32_t j = low.j; j <= high.j; ++j) {
        const double x_m = (i + 0.5) * k_spacing_m;
        const double y_m = (j + 0.5) * k_spacing_m;
        const SurfaceBounds one = spline.bounds_in(x_m, x_m, y_m, y_m);
        all = {.top_m = std::max(all.top_m, one.top_m),
               .slope = std::max(all.slope, one.slope),
               .hollow_per_m = std::max(all.hollow_per_m, one.hollow_per_m),
               .bump_per_m = std::max(all.bump_per_m, one.bump_per_m)};
      }
    }
    EXPECT_EQ(bounds.top_m, all.top_m);
    EXPECT_EQ(bounds.slope, all.slope);
    EXPECT_EQ(bounds.hollow_per_m, all.hollow_per_m);
    EXPECT_EQ(bounds.bump_per_m, all.bump_per_m);
  }

  SplineSurface raised(surface_of(
      heights_of([](double i, double j) { return i == 7 && j == -3 ? 0.5 : 0.0; }), k_spacing_m));
  for (std::int32_t i = 0; i < 15; ++i) {
    for (std::int32_t j = -10; j < 5; ++j) {
      const double x_m = (i + 0.5) * k_spacing_m;
      const double y_m = (j + 0.5) * k_spacing_m;
      const SurfaceBounds bounds = raised.bounds_in(x_m, x_m, y_m, y_m);
      const bool hangs_on_it = i >= 5 && i <= 8 && j >= -5 && j <= -2;
      EXPECT_EQ(bounds.top_m > 0, hangs_on_it);
      EXPECT_EQ(bounds.slope > 0, hangs_on_it);
      EXPECT_EQ(bounds.hollow_per_m > 0, hangs_on_it);
      EXPECT_EQ(bounds.bump_per_m > 0, hangs_on_it);
    }
  }
}

TEST(SurfaceBounds, HoldWithHeightsThatDrownDifferences) {
  // Goal: "rounding included", where it is all there is. Method: heights near 1 that differ by a
  // few of their last bits, flat, tilted and rough: places where computed slopes are rounding, and
  // heights are as high as their points; and deep points in the row and column that weigh least at
  // a patch's far corner.
  Dice dice(26, 0);
  for (int n = 0; n < 20'000; ++n) {
    const std::uint64_t seed = dice.below(1U << 30U);
    const double base_m = 1 + dice.stream.uniform();
    const double tilt_i = std::floor(dice.within(5));
    const double tilt_j = std::floor(dice.within(5));
    const double noise = n % 3 == 0 ? 0 : std::ldexp(1.0, static_cast<int>(dice.below(40)));
    const bool deep = n % 5 == 0;
    const auto noises = random_controls(seed, noise);
    const StaticSurface surface = surface_of(
        heights_of([=](double i, double j) {
          if (deep && (i < 0 || j < 0)) return -2.0;
          const double bits =
              noises->at({static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)}).height_m;
          return base_m + 0x1p-52 * (tilt_i * i + tilt_j * j + bits);
        }),
        1);
    SplineSurface spline(surface);
    const SurfaceBounds bounds = spline.bounds_in(0.5, 0.5, 0.5, 0.5);
    const auto place_in_cell = [&] {
      const double close = std::ldexp(1.0, -1 - static_cast<int>(dice.below(52)));
      const std::uint64_t kind = dice.below(4);
      return kind == 0 ? close : kind == 1 ? 1 - close : kind == 2 ? 0 : dice.stream.uniform();
    };
    for (int k = 0; k < 8; ++k) {
      const SurfacePlace place = spline.at(place_in_cell(), place_in_cell());
      ASSERT_LE(place.height_m, bounds.top_m);
      ASSERT_LE(std::sqrt(place.slope_x * place.slope_x + place.slope_y * place.slope_y),
                bounds.slope);
    }
    if (n % 10 == 0) {
      Found found;
      found.hold(reference_at(surface, place_in_cell(), place_in_cell()), {.height_m = -9});
      ASSERT_TRUE(found.within(bounds));
    }
  }
}

}  // namespace
}  // namespace sleight::physics
