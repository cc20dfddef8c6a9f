#include "worker/worlds/user_scene/channel.h"

#include <numbers>

#include "common/base/check.h"
#include "common/math/elementary.h"

namespace sleight::worlds::user_scene {

Channel channel_of(const ShapeSizes& sizes) {
  CHECK(sizes.kind == ShapeKind::helix || sizes.kind == ShapeKind::ramp);
  CHECK(sizes.steps >= 1 && sizes.strips >= 2);
  Channel channel;
  for (std::uint32_t step = 0; step <= sizes.steps; ++step) {
    const double share = 1.0 * step / sizes.steps;
    const double angle_rad = 2 * std::numbers::pi * sizes.turns * share;
    for (std::uint32_t strip = 0; strip <= sizes.strips; ++strip) {
      const double across_rad = std::numbers::pi * (1.0 * strip / sizes.strips - 1);
      const double sideways_m = sizes.radius_m * math::cos(across_rad);
      const double z_m = sizes.radius_m * math::sin(across_rad) - sizes.drop_m * share;
      if (sizes.kind == ShapeKind::ramp) {
        channel.points_m.emplace_back(sizes.length_m * share, -sideways_m, z_m);
      } else {
        const double r_m = sizes.path_radius_m + sideways_m;
        channel.points_m.emplace_back(r_m * math::cos(angle_rad), r_m * math::sin(angle_rad), z_m);
      }
    }
  }
  const auto point = [&](std::uint32_t step, std::uint32_t strip) {
    return step * (sizes.strips + 1) + strip;
  };
  for (std::uint32_t step = 0; step < sizes.steps; ++step) {
    for (std::uint32_t strip = 0; strip < sizes.strips; ++strip) {
      channel.triangles.push_back(
          {point(step, strip), point(step + 1, strip), point(step + 1, strip + 1)});
      channel.triangles.push_back(
          {point(step, strip), point(step + 1, strip + 1), point(step, strip + 1)});
    }
  }
  return channel;
}

}  // namespace sleight::worlds::user_scene
