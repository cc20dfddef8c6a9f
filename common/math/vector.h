// Vectors of the plane and of space: fixed-size Eigen types with our own reductions.
//
// Idea. Eigen's types provide storage and component-wise arithmetic, which rounds once per
// component for any instruction set. For sums over components, Eigen chooses the order of additions
// by size, alignment and build flags. Eigen also chooses whether to fuse multiplication and
// addition. Plain code adds three numbers as a + (b + c). SSE adds four numbers pairwise. AVX adds
// them in another order. A quaternion product has its own SSE code. So the functions below write
// out every such sum from left to right. rotation.h has the products of rotations.
//
// Invariants
//   1. Every function yields the same bits for the same arguments whether compiled for SSE2 or for
//      AVX2. Therefore all our targets use -ffp-contract=off, and elementary.h doesn't compile with
//      FMA. tests/determinism/arithmetic builds both and compares.
//   2. Results never use these members of Eigen: dot, norm, squaredNorm, normalized, cross, sum,
//      prod, products of matrices or quaternions, inverse, and from Eigen/Geometry AngleAxis,
//      Rotation2D and slerp (these call libm's sine). Results never use vectors of run-time size
//      either, because their order of summation depends on alignment.
// Components beyond 1e150 overflow when squared, because nothing is rescaled.
// Thread safety: pure functions.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <concepts>
#include <type_traits>

#include "common/base/check.h"
#include "common/math/elementary.h"

namespace sleight::math {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// A column of two or three doubles, or an expression: a sum, difference or scaling of such
/// columns. The functions below evaluate an expression argument only once.
template <class T>
concept VectorExpression = std::same_as<typename T::Scalar, double> && T::ColsAtCompileTime == 1 &&
                           (T::RowsAtCompileTime == 2 || T::RowsAtCompileTime == 3);

template <class T, class U>
concept SameSize = int{T::RowsAtCompileTime} == int{U::RowsAtCompileTime};

template <VectorExpression T>
using Evaluated = Eigen::Matrix<double, T::RowsAtCompileTime, 1>;

namespace detail {
/// An argument, evaluated once. Vectors are held by reference, to avoid copies through memory.
template <VectorExpression T>
using Held = std::conditional_t<std::same_as<T, Evaluated<T>>, const T&, const Evaluated<T>>;
}  // namespace detail

/// a.x b.x + a.y b.y [+ a.z b.z], added in this order.
template <VectorExpression A, VectorExpression B>
requires SameSize<A, B>
double dot(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  const detail::Held<A> u = a.derived();
  const detail::Held<B> v = b.derived();
  double sum = u[0] * v[0];
  for (Eigen::Index i = 1; i < u.size(); ++i)
    sum += u[i] * v[i];
  return sum;
}

/// Length, in the unit of the components.
template <VectorExpression A>
[[gnu::always_inline]] inline double norm(const Eigen::MatrixBase<A>& a) {
  const detail::Held<A> v = a.derived();
  return std::sqrt(dot(v, v));
}

/// The unit vector along a, with length 1 to within 2^-51.
/// REQUIRES: the norm is neither 0 nor infinite nor NaN.
template <VectorExpression A>
[[gnu::always_inline]] inline Evaluated<A> normalized(const Eigen::MatrixBase<A>& a) {
  const Evaluated<A> v = a;
  const double length = norm(v);
  CHECK(length > 0 && std::isfinite(length));
  return v / length;
}

/// The third component of the cross product of two plane vectors. It is positive if b is to the
/// left of a.
template <VectorExpression A, VectorExpression B>
requires(SameSize<A, B>&& SameSize<A, Vec2>) double cross(const Eigen::MatrixBase<A>& a,
                                                          const Eigen::MatrixBase<B>& b) {
  const detail::Held<A> u = a.derived();
  const detail::Held<B> v = b.derived();
  return u.x() * v.y() - u.y() * v.x();
}

/// The right-handed cross product in space.
template <VectorExpression A, VectorExpression B>
requires(SameSize<A, B>&& SameSize<A, Vec3>) Vec3
    cross(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  const detail::Held<A> u = a.derived();
  const detail::Held<B> v = b.derived();
  return {u.y() * v.z() - u.z() * v.y(), u.z() * v.x() - u.x() * v.z(),
          u.x() * v.y() - u.y() * v.x()};
}

inline Vec3 product(const Mat3& m, const Vec3& v) {
  return {(m(0, 0) * v.x() + m(0, 1) * v.y()) + m(0, 2) * v.z(),
          (m(1, 0) * v.x() + m(1, 1) * v.y()) + m(1, 2) * v.z(),
          (m(2, 0) * v.x() + m(2, 1) * v.y()) + m(2, 2) * v.z()};
}

/// Rotates v by the angle, anticlockwise (from x towards y).
inline Vec2 rotated(const Vec2& v, double angle_rad) {
  const SinCos turn = sincos(angle_rad);
  return {turn.cos * v.x() - turn.sin * v.y(), turn.sin * v.x() + turn.cos * v.y()};
}

}  // namespace sleight::math
