// The 2D ball's numbers (thesis 2.2, 2.4.1), as a request gives them and with the thesis's values
// as defaults. Lengths are in ball diameters D where the thesis gives them so; angles in radians.
#pragma once

#include <cstdint>

namespace sleight::worlds::ball_2d {

inline constexpr std::uint32_t k_collisions_max = 64;

struct WorldParameters {
  double diameter_m = 0.1;             ///< D; the thesis leaves it open: it scales the picture only
  double gravity_mps2 = 9.81;          ///< likewise: it scales time only
  double drop_height_diameters = 4.5;  ///< how far the ball falls before its first collision
  std::uint32_t collisions = 5;  ///< collisions with a random normal; it lands on the next one
  double normal_sd_rad = 0.17453292519943295;  ///< 10 degrees: of each normal from the vertical
  double restitution = 0.70710678118654752;    ///< 1/sqrt(2), on the normal component
};

struct ConstraintParameters {
  double target_diameters = 1.0;     ///< where the landing should be, from below the start
  double sigma_diameters = 0.1;      ///< sigma_d: standard deviation of p_c
  double tolerance_diameters = 0.1;  ///< an animation within it of the target is satisfied
};

/// Algorithm 2.2.
struct ProposalParameters {
  double change_probability = 0.5;  ///< each normal is changed with this probability
  double change_half_width_rad = 0.087266462599716474;  ///< by uniform(-5, 5) degrees
};

struct Parameters {
  WorldParameters world;
  ConstraintParameters constraint;
  ProposalParameters proposal;
};

}  // namespace sleight::worlds::ball_2d
