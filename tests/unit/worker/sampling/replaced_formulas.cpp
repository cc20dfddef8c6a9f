#include "tests/unit/worker/sampling/replaced_formulas.h"

#include <utility>

#include "common/random/stream.h"

// The library's sources under other names.
#define even_odd_partner right_even_odd_partner
#define log_swap_ratio right_log_swap_ratio
#define swap_number right_swap_number
#define stone_log_weight right_stone_log_weight
#define ascent_log_weight right_ascent_log_weight
#define proposed_level right_proposed_level
#define log_level_ratio right_log_level_ratio
#define excursion_log_weight right_excursion_log_weight
#include "worker/sampling/swap.cpp"
#include "worker/sampling/temperature_steps.cpp"
#undef even_odd_partner
#undef log_swap_ratio
#undef swap_number
#undef stone_log_weight
#undef ascent_log_weight
#undef proposed_level
#undef log_level_ratio
#undef excursion_log_weight

namespace sleight::sampling {
namespace {

Formulas& present() {
  static Formulas formulas;
  return formulas;
}

}  // namespace

Replaced::Replaced(const Formulas& formulas) : before_(std::exchange(present(), formulas)) {}
Replaced::~Replaced() {
  present() = before_;
}

std::optional<std::uint32_t> even_odd_partner(std::uint32_t level, std::uint64_t scan,
                                              std::uint32_t levels) {
  return present().partner(level, scan, levels);
}
double log_swap_ratio(const SwapPair& pair) {
  return present().log_swap_ratio(pair);
}
double swap_number(const SwapPlace& place) {
  return present().swap_number(place);
}
double stone_log_weight(std::span<const double> ladder, std::size_t level, double l) {
  return present().stone_log_weight(ladder, level, l);
}
double ascent_log_weight(const AscentStep& step) {
  return present().ascent_log_weight(step);
}
std::uint32_t proposed_level(std::uint32_t level, bool up, std::uint32_t levels) {
  return present().proposed_level(level, up, levels);
}
double log_level_ratio(const LevelMove& move) {
  return present().log_level_ratio(move);
}
double excursion_log_weight(const ExcursionStep& step) {
  return present().excursion_log_weight(step);
}

}  // namespace sleight::sampling
