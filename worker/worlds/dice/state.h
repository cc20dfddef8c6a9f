// What is uncertain of a throw of dice, and its distribution p_w.
//
// The table is a key and overrides (random_table.h), the dice are their starts.
//
// Density. That of the starts' random components is normalised: normal in each component, and for
// a uniform orientation with respect to the surface of the unit sphere of four dimensions. Of the
// table it is that of its control points relative to those that its key draws: a sum over the
// overrides of log density of the override less log density of what the key has in its place. So a
// table just drawn has 0, however large it is. Nothing is lost: Metropolis-Hastings sees ratios
// only. Between tables of one key the ratio is that of the tables. A proposal that draws a new key
// has as its ratio that of two draws, the density of the present table over that of the new one;
// times the target's own ratio that is 1, whichever density of a whole table, the key's or another,
// both are taken relative to.
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <vector>

#include "common/random/stream.h"
#include "worker/worlds/dice/parameters.h"
#include "worker/worlds/dice/random_table.h"

namespace sleight::worlds::dice {

/// How a die is thrown.
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
  Overrides overrides;
  std::vector<DieThrow> dice;
  friend bool operator==(const State&, const State&) = default;
};

DieThrow draw_throw(const DieStart& start, random::Stream& stream);
/// -infinity where a component that is fixed isn't so.
double log_density_of(const DieStart& start, const DieThrow& one);

State draw_state(const WorldParameters& world, random::Stream& stream);
/// REQUIRES: as many dice as the world has.
double log_density_of(const WorldParameters& world, const State& state);

/// What the table of a state has at a place.
SurfaceControl control_at(const WorldParameters& world, const State& state, GridIndex index);

}  // namespace sleight::worlds::dice
