#include "worker/sampling/temperature_steps.h"

namespace sleight::sampling {

double stone_log_weight(std::span<const double> ladder, std::size_t level, double l) {
  return (ladder[level + 1] - ladder[level]) * l;
}

double ascent_log_weight(const AscentStep& step) {
  return (step.schedule[step.to] - step.schedule[step.to - 1]) * step.l_before;
}

std::uint32_t proposed_level(std::uint32_t level, bool up, std::uint32_t levels) {
  if (up) return level + 1 == levels ? level : level + 1;
  return level == 0 ? level : level - 1;
}

double log_level_ratio(const LevelMove& move) {
  const double step = move.ladder[move.to] - move.ladder[move.from];
  return step * move.l + move.log_weights[move.to] - move.log_weights[move.from];
}

double excursion_log_weight(const ExcursionStep& step) {
  const double sign = step.down ? 1 : -1;
  return sign * (step.below - step.above) * step.l;
}

}  // namespace sleight::sampling
