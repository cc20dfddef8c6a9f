// Goal: truncated normal numbers and their densities are accurate, from the centre to the farthest
// tails. Method: test the draws of each interval below with a chi-square test. Compare log
// densities with MPFR at 1,500 bits. Integrate the densities, to find faults that the comparison
// misses.
#include "common/random/truncated_normal.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <mpfr.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <vector>

#include "tests/support/numbers.h"
#include "tests/unit/common/random/chi_square.h"

namespace sleight::random {
namespace {

/// Owns one MPFR number. Not copyable.
class Number {
 public:
  explicit Number(double x) {
    mpfr_init2(value_, 1500);
    mpfr_set_d(value_, x, MPFR_RNDN);
  }
  ~Number() { mpfr_clear(value_); }
  Number(const Number&) = delete;
  Number& operator=(const Number&) = delete;
  mpfr_ptr get() { return value_; }

 private:
  mpfr_t value_;
};

// Sets `mass` to the probability that a standard normal number is between a and b. Both a and b may
// have either sign.
void set_mass(Number& mass, double a, double b) {
  // Use the side where erfc is small, so that the difference of the tails is exact.
  const double sign = a > 0 ? 1 : -1;
  Number near(sign > 0 ? a : -b);
  Number far(sign > 0 ? b : -a);
  Number root(2);
  mpfr_sqrt(root.get(), root.get(), MPFR_RNDN);
  for (Number* edge : {&near, &far}) {
    mpfr_div(edge->get(), edge->get(), root.get(), MPFR_RNDN);
    mpfr_erfc(edge->get(), edge->get(), MPFR_RNDN);
  }
  mpfr_sub(mass.get(), near.get(), far.get(), MPFR_RNDN);
  mpfr_div_ui(mass.get(), mass.get(), 2, MPFR_RNDN);
}

// The mean is 0 and the standard deviation is 1, so that MPFR and the code use exactly the same
// bounds.
struct Bounds {
  double low = 0;
  double high = 0;
};

const std::vector<Bounds> k_intervals = {
    {-k_infinity, k_infinity},
    {-1, 2},
    {-0.125, 0.25},
    {-2, k_infinity},
    {-k_infinity, 0.5},
    {-k_infinity, -0.5},
    {0, k_infinity},
    {-k_infinity, 0},
    {0, 0.5},
    {0, 2.5},
    {-0.001, 2.49},
    {-0.001, 2.6},
    {-0.001, k_infinity},
    {-0.5, 30},
    {0.25, 0.5},
    {0.25, 3},
    {2, k_infinity},
    {3.9, k_infinity},
    {4.1, k_infinity},
    {3, 3.5},
    {3, 3.0009765625},
    {8, k_infinity},
    {8, 8.03125},
    {8, 8.5},
    {8, 9},
    {-k_infinity, -8},
    {-9, -8},
    {40, k_infinity},
    {-40.0078125, -40},
    {1000, k_infinity},
    {1000, 1000.0009765625},
    {1e8, k_infinity},
    {1e8, 1e8 + 0x1p-23},
    {-1e-10, 1e-10},
    {0, 1e-200},
};

std::string name_of(const Bounds& bounds) {
  return fmt::format("[{}, {}]", bounds.low, bounds.high);
}

TEST(TruncatedNormal, draws_as_mpfr_says) {
  for (const Bounds& bounds : k_intervals) {
    // Near 1e8, neighbouring doubles are too far apart to show the distribution. See the next test.
    if (std::fabs(bounds.low) >= 1e8) continue;
    const TruncatedNormal d{.mean = 0, .sd = 1, .low = bounds.low, .high = bounds.high};
    Number whole(0);
    set_mass(whole, d.low, d.high);
    const auto mass = [&](double a, double b) {
      Number part(0);
      set_mass(part, std::max(a, d.low), std::min(b, d.high));
      mpfr_div(part.get(), part.get(), whole.get(), MPFR_RNDN);
      return mpfr_get_d(part.get(), MPFR_RNDN);
    };
    const auto draw = [&](Stream& stream) {
      const double x = d.draw(stream);
      EXPECT_GE(x, d.low);
      EXPECT_LE(x, d.high);
      return x;
    };
    expect_plausible(p_value_of_draws(draw, mass), name_of(bounds));
  }
}

TEST(TruncatedNormal, draws_an_exponential_from_the_farthest_tail) {
  // If a is at least 1e8, (x - low) a has an exponential distribution of rate 1, to within 1e-15.
  // If the mean is -a, low is 0, and the doubles near 0 are close enough to each other.
  for (const double a : {1e8, 1e12, 1e100, 1e299}) {
    const TruncatedNormal right{.mean = -a, .sd = 1, .low = 0};
    const TruncatedNormal left{.mean = a, .sd = 1, .high = 0};
    const auto mass = [](double from, double to) {
      return std::exp(-std::max(from, 0.0)) - std::exp(-to);
    };
    expect_plausible(p_value_of_draws([&](Stream& s) { return right.draw(s) * a; }, mass), "right");
    expect_plausible(p_value_of_draws([&](Stream& s) { return -left.draw(s) * a; }, mass), "left");
  }
}

TEST(TruncatedNormal, log_densities_are_mpfrs) {
  for (const Bounds& bounds : k_intervals) {
    const TruncatedNormal d{.mean = 0, .sd = 1, .low = bounds.low, .high = bounds.high};
    // The normalizer is log(mass sqrt(2 pi)).
    Number normalizer(0);
    set_mass(normalizer, d.low, d.high);
    Number root(0);
    mpfr_const_pi(root.get(), MPFR_RNDN);
    mpfr_mul_ui(root.get(), root.get(), 2, MPFR_RNDN);
    mpfr_sqrt(root.get(), root.get(), MPFR_RNDN);
    mpfr_mul(normalizer.get(), normalizer.get(), root.get(), MPFR_RNDN);
    mpfr_log(normalizer.get(), normalizer.get(), MPFR_RNDN);

    Stream stream = test_stream();
    for (int i = 0; i < 100; ++i) {
      const double x = i == 0 && std::isfinite(d.low) ? d.low : d.draw(stream);
      Number exact(x);
      mpfr_sqr(exact.get(), exact.get(), MPFR_RNDN);
      mpfr_div_si(exact.get(), exact.get(), -2, MPFR_RNDN);
      mpfr_sub(exact.get(), exact.get(), normalizer.get(), MPFR_RNDN);
      const double expected = mpfr_get_d(exact.get(), MPFR_RNDN);
      ASSERT_NEAR(d.log_density(x), expected, 1e-13 * (1 + std::fabs(expected)))
          << name_of(bounds) << " at " << x;
    }
  }
}

TEST(TruncatedNormal, densities_integrate_to_one) {
  for (const Bounds& bounds : k_intervals) {
    const TruncatedNormal d{.mean = 0, .sd = 1, .low = bounds.low, .high = bounds.high};
    // Integrate from the end that is nearer to 0, until the density is negligible.
    const bool right = std::fabs(d.low) <= std::fabs(d.high);
    const double near = right ? d.low : d.high;
    if (!std::isfinite(near) || std::fabs(near) >= 1e8) continue;
    const double reach =
        std::min(d.high - d.low, near * (right ? 1 : -1) > 1 ? 40 / std::fabs(near) : 12);
    const double integral = boost::math::quadrature::gauss_kronrod<double, 61>::integrate(
        [&](double s) {
          const double x = right ? near + reach * s : near - reach * s;
          return reach * std::exp(d.log_density(std::clamp(x, d.low, d.high)));
        },
        0.0, 1.0, 10, 1e-12);
    EXPECT_NEAR(integral, 1, 1e-10) << name_of(bounds);
  }
}

TEST(TruncatedNormal, scales_and_shifts) {
  // If the distribution is scaled and shifted, so are its draws. The standard deviation is a power
  // of two, so that no bits are lost.
  const TruncatedNormal standard{.mean = 0, .sd = 1, .low = -1, .high = 2};
  const TruncatedNormal scaled{.mean = 3, .sd = 0.25, .low = 2.75, .high = 3.5};
  Stream first = test_stream();
  Stream second = test_stream();
  for (int i = 0; i < 1000; ++i) {
    const double z = standard.draw(first);
    const double x = scaled.draw(second);
    ASSERT_NEAR(x, 3 + 0.25 * z, 1e-15);
    ASSERT_NEAR(scaled.log_density(x), standard.log_density(z) + std::log(4.0), 1e-14);
  }
}

TEST(TruncatedNormal, has_no_density_outside) {
  const TruncatedNormal d{.mean = 0, .sd = 1, .low = 8, .high = 9};
  EXPECT_EQ(d.log_density(std::nextafter(8, 0)), -k_infinity);
  EXPECT_EQ(d.log_density(std::nextafter(9, 10)), -k_infinity);
  EXPECT_TRUE(std::isfinite(d.log_density(8)));
  EXPECT_TRUE(std::isfinite(d.log_density(9)));
}

TEST(TruncatedNormalDeathTest, refuses_what_is_no_distribution) {
  Stream stream = test_stream();
  const auto draw = [&](const TruncatedNormal& d) { d.draw(stream); };
  EXPECT_DEATH(draw({.mean = 0, .sd = 0, .low = 0, .high = 1}), "check failed");
  EXPECT_DEATH(draw({.mean = k_nan, .sd = 1, .low = 0, .high = 1}), "check failed");
  EXPECT_DEATH(draw({.mean = 0, .sd = 1, .low = 1, .high = 1}), "check failed");
  EXPECT_DEATH(draw({.mean = 0, .sd = 1, .low = 2, .high = 1}), "check failed");
  EXPECT_DEATH(draw({.mean = 0, .sd = 1, .low = k_nan, .high = 1}), "check failed");
  EXPECT_DEATH(draw({.mean = 0, .sd = 1, .low = -k_infinity, .high = -k_infinity}), "check failed");
  EXPECT_DEATH(draw({.mean = 0, .sd = 1e-300, .low = 1e10, .high = k_infinity}), "check failed");
  EXPECT_DEATH((TruncatedNormal{}.log_density(k_nan)), "check failed");
}

}  // namespace
}  // namespace sleight::random
