// Requests for dice. Tests and benchmarks share them.
#pragma once

#include <cstdint>
#include <numbers>

#include "worker/worlds/dice/parameters.h"

namespace sleight::tests {

/// One die, which must rest within a tolerance of a place. Its six must be on top. `turned`: the
/// face two must also point along x.
inline worlds::dice::Parameters die(double tolerance_m, double sigma_m, bool turned) {
  constexpr double k_degree = std::numbers::pi / 180;
  worlds::dice::Parameters parameters;
  parameters.goals = {{.wanted = worlds::dice::Place{.centre_m = {0.03, 0}},
                       .sigma = sigma_m,
                       .tolerance = tolerance_m},
                      {.wanted = worlds::dice::FaceDirection{.face = 6},
                       .sigma = 10 * k_degree,
                       .tolerance = 30 * k_degree}};
  if (turned) {
    parameters.goals.push_back(
        {.wanted = worlds::dice::FaceDirection{.face = 2, .direction = {1, 0, 0}},
         .sigma = 5 * k_degree,
         .tolerance = 10 * k_degree});
  }
  return parameters;
}

/// The scene of requests/six_dice.toml: six dice are thrown together and must show 1 to 6 in a row.
inline worlds::dice::Parameters six_dice() {
  constexpr double k_degree = std::numbers::pi / 180;
  worlds::dice::Parameters parameters;
  parameters.world.dice.clear();
  for (std::uint32_t die = 0; die < 6; ++die) {
    worlds::dice::DieStart start;
    start.position_m.y() = -0.1 + 0.04 * die;
    start.position_sd_m.y() = 0.002;
    parameters.world.dice.push_back(start);
    parameters.goals.push_back(
        {.die = die,
         .wanted = worlds::dice::Place{.centre_m = {0.03, -0.15 + 0.06 * die}},
         .sigma = 0.005,
         .tolerance = 0.01});
  }
  for (std::uint32_t die = 0; die < 6; ++die) {
    parameters.goals.push_back({.die = die,
                                .wanted = worlds::dice::FaceDirection{.face = die + 1},
                                .sigma = 10 * k_degree,
                                .tolerance = 30 * k_degree});
  }
  return parameters;
}

}  // namespace sleight::tests
