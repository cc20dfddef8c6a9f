// Mistakes in the formulas of tempering. Each mistake replaces one formula.
#include <algorithm>

#include "common/math/elementary.h"
#include "tests/statistical/mutants/mutant.h"

namespace sleight::statistical {

std::vector<Mutant> wrong_methods() {
  using enum CheckId;
  return {
      {.name = "swaps always",
       .what = "neighbours swap whatever their densities are",
       .checks = {ladder_keeps},
       .formulas = {.log_swap_ratio = [](const sampling::SwapPair&) { return 0.0; }}},
      {.name = "swaps never",
       .what = "no swap is accepted, ever",
       .checks = {modes_are_found},
       .formulas = {.log_swap_ratio = [](const sampling::SwapPair&) { return -1e300; }}},
      {.name = "swap ratio inverted",
       .what = "swaps are accepted with the inverse ratio",
       .checks = {ladder_keeps},
       .formulas = {.log_swap_ratio =
                        [](const sampling::SwapPair& pair) {
                          return -sampling::right_log_swap_ratio(pair);
                        }}},
      {.name = "swap of zero densities",
       .what = "log p_c of -inf is treated as 0 when two levels swap",
       .checks = {ladder_keeps},
       .formulas = {.log_swap_ratio =
                        [](const sampling::SwapPair& pair) {
                          sampling::SwapPair other = pair;
                          other.log_constraint_hotter =
                              zero_for_log_zero(pair.log_constraint_hotter);
                          other.log_constraint_cooler =
                              zero_for_log_zero(pair.log_constraint_cooler);
                          return sampling::right_log_swap_ratio(other);
                        }}},
      {.name = "swap forgets temperatures",
       .what = "swaps are decided as if between inverse temperatures 0 and 1",
       .checks = {ladder_keeps},
       .formulas = {.log_swap_ratio =
                        [](const sampling::SwapPair& pair) {
                          sampling::SwapPair other = pair;
                          other.hotter = 0;
                          other.cooler = 1;
                          return sampling::right_log_swap_ratio(other);
                        }}},
      {.name = "swap by the number itself",
       .what = "the uniform number's exponential is compared with the ratio",
       .checks = {ladder_keeps},
       .formulas = {.swap_number =
                        [](const sampling::SwapPlace& place) {
                          return math::exp(sampling::right_swap_number(place));
                        }}},
      {.name = "swap's number reused",
       .what = "a pair's swaps are decided by the same number at every scan",
       .checks = {replicas_travel, ladder_keeps},
       .formulas = {.swap_number =
                        [](const sampling::SwapPlace& place) {
                          sampling::SwapPlace first = place;
                          first.scan = 0;
                          return sampling::right_swap_number(first);
                        }}},
      {.name = "parity stands still",
       .what = "the same pairs swap after every scan",
       .checks = {replicas_travel},
       .formulas = {.partner =
                        [](std::uint32_t level, std::uint64_t, std::uint32_t levels) {
                          return sampling::right_even_odd_partner(level, 0, levels);
                        }}},
      {.name = "parity changes too slowly",
       .what = "even and odd pairs take turns of two scans",
       .checks = {replicas_travel},
       .formulas = {.partner =
                        [](std::uint32_t level, std::uint64_t scan, std::uint32_t levels) {
                          return sampling::right_even_odd_partner(level, scan / 2, levels);
                        }}},
      {.name = "parity is odd",
       .what = "odd pairs swap where it is the even ones' turn",
       .checks = {replicas_travel},
       .formulas = {.partner =
                        [](std::uint32_t level, std::uint64_t scan, std::uint32_t levels) {
                          return sampling::right_even_odd_partner(level, scan + 1, levels);
                        }}},
      {.name = "coolest left out",
       .what = "the coolest level has no partner, ever",
       .checks = {replicas_travel},
       .formulas = {.partner =
                        [](std::uint32_t level, std::uint64_t scan, std::uint32_t levels) {
                          return level + 1 < levels
                                     ? sampling::right_even_odd_partner(level, scan, levels - 1)
                                     : std::nullopt;
                        }}},
      {.name = "stones off by one",
       .what = "a stepping stone weighs with the step below its own",
       .checks = {stones_weigh},
       .formulas = {.stone_log_weight =
                        [](std::span<const double> ladder, std::size_t level, double l) {
                          return sampling::right_stone_log_weight(ladder,
                                                                  level == 0 ? 0 : level - 1, l);
                        }}},
      {.name = "stones of zero density",
       .what = "log p_c of -inf is treated as 0 by stepping stones",
       .checks = {stones_weigh},
       .formulas = {.stone_log_weight =
                        [](std::span<const double> ladder, std::size_t level, double l) {
                          return sampling::right_stone_log_weight(ladder, level,
                                                                  zero_for_log_zero(l));
                        }}},
      {.name = "ascent off by one",
       .what = "an ascent's step weighs with the temperatures of the one before",
       .checks = {ascents_weigh},
       .formulas = {.ascent_log_weight =
                        [](const sampling::AscentStep& step) {
                          sampling::AscentStep before = step;
                          before.to = std::max<std::size_t>(step.to - 1, 1);
                          return sampling::right_ascent_log_weight(before);
                        }}},
      {.name = "ascent weighs the new state",
       .what = "an ascent's step weighs with the state after it in the place of the one before",
       .checks = {ascents_weigh},
       .formulas = {.ascent_log_weight =
                        [](const sampling::AscentStep& step) {
                          sampling::AscentStep after = step;
                          after.l_before = step.l_after;
                          return sampling::right_ascent_log_weight(after);
                        }}},
      {.name = "level weights forgotten",
       .what = "simulated tempering moves as if all levels had weight 1",
       .checks = {levels_walk},
       .formulas = {.log_level_ratio =
                        [](const sampling::LevelMove& move) {
                          return (move.ladder[move.to] - move.ladder[move.from]) * move.l;
                        }}},
      {.name = "level weights inverted",
       .what = "simulated tempering divides by weights where it should multiply",
       .checks = {levels_walk},
       .formulas = {.log_level_ratio =
                        [](const sampling::LevelMove& move) {
                          return (move.ladder[move.to] - move.ladder[move.from]) * move.l +
                                 move.log_weights[move.from] - move.log_weights[move.to];
                        }}},
      {.name = "level weights off by one",
       .what = "simulated tempering takes each level's weight from its cooler neighbour",
       .checks = {levels_walk},
       .formulas = {.log_level_ratio =
                        [](const sampling::LevelMove& move) {
                          const std::size_t last = move.ladder.size() - 1;
                          const auto weight = [&](std::size_t level) {
                            return move.log_weights[std::min(level + 1, last)];
                          };
                          return (move.ladder[move.to] - move.ladder[move.from]) * move.l +
                                 weight(move.to) - weight(move.from);
                        }}},
      {.name = "level's old temperature forgotten",
       .what = "simulated tempering weighs the state at the new temperature alone",
       .checks = {levels_walk},
       .formulas = {.log_level_ratio =
                        [](const sampling::LevelMove& move) {
                          return move.ladder[move.to] * move.l + move.log_weights[move.to] -
                                 move.log_weights[move.from];
                        }}},
      {.name = "levels turn back at the ends",
       .what = "a move beyond an end goes the other way, and nothing makes up for it",
       .checks = {levels_walk},
       .formulas = {.proposed_level =
                        [](std::uint32_t level, bool up, std::uint32_t levels) {
                          const std::uint32_t to =
                              sampling::right_proposed_level(level, up, levels);
                          return to == level ? sampling::right_proposed_level(level, !up, levels)
                                             : to;
                        }}},
      {.name = "way up not weighed",
       .what = "a tempered transition's ratio has the way down alone",
       .checks = {excursions_keep},
       .formulas = {.excursion_log_weight =
                        [](const sampling::ExcursionStep& step) {
                          return step.down ? sampling::right_excursion_log_weight(step) : 0.0;
                        }}},
      {.name = "excursion inverted",
       .what = "a tempered transition is accepted with the inverse ratio",
       .checks = {excursions_keep},
       .formulas = {.excursion_log_weight =
                        [](const sampling::ExcursionStep& step) {
                          return -sampling::right_excursion_log_weight(step);
                        }}},
      {.name = "excursion's first step left out",
       .what = "the step from the coolest temperature weighs nothing, down or up",
       .checks = {excursions_keep},
       .formulas = {.excursion_log_weight =
                        [](const sampling::ExcursionStep& step) {
                          return step.above >= 0.8 ? 0.0
                                                   : sampling::right_excursion_log_weight(step);
                        }}},
      {.name = "excursion accepted always",
       .what = "a tempered transition's candidate is never rejected",
       .checks = {excursions_keep},
       .formulas = {.excursion_log_weight = [](const sampling::ExcursionStep&) { return 0.0; }}},
  };
}

}  // namespace sleight::statistical
