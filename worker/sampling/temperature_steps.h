// What a step from one inverse temperature to another weighs, in each method that makes one. It is
// (beta' - beta) l throughout, l = log p_c: the log of the ratio of a state's density at beta' to
// that at beta. Methods differ in which state's l they take, and in what they add.
//
// Thread safety: pure functions. The formulas are in temperature_steps.cpp and nothing else is, so
// that a test program can link wrong ones in their place (tests/unit/worker/sampling/
// replaced_formulas.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace sleight::sampling {

/// log of what a draw of a level weighs at the next cooler one: stepping stones
/// (round_statistics.h).
double stone_log_weight(std::span<const double> ladder, std::size_t level, double l);

/// A step of an ascent, to temperature `to` of the schedule.
struct AscentStep {
  std::span<const double> schedule;
  std::size_t to = 1;
  double l_before = 0;  ///< of the state that was sampled one temperature below
  double l_after = 0;   ///< of the one sampled at `to`
};
/// log of the weight that it adds (annealed_importance.h; Neal 2001, equation 3).
double ascent_log_weight(const AscentStep& step);

/// The level that a simulated-tempering chain proposes to go to; its own beyond an end.
std::uint32_t proposed_level(std::uint32_t level, bool up, std::uint32_t levels);

/// A proposal of simulated tempering to change its level.
struct LevelMove {
  std::span<const double> ladder;
  std::span<const double> log_weights;
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  double l = 0;
};
/// log of its ratio (simulated_tempering.h).
double log_level_ratio(const LevelMove& move);

/// A tempered transition's step between two temperatures, `above` being the cooler one.
struct ExcursionStep {
  double above = 1;
  double below = 0;
  double l = 0;
  bool down = true;  ///< on the way to the hottest, or back from there
};
/// What it adds to the log of the ratio (tempered_transition.h).
double excursion_log_weight(const ExcursionStep& step);

}  // namespace sleight::sampling
