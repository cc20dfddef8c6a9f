// The 2D ball's parameters (thesis 2.2, 2.4.1). Defaults are the thesis's values. Lengths are in
// ball diameters D where the thesis uses D; angles are in radians.
#pragma once

#include <cstdint>

namespace sleight::worlds::ball_2d {

inline constexpr std::uint32_t k_collisions_max = 64;

struct WorldParameters {
  double diameter_m = 0.1;     ///< D; the thesis leaves it open, and it scales only the picture
  double gravity_mps2 = 9.81;  ///< the thesis leaves it open, and it scales only time
  double drop_height_diameters = 4.5;  ///< fall before the first collision
  std::uint32_t collisions = 5;        ///< with a random normal; the ball lands on the next one
  double normal_sd_rad = 0.17453292519943295;  ///< 10 degrees from the vertical
  double restitution = 0.70710678118654752;    ///< 1/sqrt(2), on the normal component
};

struct ConstraintParameters {
  double target_diameters = 1.0;     ///< wanted landing place, from below the start
  double sigma_diameters = 0.1;      ///< sigma_d: standard deviation of p_c
  double tolerance_diameters = 0.1;  ///< maximum distance from the target
};

struct ProposalParameters {
  double change_probability = 0.5;                      ///< probability that each normal changes
  double change_half_width_rad = 0.087266462599716474;  ///< uniform(-5, 5) degrees
};

struct Parameters {
  WorldParameters world;
  ConstraintParameters constraint;
  ProposalParameters proposal;
};

}  // namespace sleight::worlds::ball_2d
