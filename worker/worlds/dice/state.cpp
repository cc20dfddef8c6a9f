#include "worker/worlds/dice/state.h"

#include "common/base/check.h"
#include "common/random/distributions.h"

namespace sleight::worlds::dice {
namespace {

Vec3 draw_normal(const Vec3& mean, const Vec3& sd, random::Stream& stream) {
  Vec3 drawn = mean;
  for (int axis = 0; axis < 3; ++axis) {
    if (sd[axis] > 0) drawn[axis] = random::Normal{.mean = mean[axis], .sd = sd[axis]}.draw(stream);
  }
  return drawn;
}

double log_normal_density(const Vec3& mean, const Vec3& sd, const Vec3& x) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (sd[axis] > 0) {
      sum += random::Normal{.mean = mean[axis], .sd = sd[axis]}.log_density(x[axis]);
    } else if (x[axis] != mean[axis]) {
      return k_impossible;
    }
  }
  return sum;
}

}  // namespace

DieThrow draw_throw(const DieStart& start, random::Stream& stream) {
  // Draw in separate statements, because the order of draws is part of the format.
  DieThrow one;
  one.position_m = draw_normal(start.position_m, start.position_sd_m, stream);
  one.orientation = start.orientation == StartOrientation::uniform
                        ? math::normalized(random::UniformRotation{}.draw(stream))
                        : start.fixed_orientation;
  one.velocity_mps = draw_normal(start.velocity_mps, start.velocity_sd_mps, stream);
  one.spin_radps = draw_normal(start.spin_radps, start.spin_sd_radps, stream);
  return one;
}

double log_density_of(const DieStart& start, const DieThrow& one) {
  double sum = 0;
  if (start.orientation == StartOrientation::uniform) {
    sum = random::UniformRotation{}.log_density(one.orientation);
  } else if (one.orientation.coeffs() != start.fixed_orientation.coeffs()) {
    return k_impossible;
  }
  sum += log_normal_density(start.position_m, start.position_sd_m, one.position_m);
  sum += log_normal_density(start.velocity_mps, start.velocity_sd_mps, one.velocity_mps);
  sum += log_normal_density(start.spin_radps, start.spin_sd_radps, one.spin_radps);
  return sum;
}

State draw_state(const WorldParameters& world, random::Stream& stream) {
  State state;
  state.table_key = stream.bits();
  for (const DieStart& start : world.dice)
    state.dice.push_back(draw_throw(start, stream));
  return state;
}

double log_density_of(const WorldParameters& world, const State& state) {
  CHECK_EQ(state.dice.size(), world.dice.size());
  double sum = 0;
  for (std::size_t die = 0; die < state.dice.size(); ++die)
    sum += log_density_of(world.dice[die], state.dice[die]);
  for (const Override& one : state.overrides) {
    const double here = log_density_of(world.table, one.control);
    if (here == k_impossible) return k_impossible;
    sum +=
        here - log_density_of(world.table, control_of_key(world.table, state.table_key, one.index));
  }
  return sum;
}

SurfaceControl control_at(const WorldParameters& world, const State& state, GridIndex index) {
  const Override* found = find_override(state.overrides, index);
  return found != nullptr ? found->control : control_of_key(world.table, state.table_key, index);
}

}  // namespace sleight::worlds::dice
