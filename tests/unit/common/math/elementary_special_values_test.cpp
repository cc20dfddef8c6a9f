// Goal: for zeros, infinities and NaN, the functions return the values that Annex F of the C
// standard requires (elementary.h, invariant 3). Method: compare each function with a table. Zeros
// must have the same sign. All NaNs count as equal.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/math/elementary.h"
#include "tests/support/numbers.h"

namespace sleight::math {
namespace {

constexpr double k_largest = std::numeric_limits<double>::max();
constexpr double k_half_pi = 0x1.921fb54442d18p+0;
constexpr double k_pi_double = 0x1.921fb54442d18p+1;
constexpr double k_quarter_pi = 0x1.921fb54442d18p-1;

bool same(double a, double b) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

struct One {
  double x = 0;
  double expected = 0;
};

void expect_table(const char* name, double (*function)(double), const std::vector<One>& table) {
  for (const auto& [x, expected] : table) {
    EXPECT_TRUE(same(function(x), expected))
        << name << "(" << x << ") is " << function(x) << ", not " << expected;
  }
}

TEST(ElementarySpecialValues, functions_of_one_argument) {
  expect_table(
      "sin", sin,
      {{0.0, 0.0}, {-0.0, -0.0}, {k_infinity, k_nan}, {-k_infinity, k_nan}, {k_nan, k_nan}});
  expect_table(
      "cos", cos,
      {{0.0, 1.0}, {-0.0, 1.0}, {k_infinity, k_nan}, {-k_infinity, k_nan}, {k_nan, k_nan}});
  expect_table(
      "tan", tan,
      {{0.0, 0.0}, {-0.0, -0.0}, {k_infinity, k_nan}, {-k_infinity, k_nan}, {k_nan, k_nan}});
  expect_table("exp", exp,
               {{0.0, 1.0},
                {-0.0, 1.0},
                {k_infinity, k_infinity},
                {-k_infinity, 0.0},
                {k_largest, k_infinity},
                {-k_largest, 0.0},
                {k_nan, k_nan}});
  expect_table("expm1", expm1,
               {{0.0, 0.0},
                {-0.0, -0.0},
                {k_infinity, k_infinity},
                {-k_infinity, -1.0},
                {k_largest, k_infinity},
                {-k_largest, -1.0},
                {k_nan, k_nan}});
  expect_table("log", log,
               {{0.0, -k_infinity},
                {-0.0, -k_infinity},
                {1.0, 0.0},
                {-1.0, k_nan},
                {-0x1p-1074, k_nan},
                {k_infinity, k_infinity},
                {-k_infinity, k_nan},
                {k_nan, k_nan}});
  expect_table("log1p", log1p,
               {{0.0, 0.0},
                {-0.0, -0.0},
                {-1.0, -k_infinity},
                {-2.0, k_nan},
                {0x1p-1074, 0x1p-1074},
                {k_infinity, k_infinity},
                {-k_infinity, k_nan},
                {k_nan, k_nan}});
  expect_table(
      "acos", acos,
      {{1.0, 0.0}, {-1.0, k_pi_double}, {1.5, k_nan}, {-k_infinity, k_nan}, {k_nan, k_nan}});
  expect_table("asin", asin,
               {{0.0, 0.0},
                {-0.0, -0.0},
                {1.0, k_half_pi},
                {-1.0, -k_half_pi},
                {1.5, k_nan},
                {k_infinity, k_nan},
                {k_nan, k_nan}});
  expect_table("erf", erf,
               {{0.0, 0.0}, {-0.0, -0.0}, {k_infinity, 1.0}, {-k_infinity, -1.0}, {k_nan, k_nan}});
  expect_table("erfc", erfc,
               {{0.0, 1.0}, {-0.0, 1.0}, {k_infinity, 0.0}, {-k_infinity, 2.0}, {k_nan, k_nan}});
}

TEST(ElementarySpecialValues, sincos_as_sin_and_cos) {
  for (const double x : {k_infinity, -k_infinity, k_nan}) {
    EXPECT_TRUE(std::isnan(sincos(x).sin));
    EXPECT_TRUE(std::isnan(sincos(x).cos));
  }
  EXPECT_TRUE(same(sincos(0.0).sin, 0.0));
  EXPECT_TRUE(same(sincos(-0.0).sin, -0.0));
  EXPECT_EQ(sincos(-0.0).cos, 1.0);
}

struct Two {
  double first = 0;
  double second = 0;
  double expected = 0;
};

TEST(ElementarySpecialValues, atan2) {
  const std::vector<Two> table = {{0.0, 0.0, 0.0},
                                  {-0.0, 0.0, -0.0},
                                  {0.0, -0.0, k_pi_double},
                                  {-0.0, -0.0, -k_pi_double},
                                  {0.0, 1.0, 0.0},
                                  {-0.0, 1.0, -0.0},
                                  {0.0, -1.0, k_pi_double},
                                  {-0.0, -1.0, -k_pi_double},
                                  {1.0, 0.0, k_half_pi},
                                  {-1.0, 0.0, -k_half_pi},
                                  {1.0, -0.0, k_half_pi},
                                  {1.0, k_infinity, 0.0},
                                  {-1.0, k_infinity, -0.0},
                                  {1.0, -k_infinity, k_pi_double},
                                  {k_infinity, 1.0, k_half_pi},
                                  {-k_infinity, 1.0, -k_half_pi},
                                  {k_infinity, k_infinity, k_quarter_pi},
                                  {-k_infinity, k_infinity, -k_quarter_pi},
                                  {k_infinity, -k_infinity, 3 * k_quarter_pi},
                                  {k_nan, 1.0, k_nan},
                                  {1.0, k_nan, k_nan}};
  for (const auto& [y, x, expected] : table) {
    EXPECT_TRUE(same(atan2(y, x), expected))
        << "atan2(" << y << ", " << x << ") is " << atan2(y, x) << ", not " << expected;
  }
}

TEST(ElementarySpecialValues, pow) {
  const std::vector<Two> table = {{0.0, 0.0, 1.0},
                                  {k_nan, 0.0, 1.0},
                                  {1.0, k_nan, 1.0},
                                  {1.0, k_infinity, 1.0},
                                  {-1.0, k_infinity, 1.0},
                                  {0.0, 2.0, 0.0},
                                  {-0.0, 3.0, -0.0},
                                  {-0.0, 2.0, 0.0},
                                  {0.0, -1.0, k_infinity},
                                  {-0.0, -1.0, -k_infinity},
                                  {-0.0, -2.0, k_infinity},
                                  {-8.0, 1.0 / 3.0, k_nan},
                                  {-2.0, 3.0, -8.0},
                                  {0.5, k_infinity, 0.0},
                                  {0.5, -k_infinity, k_infinity},
                                  {2.0, k_infinity, k_infinity},
                                  {2.0, -k_infinity, 0.0},
                                  {k_infinity, -1.0, 0.0},
                                  {k_infinity, 1.0, k_infinity},
                                  {-k_infinity, 3.0, -k_infinity},
                                  {-k_infinity, 2.0, k_infinity},
                                  {-k_infinity, -3.0, -0.0},
                                  {2.0, 1024.0, k_infinity},
                                  {2.0, -1074.0, 0x1p-1074},
                                  {2.0, -1080.0, 0.0},
                                  {k_nan, 1.0, k_nan},
                                  {2.0, k_nan, k_nan}};
  for (const auto& [x, y, expected] : table) {
    EXPECT_TRUE(same(pow(x, y), expected))
        << "pow(" << x << ", " << y << ") is " << pow(x, y) << ", not " << expected;
  }
}

}  // namespace
}  // namespace sleight::math
