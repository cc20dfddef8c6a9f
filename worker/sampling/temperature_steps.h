// Weights of a step from inverse temperature beta to beta', for several methods. With l = log p_c,
// the log weight is always (beta' - beta) l: the log of a state's density at beta' divided by its
// density at beta. Methods differ in the state whose l they use, and in additional terms.
// Thread safety: pure functions. temperature_steps.cpp contains only formulas, so a test program
// can link wrong formulas instead (tests/unit/worker/sampling/replaced_formulas.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace sleight::sampling {

/// Returns the log weight that a level's draw has at the next cooler level (round_statistics.h).
double stone_log_weight(std::span<const double> ladder, std::size_t level, double l);

/// An ascent's step to the schedule's temperature number `to`.
struct AscentStep {
  std::span<const double> schedule;
  std::size_t to = 1;
  double l_before = 0;  ///< l of the state at temperature `to` - 1.
  double l_after = 0;   ///< l of the state at temperature `to`.
};
/// Returns the log of the step's weight (annealed_importance.h, Neal 2001, equation 3).
double ascent_log_weight(const AscentStep& step);

/// Returns the level that a simulated-tempering chain proposes. At an end, this is `level`.
std::uint32_t proposed_level(std::uint32_t level, bool up, std::uint32_t levels);

/// Simulated tempering's proposal to change the level.
struct LevelMove {
  std::span<const double> ladder;
  std::span<const double> log_weights;
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  double l = 0;
};
/// Returns the log of the acceptance ratio (simulated_tempering.h).
double log_level_ratio(const LevelMove& move);

/// A tempered transition's step between two temperatures; `above` is the cooler temperature.
struct ExcursionStep {
  double above = 1;
  double below = 0;
  double l = 0;
  bool down = true;  ///< Towards the hottest level, or back.
};
/// Returns the step's term in the log ratio (tempered_transition.h).
double excursion_log_weight(const ExcursionStep& step);

}  // namespace sleight::sampling
