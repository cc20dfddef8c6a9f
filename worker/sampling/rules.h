// The decisions of tempering methods as an object: who may swap, with which ratio, what a step
// between two temperatures weighs. Methods take them from here and nowhere else, so that a test can
// put a wrong one in the place of one and see that statistical checks notice
// (tests/statistical/mutants). Nothing but tests replaces any.
//
// l stands for log p_c of a state throughout. Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "common/random/stream.h"
#include "worker/sampling/ladder.h"

namespace sleight::sampling {

/// Deterministic even-odd: after scan s the levels (i, i+1) with i + s even. None for an end that
/// has no neighbour then.
inline std::optional<std::uint32_t> even_odd_partner(std::uint32_t level, std::uint64_t scan,
                                                     std::uint32_t levels) {
  const bool is_hotter = (level + scan) % 2 == 0;
  if (is_hotter) return level + 1 < levels ? std::optional(level + 1) : std::nullopt;
  return level > 0 ? std::optional(level - 1) : std::nullopt;
}

/// The number that decides on the swap of a pair (the key's replica is the hotter level) at a scan.
inline double swap_number(const random::StreamKey& key, std::uint64_t scan) {
  return random::Stream(key, scan).uniform();
}

/// log of what a draw of a level weighs at the next cooler one: stepping stones.
inline double stone_log_weight(std::span<const double> ladder, std::size_t level, double l) {
  return (ladder[level + 1] - ladder[level]) * l;
}

/// A step of an ascent, to temperature `to` of the schedule.
struct AscentStep {
  std::span<const double> schedule;
  std::size_t to = 1;
  double l_before = 0;  ///< of the state that was sampled one temperature below
  double l_after = 0;   ///< of the one sampled at `to`
};
/// log of the weight that it adds (Neal 2001, equation 3).
inline double ascent_log_weight(const AscentStep& step) {
  return (step.schedule[step.to] - step.schedule[step.to - 1]) * step.l_before;
}

/// The level that a simulated-tempering chain proposes to go to; its own beyond an end.
inline std::uint32_t proposed_level(std::uint32_t level, bool up, std::uint32_t levels) {
  if (up) return level + 1 == levels ? level : level + 1;
  return level == 0 ? level : level - 1;
}

/// A proposal of simulated tempering to change its level.
struct LevelMove {
  std::span<const double> ladder;
  std::span<const double> log_weights;
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  double l = 0;
};
/// log of its ratio (simulated_tempering.h).
inline double log_level_ratio(const LevelMove& move) {
  const double step = move.ladder[move.to] - move.ladder[move.from];
  return step * move.l + move.log_weights[move.to] - move.log_weights[move.from];
}

/// A tempered transition's step between two temperatures, `above` being the cooler one.
struct ExcursionStep {
  double above = 1;
  double below = 0;
  double l = 0;
  bool down = true;  ///< on the way to the hottest, or back from there
};
/// What it adds to the log of the ratio (tempered_transition.h).
inline double excursion_log_weight(const ExcursionStep& step) {
  const double sign = step.down ? 1 : -1;
  return sign * (step.below - step.above) * step.l;
}

struct Rules {
  decltype(&even_odd_partner) partner = even_odd_partner;
  decltype(&sampling::log_swap_ratio) log_swap_ratio = sampling::log_swap_ratio;
  decltype(&sampling::swap_number) swap_number = sampling::swap_number;
  decltype(&sampling::stone_log_weight) stone_log_weight = sampling::stone_log_weight;
  decltype(&sampling::ascent_log_weight) ascent_log_weight = sampling::ascent_log_weight;
  decltype(&sampling::proposed_level) proposed_level = sampling::proposed_level;
  decltype(&sampling::log_level_ratio) log_level_ratio = sampling::log_level_ratio;
  decltype(&sampling::excursion_log_weight) excursion_log_weight = sampling::excursion_log_weight;
};

}  // namespace sleight::sampling
