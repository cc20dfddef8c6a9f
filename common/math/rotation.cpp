#include "common/math/rotation.h"

namespace sleight::math {

Quat quaternion_of_rotation_vector(const Vec3& rotation_vector_rad) {
  const double square = dot(rotation_vector_rad, rotation_vector_rad);
  CHECK(std::isfinite(square));
  const double angle_rad = std::sqrt(square);
  const SinCos half = sincos(0.5 * angle_rad);
  // sin(t/2)/t. Near 0, the quotient would be 0/0, so use the series 1/2 - t^2/48 + t^4/3840. At
  // the limit, the first omitted term divided by the sum is 5e-20.
  constexpr double k_series_square_max = 1e-8;
  const double scale =
      square < k_series_square_max ? 0.5 - square * (1.0 / 48.0) : half.sin / angle_rad;
  return {half.cos, scale * rotation_vector_rad.x(), scale * rotation_vector_rad.y(),
          scale * rotation_vector_rad.z()};
}

Quat normalized(const Quat& q) {
  const double length =
      std::sqrt(((q.w() * q.w() + q.x() * q.x()) + q.y() * q.y()) + q.z() * q.z());
  CHECK(length > 0 && std::isfinite(length));
  return {q.w() / length, q.x() / length, q.y() / length, q.z() / length};
}

}  // namespace sleight::math
