// Parameters of the dice on a random table (thesis 2.4.4). Units are SI. The z axis points up. The
// table is at height 0, around the origin.
//
// The thesis gives no values. The die, its throw and the table's bumps come from the dice scene in
// the project's speed comparison.
#pragma once

#include <cstdint>
#include <vector>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "worker/worlds/dice/goals.h"

namespace sleight::worlds::dice {

inline constexpr std::uint32_t k_dice_max = 20;
inline constexpr std::uint32_t k_grid_max = 10'000;  ///< control points along a side
inline constexpr double k_dice_apart_m = 0.045;      ///< between dice's starts, in y

/// A uniform distribution between two numbers, or a constant if they are equal.
struct Range {
  double low = 0;
  double high = 0;
  bool is_constant() const { return low == high; }
  double mean() const { return 0.5 * (low + high); }
  friend bool operator==(const Range&, const Range&) = default;
};

struct TableParameters {
  double spacing_m = 0.021;  ///< distance between control points
  std::uint32_t columns = 64;
  std::uint32_t rows = 64;
  /// Standard deviation of a control point's height. The surface's heights have a standard
  /// deviation of 0.48 times this, which is 0.6 mm by default.
  double height_sd_m = 0.00125;
  Range restitution{0.5, 0.5};
  Range friction{0.4, 0.4};
  friend bool operator==(const TableParameters&, const TableParameters&) = default;
};

enum class StartOrientation : std::uint8_t { uniform, fixed };

/// A die's start. Each component is normal; a component with standard deviation 0 is fixed.
struct DieStart {
  Vec3 position_m{-0.15, 0, 0.1};  ///< centre
  Vec3 position_sd_m{0.005, 0.005, 0};
  StartOrientation orientation = StartOrientation::uniform;
  Quat fixed_orientation = Quat::Identity();  ///< used if the orientation is fixed
  Vec3 velocity_mps{0.7, 0, 0};
  Vec3 velocity_sd_mps{0.1, 0.1, 0};
  Vec3 spin_radps{0, 0, 0};
  Vec3 spin_sd_radps{20, 20, 20};
  double start_s = 0;  ///< release time
};

struct WorldParameters {
  double side_m = 0.016;
  double density_kgpm3 = 1200;
  double dice_restitution = 0.5;  ///< between dice
  double dice_friction = 0.4;
  double gravity_mps2 = 9.81;
  double time_max_s = 6;  ///< time limit for dice that don't come to rest
  TableParameters table;
  std::vector<DieStart> dice{DieStart{}};
};

/// Probabilities and step sizes of the kinds of proposals (proposals.h). The probabilities add up
/// to 1.
struct ProposalParameters {
  double change_all = 0.02;
  double change_die = 0.03;
  double change_start = 0.8;
  double change_control = 0.03;
  double change_contact = 0.12;
  // Standard deviations of steps, before halvings.
  double position_m = 0.005;
  double velocity_mps = 0.1;
  double spin_radps = 20;
  double turn_rad = 0.52359877559829887;  ///< 30 degrees
  double height_m = 0.001;
  double restitution = 0.2;
  double friction = 0.2;
  std::uint32_t halvings = 4;  ///< a step is halved 0 to this many times
};

struct Parameters {
  WorldParameters world;
  Numbering numbering = Numbering::free;
  std::vector<Goal> goals;
  ProposalParameters proposal;
};

}  // namespace sleight::worlds::dice
