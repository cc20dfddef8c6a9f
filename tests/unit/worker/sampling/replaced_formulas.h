// Formulas of tempering (worker/sampling/swap.h, temperature_steps.h) replaced by wrong ones, for a
// while: tests that must notice.
//
// A test program that has replaced_formulas.cpp among its sources defines these functions itself,
// so the linker leaves the library's objects of the same functions out. They do what the library's
// sources say, which are compiled into them as right_..., unless one is replaced. A formula that is
// added to the sources and not here is defined twice, which the linker refuses.
// Not thread-safe.
#pragma once

#include "worker/sampling/swap.h"
#include "worker/sampling/temperature_steps.h"

namespace sleight::sampling {

decltype(even_odd_partner) right_even_odd_partner;
decltype(log_swap_ratio) right_log_swap_ratio;
decltype(swap_number) right_swap_number;
decltype(stone_log_weight) right_stone_log_weight;
decltype(ascent_log_weight) right_ascent_log_weight;
decltype(proposed_level) right_proposed_level;
decltype(log_level_ratio) right_log_level_ratio;
decltype(excursion_log_weight) right_excursion_log_weight;

struct Formulas {
  decltype(&right_even_odd_partner) partner = right_even_odd_partner;
  decltype(&right_log_swap_ratio) log_swap_ratio = right_log_swap_ratio;
  decltype(&right_swap_number) swap_number = right_swap_number;
  decltype(&right_stone_log_weight) stone_log_weight = right_stone_log_weight;
  decltype(&right_ascent_log_weight) ascent_log_weight = right_ascent_log_weight;
  decltype(&right_proposed_level) proposed_level = right_proposed_level;
  decltype(&right_log_level_ratio) log_level_ratio = right_log_level_ratio;
  decltype(&right_excursion_log_weight) excursion_log_weight = right_excursion_log_weight;
};

/// As long as it lives, these are the formulas. They may nest.
class Replaced {
 public:
  explicit Replaced(const Formulas& formulas);
  ~Replaced();
  Replaced(const Replaced&) = delete;
  Replaced& operator=(const Replaced&) = delete;

 private:
  Formulas before_;
};

}  // namespace sleight::sampling
