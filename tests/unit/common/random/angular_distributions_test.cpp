// Goal: directions and rotations are drawn uniformly, and their densities are right. Method: test
// draws with chi-square tests. The expected counts follow from the geometry of the circle, the
// sphere and rotations.
#include "common/random/angular_distributions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/math/angle.h"
#include "common/random/linear_distributions.h"
#include "tests/support/numbers.h"
#include "tests/unit/common/random/chi_square.h"

namespace sleight::random::angular_distributions_test {

using math::k_pi;
using math::k_two_pi;

TEST(UniformDirection2, covers_the_circle_evenly) {
  Stream stream = test_stream();
  std::vector<int> counts(64);
  for (int i = 0; i < k_draws; ++i) {
    const math::Vec2 d = UniformDirection2{}.draw(stream);
    ASSERT_NEAR(math::norm(d), 1, 1e-15);
    const double turn = std::atan2(d.y(), d.x()) / k_two_pi + 0.5;
    ++counts[std::min<std::size_t>(63, static_cast<std::size_t>(64 * turn))];
  }
  expect_plausible(chi_square_p_value(counts), "direction in the plane");
}

// Counts random unit vectors in 8 x 8 cells of equal area (height by azimuth), and returns the
// chi-square p-value.
template <class Draw>
double sphere_p_value(const Draw& draw) {
  Stream stream = test_stream();
  std::vector<int> counts(64);
  for (int i = 0; i < k_draws; ++i) {
    const math::Vec3 d = draw(stream);
    EXPECT_NEAR(math::norm(d), 1, 2e-15);
    const double height = 0.5 * (d.z() + 1);
    const double turn = std::atan2(d.y(), d.x()) / k_two_pi + 0.5;
    const auto row = std::min<std::size_t>(7, static_cast<std::size_t>(8 * height));
    const auto column = std::min<std::size_t>(7, static_cast<std::size_t>(8 * turn));
    ++counts[8 * row + column];
  }
  return chi_square_p_value(counts);
}

TEST(UniformDirection3, covers_the_sphere_evenly_about_every_axis) {
  const UniformDirection3 d;
  expect_plausible(sphere_p_value([&](Stream& s) { return d.draw(s); }), "about z");
  expect_plausible(sphere_p_value([&](Stream& s) {
                     const math::Vec3 v = d.draw(s);
                     return math::Vec3(v.y(), v.z(), v.x());
                   }),
                   "about x");
  // Negative control: if random points of a cube are normalised, they are denser towards the cube's
  // corners.
  EXPECT_LT(sphere_p_value([&](Stream& s) {
              const Uniform side{.low = -1, .high = 1};
              const double x = side.draw(s);
              const double y = side.draw(s);
              return math::normalized(math::Vec3(x, y, side.draw(s)));
            }),
            1e-12);
}

TEST(UniformRotation, takes_every_vector_evenly_over_the_sphere) {
  const UniformRotation d;
  for (const math::Vec3& v : {math::Vec3(1, 0, 0), math::Vec3(0, 1, 0), math::Vec3(0, 0, 1),
                              math::normalized(math::Vec3(1, -2, 3))}) {
    expect_plausible(sphere_p_value([&](Stream& s) { return math::rotated(d.draw(s), v); }),
                     "image of a vector");
  }
}

TEST(UniformRotation, has_haars_distribution_of_angles) {
  // The angle t of a random rotation has density (1 - cos t)/pi on [0, pi].
  const auto cdf = [](double t) { return (t - std::sin(t)) / k_pi; };
  expect_plausible(
      p_value_of_draws(
          [](Stream& s) {
            const math::Quat q = UniformRotation{}.draw(s);
            return 2 * std::acos(std::min(1.0, std::fabs(q.w())));
          },
          [&](double a, double b) { return cdf(std::min(b, k_pi)) - cdf(std::max(a, 0.0)); }),
      "angle");
}

TEST(Directions, densities_are_one_over_the_size_of_the_sphere) {
  EXPECT_NEAR(UniformDirection2{}.log_density({0.6, 0.8}), -std::log(2 * k_pi), 1e-15);
  EXPECT_NEAR(UniformDirection3{}.log_density({0.6, 0, -0.8}), -std::log(4 * k_pi), 1e-15);
  EXPECT_NEAR(UniformRotation{}.log_density({0.5, 0.5, -0.5, 0.5}), -std::log(2 * k_pi * k_pi),
              1e-15);
  EXPECT_EQ(UniformDirection2{}.log_density({0.6, 0.7}), -k_infinity);
  EXPECT_EQ(UniformDirection3{}.log_density({0, 0, 0}), -k_infinity);
  EXPECT_EQ(UniformRotation{}.log_density({1, 0, 0, 1e-3}), -k_infinity);
  Stream stream = test_stream();
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(std::isfinite(UniformDirection2{}.log_density(UniformDirection2{}.draw(stream))));
    ASSERT_TRUE(std::isfinite(UniformDirection3{}.log_density(UniformDirection3{}.draw(stream))));
    ASSERT_TRUE(std::isfinite(UniformRotation{}.log_density(UniformRotation{}.draw(stream))));
  }
}

TEST(AngularDistributionsDeathTest, refuse_what_is_no_distribution) {
  EXPECT_DEATH((UniformDirection3{}.log_density({k_nan, 0, 0})), "check failed");
}

}  // namespace sleight::random::angular_distributions_test
