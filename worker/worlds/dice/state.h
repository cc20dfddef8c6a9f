// The random variables of a throw of dice, and their distribution p_w.
//
// The table is a key with overrides (random_table.h). Each die is described by its start.
//
// Density. The starts' density is normalised: normal in each random component. A uniform
// orientation's density is with respect to the surface of the unit sphere in four dimensions. The
// table's density is relative to the control points that its key draws. Each override adds its log
// density minus the log density of the key's point at the same index. So a freshly drawn table has
// log density 0, whatever its size. Relative densities suffice because Metropolis-Hastings uses
// only ratios. If two tables have the same key, the ratio of relative densities is the true ratio.
// If a proposal draws a new key, the q ratio is the present table's density divided by the new
// table's density. The q ratio times the target's ratio is 1 for any reference densities, because
// both ratios contain the same densities. Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/bytes.h"
#include "common/random/stream.h"
#include "worker/worlds/dice/parameters.h"
#include "worker/worlds/dice/random_table.h"

namespace sleight::worlds::dice {

struct DieThrow {
  Vec3 position_m{0, 0, 0};
  Quat orientation = Quat::Identity();
  Vec3 velocity_mps{0, 0, 0};
  Vec3 spin_radps{0, 0, 0};
  friend bool operator==(const DieThrow& a, const DieThrow& b) {
    return a.position_m == b.position_m && a.orientation.coeffs() == b.orientation.coeffs() &&
           a.velocity_mps == b.velocity_mps && a.spin_radps == b.spin_radps;
  }
};

struct State {
  std::uint64_t table_key = 0;
  Overrides overrides{};
  std::vector<DieThrow> dice{};
  friend bool operator==(const State&, const State&) = default;
};

DieThrow draw_throw(const DieStart& start, random::Stream& stream);
/// Returns -infinity if a fixed component differs from its fixed value.
double log_density_of(const DieStart& start, const DieThrow& one);

State draw_state(const WorldParameters& world, random::Stream& stream);
/// REQUIRES: the state has as many dice as the world.
double log_density_of(const WorldParameters& world, const State& state);

/// Encodes a state: the table's key (u64) and the number of overrides (u64), then each override's
/// index (i32, i32), height, restitution and friction (f64), then each die's position, orientation
/// (w, x, y, z), velocity and spin (f64).
base::Bytes encode(const State& state);
/// Refuses a wrong length, numbers that aren't finite, overrides that are out of order, off the
/// table or out of range, and orientations whose norm isn't 1.
std::optional<State> decode(const WorldParameters& world, base::BytesView bytes);

SurfaceControl control_at(const WorldParameters& world, const State& state, GridIndex index);

}  // namespace sleight::worlds::dice
