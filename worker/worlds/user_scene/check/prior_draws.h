// Simulates prior draws of a scene, to tell what usually happens in it.
// Thread safety: pure functions and values.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "worker/worlds/user_scene/user_scene.h"

namespace sleight::worlds::user_scene {

struct PriorDraws {
  std::uint64_t count = 0;
  std::uint64_t overlap = 0;      ///< impossible starts (End)
  std::uint64_t failed = 0;       ///< simulations
  std::uint64_t not_settled = 0;  ///< a body still moved at end_s
  std::uint64_t met = 0;          ///< all constraints
  /// Least, mean and greatest of each value (Quantities::values).
  std::vector<std::array<double, 3>> values{};
  /// By constraint: how often it was met, and the least distance.
  std::vector<std::uint64_t> constraint_met{};
  std::vector<double> least_distances{};  ///< infinite without a simulation
};

/// Simulates the draws 0, 1, ... (sampling::nth_prior_draw), at most `count_max`. After each draw
/// the loop ends if `go_on` returns false.
PriorDraws prior_draws(const UserScene& world, std::uint64_t count_max,
                       const std::function<bool(std::uint64_t done)>& go_on);

/// Returns a sentence for each thing that needs attention.
std::vector<std::string> warnings_of(const UserScene& world, const PriorDraws& draws);

}  // namespace sleight::worlds::user_scene
