#include "worker/worlds/user_scene/copies.h"

#include <fmt/format.h>

#include "common/math/elementary.h"

namespace sleight::worlds::user_scene {

std::size_t count_of(const Copies& copies) {
  std::size_t count = 1;
  for (const std::uint32_t along : copies.count)
    count *= along;
  return count;
}

std::vector<Copy> copies_of(const BodyDescription& body) {
  const Copies& copies = body.copies;
  if (copies.kind == CopyKind::none) return {{.name = body.name, .place = body.place}};
  std::vector<Copy> all;
  const auto [nx, ny, nz] = copies.count;
  for (std::uint32_t i = 0; i < nx * ny * nz; ++i) {
    Copy copy{.name = fmt::format("{} {}", body.name, i + 1), .place = body.place};
    if (copies.kind == CopyKind::ring) {
      const double last = copies.full_circle ? nx : nx - 1;
      const double angle_rad =
          copies.from_rad + (nx > 1 ? (copies.to_rad - copies.from_rad) * (i / last) : 0);
      copy.turn = math::quaternion_of_rotation_vector({0, 0, angle_rad});
      copy.place.position_m += math::rotated(copy.turn, Vec3(copies.radius_m, 0, 0));
      copy.place.orientation = math::composed(copy.turn, copy.place.orientation);
    } else {
      const Vec3 steps =
          copies.kind == CopyKind::row ? Vec3(i, i, i) : Vec3(i % nx, (i / nx) % ny, i / (nx * ny));
      for (int axis = 0; axis < 3; ++axis)
        copy.place.position_m[axis] += steps[axis] * copies.step_m[axis];
    }
    all.push_back(std::move(copy));
  }
  return all;
}

}  // namespace sleight::worlds::user_scene
