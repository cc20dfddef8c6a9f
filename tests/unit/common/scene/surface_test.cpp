// Goal: a surface returns the heights of its formula. Where a control point is missing, there is no
// height. Method: use a plane and a bowl. The bowl's spline differs from its formula by a constant.
// Remove one control point at a time.
#include "common/scene/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "common/random/stream.h"

namespace sleight::scene {
namespace {

constexpr double k_spacing_m = 0.25;

template <class Height>
std::vector<ControlPoint> points_of(std::span<const Vec3> places_m, double half_m,
                                    const Height& height) {
  std::vector<ControlPoint> points;
  for (const auto& [i, j] : indices_about(places_m, half_m, k_spacing_m))
    points.push_back({.i = i, .j = j, .height_m = height(i * k_spacing_m, j * k_spacing_m)});
  return points;
}

TEST(Surface, HasTheHeightsOfItsFormula) {
  const std::vector<Vec3> places_m{{0.1, -3.2, 0}, {-7.77, 2, 0}};
  random::Stream stream({.seed = 3, .purpose = random::Purpose::scene}, 0);
  const auto plane = [](double x, double y) { return 2 * x - 3 * y + 1; };
  // For x^2, the spline exceeds the formula by spacing^2 / 3.
  const auto bowl = [](double x, double y) { return x * x + 2 * x * y; };
  const Surface flat(points_of(places_m, 0.5, plane), k_spacing_m);
  const Surface bent(points_of(places_m, 0.5, bowl), k_spacing_m);
  for (int i = 0; i < 200; ++i) {
    const Vec3& about = places_m[static_cast<std::size_t>(i % 2)];
    const double x_m = about.x() + stream.uniform() - 0.5;
    const double y_m = about.y() + stream.uniform() - 0.5;
    ASSERT_TRUE(flat.height_m(x_m, y_m).has_value());
    EXPECT_NEAR(*flat.height_m(x_m, y_m), plane(x_m, y_m), 1e-12);
    EXPECT_NEAR(*bent.height_m(x_m, y_m), bowl(x_m, y_m) + k_spacing_m * k_spacing_m / 3, 1e-12);
  }
  EXPECT_FALSE(flat.height_m(3, 3));
  EXPECT_FALSE(flat.height_m(1e300, 0));
  EXPECT_FALSE(flat.height_m(std::nan(""), 0));
}

TEST(Surface, HasPatchesWithAllTheirPoints) {
  const std::vector<Vec3> here{{0.1, 0.1, 0}};
  std::vector<ControlPoint> points = points_of(here, 0, [](double, double) { return 1.0; });
  EXPECT_EQ(points.size(), 16U);
  EXPECT_TRUE(std::ranges::is_sorted(points, [](const auto& a, const auto& b) {
    return std::pair(a.j, a.i) < std::pair(b.j, b.i);
  }));
  const Surface whole(points, k_spacing_m);
  ASSERT_EQ(whole.patches().size(), 1U);
  EXPECT_EQ(whole.patches()[0].i, 0);
  EXPECT_NEAR(whole.height_m(0.1, 0.1).value(), 1, 1e-15);
  for (std::size_t missing = 0; missing < points.size(); ++missing) {
    std::vector<ControlPoint> fewer = points;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(missing));
    const Surface broken(fewer, k_spacing_m);
    EXPECT_TRUE(broken.patches().empty());
    EXPECT_FALSE(broken.height_m(0.1, 0.1));
  }
}

}  // namespace
}  // namespace sleight::scene
