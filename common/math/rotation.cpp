#include "common/math/rotation.h"

namespace sleight::math {

Quat quaternion_of_rotation_vector(const Vec3& rotation_vector_rad) {
  const double square = dot(rotation_vector_rad, rotation_vector_rad);
  CHECK(std::isfinite(square));
  const double angle_rad = std::sqrt(square);
  const SinCos half = sincos(0.5 * angle_rad);
  // sin(t/2)/t, by its series 1/2 - t^2/48 + t^4/3840 near 0, where the quotient would be 0/0. At
  // the border the first term left out is 5e-20 of the sum.
  constexpr double k_series_square_max = 1e-8;
  const double scale =
      square < k_series_square_max ? 0.5 - square * (1.0 / 48.0) : half.sin / angle_rad;
  return {half.cos, scale * rotation_vector_rad.x(), scale * rotation_vector_rad.y(),
          scale * rotation_vector_rad.z()};
}

Quat composed(const Quat& second, const Quat& first) {
  const Quat& a = second;
  const Quat& b = first;
  return {((a.w() * b.w() - a.x() * b.x()) - a.y() * b.y()) - a.z() * b.z(),
          ((a.w() * b.x() + a.x() * b.w()) + a.y() * b.z()) - a.z() * b.y(),
          ((a.w() * b.y() + a.y() * b.w()) + a.z() * b.x()) - a.x() * b.z(),
          ((a.w() * b.z() + a.z() * b.w()) + a.x() * b.y()) - a.y() * b.x()};
}

Quat inverse(const Quat& q) {
  return {q.w(), -q.x(), -q.y(), -q.z()};
}

Quat normalized(const Quat& q) {
  const double length =
      std::sqrt(((q.w() * q.w() + q.x() * q.x()) + q.y() * q.y()) + q.z() * q.z());
  CHECK(length > 0 && std::isfinite(length));
  return {q.w() / length, q.x() / length, q.y() / length, q.z() / length};
}

Vec3 rotated(const Quat& q, const Vec3& v) {
  // v + w t + u x t with t = 2 u x v and u the vector part: 15 multiplications instead of the 24 of
  // q v q^-1, and exactly v for the identity.
  const Vec3 u(q.x(), q.y(), q.z());
  const Vec3 half = cross(u, v);
  const Vec3 t(2 * half.x(), 2 * half.y(), 2 * half.z());
  const Vec3 ut = cross(u, t);
  return {(v.x() + q.w() * t.x()) + ut.x(), (v.y() + q.w() * t.y()) + ut.y(),
          (v.z() + q.w() * t.z()) + ut.z()};
}

Mat3 matrix_of(const Quat& q) {
  const double xx = q.x() * q.x();
  const double yy = q.y() * q.y();
  const double zz = q.z() * q.z();
  const double xy = q.x() * q.y();
  const double xz = q.x() * q.z();
  const double yz = q.y() * q.z();
  const double wx = q.w() * q.x();
  const double wy = q.w() * q.y();
  const double wz = q.w() * q.z();
  Mat3 m;
  m(0, 0) = 1 - 2 * (yy + zz);
  m(0, 1) = 2 * (xy - wz);
  m(0, 2) = 2 * (xz + wy);
  m(1, 0) = 2 * (xy + wz);
  m(1, 1) = 1 - 2 * (xx + zz);
  m(1, 2) = 2 * (yz - wx);
  m(2, 0) = 2 * (xz - wy);
  m(2, 1) = 2 * (yz + wx);
  m(2, 2) = 1 - 2 * (xx + yy);
  return m;
}

}  // namespace sleight::math
