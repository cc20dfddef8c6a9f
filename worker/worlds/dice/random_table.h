// A bumpy table of random control points (thesis 2.4.4): made where somebody looks, and nowhere
// else, so that a table of a hundred million points costs no more than the tens that a throw
// touches.
//
// Idea. Each control point (surface_controls.h) has a height N(0, height_sd) and a restitution and
// a friction, each uniform in its range or constant, all independent. The point (i, j) of the table
// with key k draws them from the stream (seed k, purpose table, iteration (i, j)): a pure function.
// So a key is a whole table, and a key drawn uniformly is a draw from the distribution of tables
// (of 2^64 of them). Points that a sampler has changed are overrides, held one by one.
//
// Frame: the world's. The table's points are i = -columns/2 ... (whole division), columns of them,
// likewise j. Beyond lies a flat apron: height 0, restitution and friction the ranges' means.
//
// Invariants
//   1. Of one key and parameters, at() differs at most where overrides differ.
//   2. Overrides are in ascending order of their places, one at each, all on the table.
// Thread safety: immutable after construction.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "worker/physics/surface/surface_controls.h"
#include "worker/worlds/dice/parameters.h"

namespace sleight::worlds::dice {

/// The log density where there is none.
inline constexpr double k_impossible = -std::numeric_limits<double>::infinity();

using physics::GridIndex;
using physics::SurfaceControl;

/// A control point that isn't the key's.
struct Override {
  GridIndex index;
  SurfaceControl control;
  friend bool operator==(const Override&, const Override&) = default;
};
using Overrides = std::vector<Override>;

/// The first and the last place of a table.
GridIndex first_of(const TableParameters& table);
GridIndex last_of(const TableParameters& table);
bool is_on_table(const TableParameters& table, GridIndex index);

/// What the key has at a place, or the apron.
SurfaceControl control_of_key(const TableParameters& table, std::uint64_t key, GridIndex index);

/// Of a control point on the table; normalised over those fields that are random, -infinity where a
/// field can't be so.
double log_density_of(const TableParameters& table, const SurfaceControl& control);

/// Null if the place has none.
const Override* find_override(const Overrides& overrides, GridIndex index);
/// In its place in the order.
void set_override(Overrides& overrides, const Override& one);

/// The places where two lists differ, ascending.
std::vector<GridIndex> differences(const Overrides& a, const Overrides& b);

class RandomTable final : public physics::SurfaceControls {
 public:
  /// REQUIRES: invariant 2.
  RandomTable(const TableParameters& table, std::uint64_t key, Overrides overrides);

  SurfaceControl at(GridIndex index) const override;
  /// Where overrides differ; nothing if the key or the parameters do, or it isn't such a table.
  std::optional<std::vector<GridIndex>> changed_from(const SurfaceControls& before) const override;

 private:
  TableParameters table_;
  std::uint64_t key_;
  Overrides overrides_;
};

}  // namespace sleight::worlds::dice
