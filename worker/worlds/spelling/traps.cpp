#include "worker/worlds/spelling/traps.h"

#include <algorithm>
#include <cmath>

#include "common/math/vector.h"

namespace sleight::worlds::spelling {
namespace {

/// Minimum margin of a height. This margin is far more than rounding adds.
constexpr double k_margin_least_m = 1e-4;

/// Energy allows a maximum height. A piece of motion may exceed this height by half the height of
/// the slowest bounces (edge_motion.h). In diameters, the excess is a quarter of the square of
/// bounce_end. The margin is twice that.
double margin_of(const WorldParameters& world) {
  return std::max(k_margin_least_m,
                  0.5 * world.bounce_end * world.bounce_end * world.ball_diameter_m);
}

/// I / (m r^2) of a solid ball.
constexpr double k_gyration = 0.4;

}  // namespace

std::optional<Traps::Place> Traps::of(const Vec3& centre_m, const physics::Twist& twist) const {
  const double radius_m = 0.5 * world_.ball_diameter_m;
  const double margin_m = margin_of(world_);
  const Vec3 turning_mps = radius_m * twist.angular_velocity_radps;
  const double energy = math::dot(twist.velocity_mps, twist.velocity_mps) +
                        k_gyration * math::dot(turning_mps, turning_mps);
  const double reaches_m = centre_m.z() + energy / (2 * world_.gravity_mps2) + margin_m;
  // Most balls are too fast to be trapped, so test the speed first.
  if (!(centre_m.z() > 0) || reaches_m > world_.partition_height_m) return std::nullopt;
  const auto bin = bins_.bin_at(centre_m);
  if (!bin) return std::nullopt;
  double lowest_m = std::min(world_.partition_height_m, world_.box_height_m);
  double lean_m = 0;  // of the partitions, outwards
  for (const std::uint32_t corner : bins_.corners(*bin)) {
    if (corner == k_no_vertex) continue;
    const Vec3& offset_m = offsets_m_[corner];
    lowest_m = std::min(lowest_m, world_.partition_height_m + offset_m.z());
    lean_m = std::max({lean_m, std::fabs(offset_m.x()), std::fabs(offset_m.y())});
  }
  if (reaches_m > lowest_m) return std::nullopt;
  const Vec3 middle_m = bins_.floor_middle_m(*bin);
  const double half_m = 0.5 * world_.bin_m + lean_m + margin_m;
  // Partitions that lean over into the next bin would not separate balls.
  if (half_m > 0.5 * (world_.bin_m + world_.partition_m)) return std::nullopt;
  physics::Box box;
  for (int i = 0; i < 2; ++i) {
    if (std::fabs(centre_m[i] - middle_m[i]) > half_m - radius_m) return std::nullopt;
    const auto axis = static_cast<std::size_t>(i);
    box.low_m[axis] = static_cast<float>(middle_m[i] - half_m);
    box.high_m[axis] = static_cast<float>(middle_m[i] + half_m);
  }
  box.low_m[2] = static_cast<float>(-margin_m);
  box.high_m[2] = static_cast<float>(reaches_m + radius_m);
  return Place{.bin = *bin, .box = box};
}

bool Traps::all_stay(std::span<const Ball> balls) const {
  // Test the last dropped balls first: they are the likeliest to move.
  for (std::size_t i = balls.size(); i-- > 0;) {
    const Ball& ball = balls[i];
    if (ball.rests) continue;
    const auto place = of(ball.centre_m, ball.twist);
    if (!place) return false;
    for (const Ball& other : balls) {
      if (&other == &ball) continue;
      if (!other.rests) {
        if (bins_.bin_at(other.centre_m) == place->bin) return false;
        continue;
      }
      // A resting ball's centre must be over two radii from each place that the trapped ball's
      // centre can reach.
      const double radius_m = 0.5 * world_.ball_diameter_m;
      double square = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis);
        const double low_m = double{place->box.low_m[at]} + radius_m;
        const double high_m = double{place->box.high_m[at]} - radius_m;
        const double away_m =
            std::max({0.0, low_m - other.centre_m[axis], other.centre_m[axis] - high_m});
        square += away_m * away_m;
      }
      const bool apart = square > 4 * radius_m * radius_m;
      if (!apart) return false;
    }
  }
  return true;
}

}  // namespace sleight::worlds::spelling
