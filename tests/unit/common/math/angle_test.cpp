// Goal: wrapped_angle lands in [-pi, pi), whole turns away from its argument.
// Method: the border cases by hand, many turns against sine and cosine, hostile magnitudes.
#include "common/math/angle.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/math/elementary.h"

namespace sleight::math {
namespace {

TEST(WrappedAngle, leaves_the_circle_alone_and_is_half_open) {
  for (const double x : {-k_pi, std::nextafter(k_pi, 0), 0.0, -0.0, 1.0, -3.0}) {
    EXPECT_EQ(wrapped_angle(x), x);
  }
  EXPECT_TRUE(std::signbit(wrapped_angle(-0.0)));
  EXPECT_EQ(wrapped_angle(k_pi), -k_pi);
  EXPECT_EQ(wrapped_angle(-3 * k_pi), -k_pi);
  EXPECT_EQ(wrapped_angle(k_two_pi), 0);
}

TEST(WrappedAngle, takes_off_whole_turns) {
  for (int i = -2000; i <= 2000; ++i) {
    const double x = 0.37 * i;
    const double wrapped = wrapped_angle(x);
    ASSERT_GE(wrapped, -k_pi);
    ASSERT_LT(wrapped, k_pi);
    // 118 turns of at most 2.5e-16 each, and the spacing of doubles near 740, 1.1e-13.
    EXPECT_NEAR(sin(wrapped), sin(x), 2e-13) << x;
    EXPECT_NEAR(cos(wrapped), cos(x), 2e-13) << x;
  }
}

TEST(WrappedAngle, stays_in_range_whatever_the_magnitude) {
  for (int exponent = -1074; exponent < 1024; ++exponent) {
    for (const double factor : {1.0, -1.0, 1.7, -1.999}) {
      const double wrapped = wrapped_angle(std::ldexp(factor, exponent));
      ASSERT_GE(wrapped, -k_pi) << factor << " * 2^" << exponent;
      ASSERT_LT(wrapped, k_pi) << factor << " * 2^" << exponent;
    }
  }
  for (int turns = 1; turns < 10000; ++turns) {
    double x = k_pi + k_two_pi * turns;
    for (int step = 0; step < 3; ++step, x = std::nextafter(x, 0)) {
      ASSERT_GE(wrapped_angle(x), -k_pi) << x;
      ASSERT_LT(wrapped_angle(x), k_pi) << x;
      ASSERT_GE(wrapped_angle(-x), -k_pi) << x;
      ASSERT_LT(wrapped_angle(-x), k_pi) << x;
    }
  }
}

TEST(WrappedAngleDeathTest, refuses_what_is_no_angle) {
  EXPECT_DEATH(wrapped_angle(std::numeric_limits<double>::infinity()), "check failed");
  EXPECT_DEATH(wrapped_angle(std::numeric_limits<double>::quiet_NaN()), "check failed");
}

}  // namespace
}  // namespace sleight::math
