#include "worker/worlds/dice/numbering.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/check.h"
#include "common/math/angle.h"

namespace sleight::worlds::dice {
namespace {

using Images = std::array<AxisDirection, 3>;

constexpr bool is_even(const std::array<std::uint8_t, 3>& p) {
  return (p[0] == 0 && p[1] == 1) || (p[0] == 1 && p[1] == 2) || (p[0] == 2 && p[1] == 0);
}

/// Permutations in lexicographic order. Signs make the determinant 1.
constexpr std::array<Images, k_numberings> all_rotations() {
  constexpr std::array<std::array<std::uint8_t, 3>, 6> k_permutations{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  std::array<Images, k_numberings> all{};
  std::size_t count = 0;
  for (const auto& p : k_permutations) {
    for (int signs = 0; signs < 8; ++signs) {
      const int x = (signs & 4) != 0 ? -1 : 1;
      const int y = (signs & 2) != 0 ? -1 : 1;
      const int z = (signs & 1) != 0 ? -1 : 1;
      if (x * y * z != (is_even(p) ? 1 : -1)) continue;
      all[count++] = {{{p[0], static_cast<std::int8_t>(x)},
                       {p[1], static_cast<std::int8_t>(y)},
                       {p[2], static_cast<std::int8_t>(z)}}};
    }
  }
  return all;
}

constexpr std::array<Images, k_numberings> k_rotations = all_rotations();
static_assert(k_rotations[0][0].axis == 0 && k_rotations[0][0].sign == 1);
static_assert(k_rotations[0][1].axis == 1 && k_rotations[0][1].sign == 1);

}  // namespace

AxisDirection direction_of_face(std::uint32_t face, std::uint32_t numbering) {
  CHECK(face >= 1 && face <= k_faces);
  CHECK_LT(numbering, k_numberings);
  const bool is_low = face <= 3;
  AxisDirection direction = k_rotations[numbering][is_low ? face - 1 : k_faces - face];
  if (!is_low) direction.sign = static_cast<std::int8_t>(-direction.sign);
  return direction;
}

Quat rotation_of_numbering(std::uint32_t numbering) {
  CHECK_LT(numbering, k_numberings);
  const auto entry = [&](std::uint8_t row, std::size_t column) {
    const AxisDirection& image = k_rotations[numbering][column];
    return image.axis == row ? static_cast<double>(image.sign) : 0.0;
  };
  // The entries of the rotation matrix are whole numbers, so four times the squares of the
  // components are whole, and the largest component is at least 1/2.
  const double w = std::sqrt(std::max(0.0, 1 + entry(0, 0) + entry(1, 1) + entry(2, 2))) / 2;
  if (w > 0) {
    return {w, (entry(2, 1) - entry(1, 2)) / (4 * w), (entry(0, 2) - entry(2, 0)) / (4 * w),
            (entry(1, 0) - entry(0, 1)) / (4 * w)};
  }
  // Half a turn about the axis n has the matrix 2 n n^T - 1.
  const double x = std::sqrt((entry(0, 0) + 1) / 2);
  const double y = std::sqrt((entry(1, 1) + 1) / 2);
  const double z = std::sqrt((entry(2, 2) + 1) / 2);
  if (x > 0) return {0, x, entry(1, 0) / (2 * x), entry(2, 0) / (2 * x)};
  if (y > 0) return {0, 0, y, entry(2, 1) / (2 * y)};
  return {0, 0, 0, z};
}

Quat orientation_with_face_up(std::uint32_t face, double yaw_rad) {
  constexpr double k_quarter = 0.5 * math::k_pi;
  // For each face, a turn that brings it to the top. For example, face 1 (+x) turns about -y.
  const std::array<Vec3, k_faces> turns{Vec3(0, -k_quarter, 0), Vec3(k_quarter, 0, 0),
                                        Vec3(0, 0, 0),          Vec3(math::k_pi, 0, 0),
                                        Vec3(-k_quarter, 0, 0), Vec3(0, k_quarter, 0)};
  CHECK(face >= 1 && face <= k_faces);
  return math::normalized(math::composed(math::quaternion_of_rotation_vector({0, 0, yaw_rad}),
                                         math::quaternion_of_rotation_vector(turns[face - 1])));
}

}  // namespace sleight::worlds::dice
