// Parameters of the balls that spell (thesis 2.4.3, A.2). Lengths are in metres.
//
// The thesis specifies the bins, the box, the drop height and the uncertainty. The other values
// come from the spelling scene in the project's speed comparison. In that scene, the balls are
// glass marbles of 16 mm. Restitution is 0.6, friction is 0.2, and a ball drops every 0.15 s.
#pragma once

#include <cstdint>

#include "worker/worlds/spelling/pattern.h"

namespace sleight::worlds::spelling {

inline constexpr std::uint32_t k_columns_max = 64;
inline constexpr std::uint32_t k_rows_max = 12;
inline constexpr std::uint32_t k_solo_steps_max = 1000;

struct WorldParameters {
  double bin_m = 0.020;               ///< clear side of a bin (A.2.1)
  double partition_m = 0.002;         ///< thickness (A.2.1)
  double partition_height_m = 0.012;  ///< without vertex offsets (A.2.1)
  double box_height_m = 0.036;        ///< height of the walls around all bins (A.2.1)
  double drop_height_m = 0.072;  ///< height of a ball's lowest point when it is dropped (A.2.1)
  double vertex_sd_m = 0.0001;   ///< of each coordinate of a partition vertex (A.2.1)
  // The thesis leaves the following values open.
  double dome_m = 0.001;  ///< the floor's middle is higher than its rim by this
  double ball_diameter_m = 0.016;
  double density_kgpm3 = 2500;    ///< glass
  double drop_interval_s = 0.15;  ///< ball i is dropped at i times this
  double restitution = 0.6;
  double friction = 0.2;
  double gravity_mps2 = 9.81;
  // The next three values tell when slow contacts end. Speeds are in units of sqrt(gravity x ball
  // diameter), times in sqrt(ball diameter / gravity). The values are part of the model, since
  // outcomes depend on them. With the default sizes, the three values are 0.02 m/s, 0.04 m/s and 4
  // ms; the smallest bounces are 20 um high. If the box fills a picture 3,840 wide, such a bounce
  // is half a pixel high.
  double bounce_end = 0.05;  ///< bounces that would separate more slowly end
  double rest_speed = 0.1;   ///< a ball in balance rests if it was slower than this for rest_time
  double rest_time = 0.1;    ///< in units of sqrt(ball diameter / gravity)
  double time_limit_s = 10;  ///< after the last drop, if balls don't come to rest
};

struct ConstraintParameters {
  double log_lambda = 5;  ///< p_c = lambda^k (2.4.3)
};

/// How states are drawn, and how proposals are weighted (proposals.h).
enum class Kernel : std::uint8_t {
  correct,  ///< preserves the target distribution
  /// A.2.2 as printed. This kernel doesn't preserve the target distribution; it only serves to
  /// reproduce the thesis's figures. Requests allow it only with plain Metropolis-Hastings, and
  /// archives carry a warning.
  thesis
};

/// Proposals of A.2.2, and two more kinds. All kinds' probabilities add up to 1.
struct ProposalParameters {
  Kernel kernel = Kernel::correct;
  double change_all = 0.04;
  double change_vertices = 0.32;
  double change_ball = 0.32;
  double disable_balls = 0.16;
  double enable_balls = 0.16;
  // Not of A.2.2 (aimed_drops.h).
  double aim_ball = 0;
  double scatter_ball = 0;
  /// Before all balls are simulated, an iteration judges this number of proposals by balls that
  /// fall alone (solo_balls.h). 0: off.
  std::uint32_t solo_steps = 0;
  double vertex_probability = 0.02;  ///< probability that each vertex moves
  double vertex_sd_m = 0.00005;      ///< standard deviation of each coordinate of a vertex move
  double vertex_redraw = 0;  ///< share of change_vertices that redraws one vertex from the prior
  double ball_sd_m = 0.020;  ///< standard deviation of a drop's move; as long as a bin's side
  double flip_probability = 0.25;  ///< probability that each ball is disabled or enabled
};

struct Parameters {
  WorldParameters world;
  Pattern pattern = hi();
  ConstraintParameters constraint;
  ProposalParameters proposal;
};

}  // namespace sleight::worlds::spelling
