#include "worker/worlds/ball_2d/motion.h"

#include <cmath>

#include "common/math/elementary.h"

namespace sleight::worlds::ball_2d {

math::Vec2 reflected(const math::Vec2& velocity, const math::Vec2& normal, double restitution) {
  const double approach = math::dot(velocity, normal);
  if (approach >= 0) return velocity;
  const double change = (1 + restitution) * approach;
  return velocity - change * normal;
}

namespace {

/// Throws the ball. Passes the hops to `keep` in order.
template <class Keep>
Landing fly(const WorldParameters& world, const NormalAngles& normals, const Keep& keep) {
  const double g = world.gravity_mps2;

  // Fall from rest to the first collision.
  const double drop_m = world.drop_height_diameters * world.diameter_m;
  const double fall_s = std::sqrt(2 * drop_m / g);
  keep(Flight{.start_s = 0, .duration_s = fall_s, .position_m = {0, drop_m}});

  double now_s = fall_s;
  double x_m = 0;
  math::Vec2 velocity{0, -g * fall_s};
  for (std::uint32_t i = 0; i < world.collisions; ++i) {
    // Reflect about this collision's normal.
    const math::SinCos tilt = math::sincos(normals[i]);
    velocity = reflected(velocity, math::Vec2{tilt.sin, tilt.cos}, world.restitution);

    // Hop to the next collision. If the ball doesn't rise, it collides at once.
    const double hop_s = velocity.y() > 0 ? 2 * velocity.y() / g : 0;
    keep(Flight{
        .start_s = now_s, .duration_s = hop_s, .position_m = {x_m, 0}, .velocity_mps = velocity});
    now_s += hop_s;
    x_m += velocity.x() * hop_s;
    if (hop_s > 0) velocity.y() = -velocity.y();
  }
  return {.x_m = x_m, .time_s = now_s};
}

}  // namespace

Landing simulate_landing(const WorldParameters& world, const NormalAngles& normals) {
  return fly(world, normals, [](const Flight&) {});
}

Motion simulate_motion(const WorldParameters& world, const NormalAngles& normals) {
  Motion motion;
  motion.flights.reserve(world.collisions + 1);
  motion.landing =
      fly(world, normals, [&](const Flight& flight) { motion.flights.push_back(flight); });
  return motion;
}

}  // namespace sleight::worlds::ball_2d
