// Goal: the bounds that bounds_in() returns hold at every place of a rectangle, even for rounded
// values, and are not too loose. Method: use random rectangles over rough and smooth ground.
// Compare the bounds with the heights and slopes that the surface computes. Also compare with
// heights, slopes and eigenvalues of second derivatives by definition.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/unit/worker/physics/simulator/dice.h"
#include "tests/unit/worker/physics/surface/reference_surface.h"
#include "worker/physics/surface/spline_surface.h"

namespace sleight::physics {
namespace {

using testing::Dice;
using testing::heights_of;
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

/// A rectangle with sides up to size_m. One side in four has length 0.
Rectangle random_rectangle(Dice& dice, double reach_m, double size_m) {
  const auto length_m = [&] { return dice.one_in(4) ? 0.0 : size_m * dice.stream.uniform(); };
  Rectangle r;
  r.x_low_m = dice.within(reach_m);
  r.y_low_m = dice.within(reach_m);
  r.x_high_m = r.x_low_m + length_m();
  r.y_high_m = r.y_low_m + length_m();
  return r;
}

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

/// Examines the corners, grid lines between them, and random places.
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

/// Smooth waves about sixteen cells long.
std::shared_ptr<const SurfaceControls> waves(double height_m) {
  return heights_of([height_m](double i, double j) {
    return height_m * (std::sin(0.4 * i + 0.1 * j) + 0.5 * std::cos(0.15 * i - 0.35 * j));
  });
}

TEST(SurfaceBounds, HoldInEveryRectangle) {
  // Goal: no place of a rectangle exceeds the rectangle's bounds. Over smooth ground, the values
  // almost reach the bounds; the remaining gap is due to nearby control points outside the
  // rectangle. Method: test random rectangles, from single points to rectangles of more than a
  // hundred patches.
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
        // Bounds include control points up to two cells away from a place. Slopes reach 0.6
        // amplitudes per cell, and curvatures reach 0.24. Slopes and curvatures change by about a
        // third over two cells.
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
  // Goal: the test above fails if one of the four bounds is too low. Method: halve one bound at a
  // time. Also use the bounds of another rectangle.
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

TEST(SurfaceBounds, AreOfThePatchesTouchedAndNoOthers) {
  // Goal: each bound of a rectangle is the maximum of this bound over the rectangle's patches.
  // Method: for random rectangles, compare a rectangle's bounds with the bounds of its single
  // patches. Also test flat ground with one raised point, which must affect exactly sixteen
  // patches.
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
  // Goal: bounds hold even where all differences of heights are rounding errors. Method: use flat,
  // tilted and rough ground. Heights are 1 to 2 m and differ only in their last bits. In some
  // cases, one row and one column of control points are much lower. These points have the least
  // weight at a patch's far corner.
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
