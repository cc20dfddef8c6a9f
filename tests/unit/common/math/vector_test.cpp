// Goal: products, norms and plane rotations are right, and sums are computed in the order that
// vector.h states. Method: compare with known values, identities and Eigen. To test the order, use
// numbers whose sum depends on the order.
#include "common/math/vector.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "common/math/angle.h"

namespace sleight::math {
namespace {

TEST(Dot, adds_from_left_to_right) {
  // In doubles, (1e16 + 1) - 1e16 is 0, but (1e16 - 1e16) + 1 is 1.
  EXPECT_EQ(dot(Vec3(1e16, 1, -1e16), Vec3(1, 1, 1)), 0);
  EXPECT_EQ(dot(Vec3(1e16, -1e16, 1), Vec3(1, 1, 1)), 1);
  EXPECT_EQ(dot(Vec3(1, 1e16, -1e16), Vec3(1, 1, 1)), 0);
}

TEST(Dot, rounds_each_product_once) {
  // Rounding removes the term 2^-60 of x^2. A fused multiply-add would keep this term and return
  // 2^-60 instead of 0.
  const double x = 1 + 0x1p-30;
  EXPECT_EQ(dot(Vec2(x, 1 + 0x1p-29), Vec2(x, -1)), 0);
}

TEST(Product, is_linear_and_agrees_with_eigen) {
  Mat3 m;
  m << 1, 2, 3, 4, 5, 6, 7, 8, 10;
  EXPECT_EQ(product(m, Vec3(1, 0, 0)), Vec3(1, 4, 7));
  EXPECT_EQ(product(m, Vec3(1, -1, 2)), Vec3(5, 11, 19));
  const Vec3 v(0.3, -1.7, 2.9);
  EXPECT_TRUE(product(m, v).isApprox(m * v, 1e-15));
}

TEST(Cross, is_right_handed) {
  EXPECT_EQ(cross(Vec3(1, 0, 0), Vec3(0, 1, 0)), Vec3(0, 0, 1));
  EXPECT_EQ(cross(Vec3(0, 1, 0), Vec3(0, 0, 1)), Vec3(1, 0, 0));
  EXPECT_EQ(cross(Vec2(1, 0), Vec2(0, 1)), 1);
  const Vec3 a(0.3, -1.7, 2.9);
  const Vec3 b(-2.3, 0.4, 1.1);
  EXPECT_TRUE(cross(a, b).isApprox(a.cross(b), 1e-15));
  EXPECT_NEAR(dot(cross(a, b), a), 0, 1e-14);
  EXPECT_EQ(cross(a, b), -cross(b, a));
}

TEST(Normalized, has_length_one_and_keeps_the_direction) {
  EXPECT_EQ(norm(Vec2(3, 4)), 5);
  EXPECT_EQ(norm(Vec3(2, 3, 6)), 7);
  for (int i = 1; i < 1000; ++i) {
    const Vec3 v(0.1 * i, -3.7 + 0.01 * i, 1.0 / i);
    EXPECT_NEAR(norm(normalized(v)), 1, 0x1p-51);
    EXPECT_NEAR(norm(cross(normalized(v), v)), 0, 1e-13);
    EXPECT_GT(dot(normalized(v), v), 0);
    const Vec2 w(v.x(), v.z());
    EXPECT_NEAR(norm(normalized(w)), 1, 0x1p-51);
    EXPECT_NEAR(cross(normalized(w), w), 0, 1e-13);
  }
}

TEST(NormalizedDeathTest, refuses_vectors_without_direction) {
  EXPECT_DEATH(normalized(Vec2(0, 0)), "check failed");
  EXPECT_DEATH(normalized(Vec3(0, 0, 0)), "check failed");
  EXPECT_DEATH(normalized(Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0)), "check failed");
  EXPECT_DEATH(normalized(Vec3(1e200, 0, 0)), "check failed");
}

TEST(RotatedInThePlane, turns_anticlockwise) {
  const Vec2 quarter = rotated(Vec2(2, 0), k_pi / 2);
  EXPECT_NEAR(quarter.x(), 0, 1e-15);
  EXPECT_NEAR(quarter.y(), 2, 1e-15);
  EXPECT_EQ(rotated(Vec2(0.3, -0.4), 0), Vec2(0.3, -0.4));
  for (int i = -100; i <= 100; ++i) {
    const double angle = 0.1 * i;
    const Vec2 v(1.3, -0.4);
    const Vec2 turned = rotated(v, angle);
    // The rotation keeps the length. The dot and the cross product give the cosine and the sine of
    // the angle.
    EXPECT_NEAR(norm(turned), norm(v), 1e-15);
    EXPECT_NEAR(dot(v, turned) / dot(v, v), cos(angle), 1e-15);
    EXPECT_NEAR(cross(v, turned) / dot(v, v), sin(angle), 1e-15);
    const Vec2 back = rotated(turned, -angle);
    EXPECT_NEAR(norm(back - v), 0, 1e-15);
  }
}

}  // namespace
}  // namespace sleight::math
