// A bumpy table of random control points (thesis 2.4.4). Control points are computed only where
// they are used. So even if a table has a hundred million points, a throw costs only the few tens
// of points that it touches.
//
// Idea. Each control point (surface_controls.h) has a height N(0, height_sd), a restitution and a
// friction. Restitution and friction are uniform in their ranges or constant, and all values are
// independent. If the table's key is k, the point (i, j) draws its values from the stream (seed k,
// purpose table, iteration (i, j)). The stream is a pure function. So a key determines a whole
// table, and a uniformly drawn key draws one of 2^64 tables. Overrides store the points that a
// sampler has changed.
//
// Frame: the world's. The table has `columns` points along i. The first is at -columns/2 (integer
// division). Along j, the table has `rows` points; the first is at -rows/2. A flat apron surrounds
// the table. The apron's height is 0; its restitution and friction are the means of the ranges.
//
// Invariants
//   1. Tables with the same key and parameters differ only where their overrides differ.
//   2. Overrides are in ascending order of index, have no duplicates, and are on the table.
// Thread safety: immutable after construction.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "worker/physics/surface/surface_controls.h"
#include "worker/worlds/dice/parameters.h"

namespace sleight::worlds::dice {

/// The log density of an impossible value.
inline constexpr double k_impossible = -std::numeric_limits<double>::infinity();

using physics::GridIndex;
using physics::SurfaceControl;

/// A control point that replaces the point drawn from the key.
struct Override {
  GridIndex index;
  SurfaceControl control;
  friend bool operator==(const Override&, const Override&) = default;
};
using Overrides = std::vector<Override>;

GridIndex first_of(const TableParameters& table);
GridIndex last_of(const TableParameters& table);
bool is_on_table(const TableParameters& table, GridIndex index);

/// Returns the control point that the key draws at an index. Outside the table, returns the apron's
/// point.
SurfaceControl control_of_key(const TableParameters& table, std::uint64_t key, GridIndex index);

/// Returns the log density of a control point on the table. The density is normalised over the
/// random fields. If a field has an impossible value, the result is -infinity.
double log_density_of(const TableParameters& table, const SurfaceControl& control);

/// Returns null if there is no override at the index.
const Override* find_override(const Overrides& overrides, GridIndex index);
/// Inserts or replaces an override. Keeps the order.
void set_override(Overrides& overrides, const Override& one);

/// Returns the indices at which two lists differ, in ascending order.
std::vector<GridIndex> differences(const Overrides& a, const Overrides& b);

class RandomTable final : public physics::SurfaceControls {
 public:
  /// REQUIRES: invariant 2.
  RandomTable(const TableParameters& table, std::uint64_t key, Overrides overrides);

  SurfaceControl at(GridIndex index) const override;
  /// Returns the indices at which overrides differ. If `before` isn't a RandomTable, or if its key
  /// or parameters differ, returns nothing.
  std::optional<std::vector<GridIndex>> changed_from(const SurfaceControls& before) const override;

 private:
  TableParameters table_;
  std::uint64_t key_;
  Overrides overrides_;
};

}  // namespace sleight::worlds::dice
