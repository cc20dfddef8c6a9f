// Temporarily replaces formulas of tempering (worker/sampling/swap.h, temperature_steps.h) by wrong
// formulas. Tests must detect the wrong formulas.
//
// A test program that compiles replaced_formulas.cpp defines these functions itself, so the linker
// omits the library's objects with the same functions. Unless replaced, these functions call the
// library's sources, which the program compiles under names that begin with right_. If the library
// gains a formula that is missing here, the linker reports a duplicate definition. Not thread-safe.
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

/// Replaces the formulas during its lifetime. May nest.
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
