// Goal: quaternions rotate vectors correctly by any angle, tiny or huge. Method: compare with
// Rodrigues' formula in long double. Check compositions, inverses and rotation matrices.
#include "common/math/rotation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "common/math/angle.h"

namespace sleight::math {
namespace {

// Returns v cos t + (n x v) sin t + n (n . v)(1 - cos t) with n = w/|w|, t = |w|, in long double.
Vec3 rodrigues(const Vec3& w, const Vec3& v) {
  const Eigen::Matrix<long double, 3, 1> wl = w.cast<long double>();
  const Eigen::Matrix<long double, 3, 1> vl = v.cast<long double>();
  const long double t = wl.norm();
  const Eigen::Matrix<long double, 3, 1> n = wl / t;
  return (vl * std::cos(t) + n.cross(vl) * std::sin(t) + n * (n.dot(vl) * (1 - std::cos(t))))
      .cast<double>();
}

double quaternion_norm(const Quat& q) {
  return std::sqrt(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
}

double distance(const Quat& a, const Quat& b) {
  return (a.coeffs() - b.coeffs()).cwiseAbs().maxCoeff();
}

std::vector<Vec3> rotation_vectors() {
  std::vector<Vec3> result;
  for (const double size : {1e-300, 1e-160, 1e-20, 1e-8, 0.99e-4, 1.01e-4, 1e-2, 0.5, 1.0, 3.0,
                            k_pi, 4.0, 7.0, 100.0}) {
    for (int i = 0; i < 20; ++i) {
      const Vec3 direction = normalized(Vec3(sin(1.0 * i), cos(2.3 * i), sin(0.7 * i + 1)));
      result.emplace_back(size * direction.x(), size * direction.y(), size * direction.z());
    }
  }
  return result;
}

TEST(QuaternionOfRotationVector, rotates_as_rodrigues_formula) {
  const Vec3 v(0.3, -1.7, 2.9);
  for (const Vec3& w : rotation_vectors()) {
    const Quat q = quaternion_of_rotation_vector(w);
    EXPECT_NEAR(quaternion_norm(q), 1, 0x1p-50);
    // Most of the error comes from rounding the angle, by up to 2^-53 of 100 rad.
    EXPECT_LT((rotated(q, v) - rodrigues(w, v)).cwiseAbs().maxCoeff(), 4e-14) << w.transpose();
    if (norm(w) < 10) {
      EXPECT_LT((rotated(q, v) - rodrigues(w, v)).cwiseAbs().maxCoeff(), 5e-15) << w.transpose();
    }
  }
}

TEST(QuaternionOfRotationVector, is_accurate_in_the_vector_part_of_tiny_rotations) {
  // If |w| is below 1e-8, the vector part is w/2, rounded, even if the squares of w underflow.
  for (const double size : {1e-300, 1e-160, 1e-20, 1e-9}) {
    const Quat q = quaternion_of_rotation_vector(Vec3(size, -2 * size, 0));
    EXPECT_EQ(q.w(), 1);
    EXPECT_NEAR(q.x() / (size / 2), 1, 1e-15);
    EXPECT_NEAR(q.y() / -size, 1, 1e-15);
    EXPECT_EQ(q.z(), 0);
  }
  const Quat identity = quaternion_of_rotation_vector(Vec3(0, 0, 0));
  EXPECT_EQ(identity.w(), 1);
  EXPECT_EQ(identity.x(), 0);
}

TEST(QuaternionOfRotationVectorDeathTest, refuses_infinite_rotations) {
  EXPECT_DEATH(quaternion_of_rotation_vector(Vec3(std::numeric_limits<double>::infinity(), 0, 0)),
               "check failed");
}

TEST(Composed, does_the_first_rotation_first) {
  const Vec3 v(0.3, -1.7, 2.9);
  const Quat a = quaternion_of_rotation_vector(Vec3(1.1, 0.2, -0.4));
  const Quat b = quaternion_of_rotation_vector(Vec3(-0.3, 2.0, 0.9));
  EXPECT_LT(norm(rotated(composed(b, a), v) - rotated(b, rotated(a, v))), 2e-15);
  EXPECT_GT(norm(rotated(composed(b, a), v) - rotated(composed(a, b), v)), 0.1);
  EXPECT_LT(distance(composed(b, a), b * a), 2e-16);
  EXPECT_LT(distance(composed(a, inverse(a)), Quat(1, 0, 0, 0)), 2e-16);
  EXPECT_LT(norm(rotated(inverse(a), rotated(a, v)) - v), 2e-15);
}

TEST(Rotated, leaves_vectors_alone_under_the_identity) {
  const Vec3 v(0.3, -1.7, 2.9);
  EXPECT_EQ(rotated(Quat(1, 0, 0, 0), v), v);
  EXPECT_EQ(product(matrix_of(Quat(1, 0, 0, 0)), v), v);
}

TEST(MatrixOf, agrees_with_the_quaternion_and_is_orthonormal) {
  const Vec3 v(0.3, -1.7, 2.9);
  for (const Vec3& w : rotation_vectors()) {
    const Quat q = quaternion_of_rotation_vector(w);
    const Mat3 m = matrix_of(q);
    EXPECT_LT(norm(product(m, v) - rotated(q, v)), 1e-14);
    EXPECT_LT((m * m.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_NEAR(m.determinant(), 1, 1e-14);
    EXPECT_LT((m - q.toRotationMatrix()).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(Normalized, restores_a_long_chain_of_compositions) {
  const Quat step = quaternion_of_rotation_vector(Vec3(0.01, -0.02, 0.005));
  Quat q(1, 0, 0, 0);
  for (int i = 0; i < 100000; ++i)
    q = composed(step, q);
  // The norm drifts by at most one ulp per step, and there are 100,000 steps.
  EXPECT_NEAR(quaternion_norm(q), 1, 1e5 * 0x1p-52);
  EXPECT_NEAR(quaternion_norm(normalized(q)), 1, 0x1p-51);
  const Quat whole = quaternion_of_rotation_vector(Vec3(1000, -2000, 500));
  // Each step rounds the angle by up to 2^-53 of its size. The errors of 100,000 steps add up.
  EXPECT_LT(distance(normalized(q), whole), 1e-11);
  EXPECT_DEATH(normalized(Quat(0, 0, 0, 0)), "check failed");
}

}  // namespace
}  // namespace sleight::math
