// Goal: angles, directions and rotations are drawn from the densities that they state.
// Method: chi-square of draws against Boost.Math's normal summed over images, and against the plain
// geometry of circle, sphere and rotations; densities against the same sums, and integrated.
#include "common/random/angular_distributions.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <boost/math/distributions/normal.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <vector>

#include "common/math/angle.h"
#include "common/random/linear_distributions.h"
#include "tests/support/numbers.h"
#include "tests/unit/common/random/chi_square.h"

namespace sleight::random::angular_distributions_test {

using math::k_pi;
using math::k_two_pi;

const std::vector<WrappedNormal> k_wrapped_normals = {
    {0, 1e-3}, {3.1, 0.2}, {-3.1, 1},      {0.5, 1.5}, {1, 2.5},  {1, 2.6},
    {-2, 5},   {100, 0.7}, {-50, 8.99999}, {0.3, 9},   {0.3, 50}, {k_pi, 1e-6},
};

// Images of the circle that carry any of the mass.
int images(const WrappedNormal& d) {
  return static_cast<int>((9 * d.sd + std::fabs(d.mean)) / k_two_pi) + 2;
}

double wrapped_mass(const WrappedNormal& d, double a, double b) {
  const boost::math::normal_distribution<double> normal(d.mean, d.sd);
  const double from = std::max(a, -k_pi);
  const double to = std::min(b, k_pi);
  double sum = 0;
  for (int k = -images(d); k <= images(d); ++k) {
    const double shift = k_two_pi * k;
    sum += from + shift > d.mean
               ? boost::math::cdf(boost::math::complement(normal, from + shift)) -
                     boost::math::cdf(boost::math::complement(normal, to + shift))
               : boost::math::cdf(normal, to + shift) - boost::math::cdf(normal, from + shift);
  }
  return sum;
}

double wrapped_log_density(const WrappedNormal& d, double x) {
  const boost::math::normal_distribution<double> normal(d.mean, d.sd);
  double sum = 0;
  for (int k = -images(d); k <= images(d); ++k)
    sum += boost::math::pdf(normal, x + k_two_pi * k);
  return std::log(sum);
}

std::string name_of(const WrappedNormal& d) {
  return fmt::format("wrapped normal, mean {}, sd {}", d.mean, d.sd);
}

TEST(WrappedNormal, draws_as_the_sum_over_images_says) {
  for (const WrappedNormal& d : k_wrapped_normals) {
    const auto draw = [&](Stream& stream) {
      const double x = d.draw(stream);
      EXPECT_GE(x, -k_pi);
      EXPECT_LT(x, k_pi);
      return x;
    };
    expect_plausible(
        p_value_of_draws(draw, [&](double a, double b) { return wrapped_mass(d, a, b); }),
        name_of(d));
  }
}

TEST(WrappedNormal, density_is_the_sum_over_images) {
  for (const WrappedNormal& d : k_wrapped_normals) {
    Stream stream = test_stream();
    for (int i = 0; i < 1000; ++i) {
      // Half of them typical, half from anywhere that the oracle's sum does not underflow.
      const double x = i % 2 == 0 ? d.draw(stream) : UniformAngle{}.draw(stream);
      const double expected = wrapped_log_density(d, x);
      if (!(expected > -600)) continue;
      // Turns of the mean shift the angle by up to 16 times 2.5e-16, or so many sd.
      const double slack = 1e-12 + 1e-14 / d.sd * std::sqrt(1 + std::fabs(expected));
      ASSERT_NEAR(d.log_density(x), expected, slack) << name_of(d) << " at " << x;
    }
  }
}

TEST(WrappedNormal, densities_integrate_to_one) {
  for (const WrappedNormal& d : k_wrapped_normals) {
    // Outside 12 sd round the mean there is nothing; inside, the seam is no obstacle.
    const double half = std::min(k_pi, 12 * d.sd);
    const double integral = boost::math::quadrature::gauss_kronrod<double, 61>::integrate(
        [&](double s) {
          return half * std::exp(d.log_density(math::wrapped_angle(d.mean + half * s)));
        },
        -1.0, 1.0, 10, 1e-12);
    EXPECT_NEAR(integral, 1, 1e-10) << name_of(d);
  }
}

TEST(WrappedNormal, density_of_a_narrow_one_falls_off_without_underflow) {
  // (pi/2)^2 / (2e-12) = 1.2337e12 below the peak.
  const WrappedNormal narrow{.mean = 0, .sd = 1e-6};
  EXPECT_NEAR(narrow.log_density(k_pi / 2) / -1.2337005501361697e12, 1, 1e-10);
  EXPECT_NEAR(narrow.log_density(-k_pi) / narrow.log_density(std::nextafter(k_pi, 0)), 1, 1e-15);
}

TEST(UniformAngle, is_flat_on_the_half_open_circle) {
  expect_plausible(p_value_of_draws([](Stream& s) { return UniformAngle{}.draw(s); },
                                    [](double a, double b) {
                                      return (std::min(b, k_pi) - std::max(a, -k_pi)) / k_two_pi;
                                    }),
                   "uniform angle");
  EXPECT_NEAR(UniformAngle{}.log_density(1), -std::log(k_two_pi), 1e-15);
  EXPECT_EQ(UniformAngle{}.log_density(-k_pi), UniformAngle{}.log_density(0));
  EXPECT_EQ(UniformAngle{}.log_density(k_pi), -k_infinity);
  EXPECT_EQ(UniformAngle{}.log_density(-4), -k_infinity);
}

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

// Chi-square of unit vectors on 8 x 8 cells of the sphere, equal in area: height by azimuth, about
// the axis that `turn` takes to z.
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
  // Negative control: a normalised point of the cube is denser towards its corners.
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
  Stream stream = test_stream();
  EXPECT_DEATH((WrappedNormal{.mean = 0, .sd = 0}.draw(stream)), "check failed");
  EXPECT_DEATH((WrappedNormal{.mean = k_infinity, .sd = 1}.draw(stream)), "check failed");
  EXPECT_DEATH((WrappedNormal{}.log_density(k_nan)), "check failed");
  EXPECT_DEATH((UniformAngle{}.log_density(k_nan)), "check failed");
  EXPECT_DEATH((UniformDirection3{}.log_density({k_nan, 0, 0})), "check failed");
}

}  // namespace sleight::random::angular_distributions_test
