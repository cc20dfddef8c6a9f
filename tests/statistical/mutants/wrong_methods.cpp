// Mistakes in the decisions of tempering: rules.h with one of them replaced.
#include <algorithm>

#include "common/math/elementary.h"
#include "tests/statistical/mutants/mutant.h"

namespace sleight::statistical {

using enum CheckId;

std::vector<Mutant> wrong_methods() {
  return {
      {.name = "swaps always",
       .what = "neighbours swap whatever their densities are",
       .checks = {ladder_keeps},
       .rules = {.log_swap_ratio = [](double, double, double, double) { return 0.0; }}},
      {.name = "swaps never",
       .what = "no swap is accepted, ever",
       .checks = {modes_are_found},
       .rules = {.log_swap_ratio = [](double, double, double, double) { return -1e300; }}},
      {.name = "swap ratio inverted",
       .what = "swaps are accepted with the inverse ratio",
       .checks = {ladder_keeps},
       .rules = {.log_swap_ratio =
                     [](double beta, double cooler, double l, double cooler_l) {
                       return -sampling::log_swap_ratio(beta, cooler, l, cooler_l);
                     }}},
      {.name = "swap of zero densities",
       .what = "log p_c of -inf is treated as 0 when two levels swap",
       .checks = {ladder_keeps},
       .rules = {.log_swap_ratio =
                     [](double beta, double cooler, double l, double cooler_l) {
                       return sampling::log_swap_ratio(beta, cooler, zero_for_log_zero(l),
                                                       zero_for_log_zero(cooler_l));
                     }}},
      {.name = "swap forgets temperatures",
       .what = "swaps are decided as if between inverse temperatures 0 and 1",
       .checks = {ladder_keeps},
       .rules = {.log_swap_ratio =
                     [](double, double, double l, double cooler_l) {
                       return sampling::log_swap_ratio(0, 1, l, cooler_l);
                     }}},
      {.name = "swap by the number itself",
       .what = "the uniform number's exponential is compared with the ratio",
       .checks = {ladder_keeps},
       .rules = {.swap_number =
                     [](const random::StreamKey& key, std::uint64_t scan) {
                       return math::exp(sampling::swap_number(key, scan));
                     }}},
      {.name = "swap's number reused",
       .what = "a pair's swaps are decided by the same number at every scan",
       .checks = {replicas_travel, ladder_keeps},
       .rules = {.swap_number = [](const random::StreamKey& key,
                                   std::uint64_t) { return sampling::swap_number(key, 0); }}},
      {.name = "parity stands still",
       .what = "the same pairs swap after every scan",
       .checks = {replicas_travel},
       .rules = {.partner =
                     [](std::uint32_t level, std::uint64_t, std::uint32_t levels) {
                       return sampling::even_odd_partner(level, 0, levels);
                     }}},
      {.name = "parity changes too slowly",
       .what = "even and odd pairs take turns of two scans",
       .checks = {replicas_travel},
       .rules = {.partner =
                     [](std::uint32_t level, std::uint64_t scan, std::uint32_t levels) {
                       return sampling::even_odd_partner(level, scan / 2, levels);
                     }}},
      {.name = "parity is odd",
       .what = "odd pairs swap where it is the even ones' turn",
       .checks = {replicas_travel},
       .rules = {.partner =
                     [](std::uint32_t level, std::uint64_t scan, std::uint32_t levels) {
                       return sampling::even_odd_partner(level, scan + 1, levels);
                     }}},
      {.name = "coolest left out",
       .what = "the coolest level has no partner, ever",
       .checks = {replicas_travel},
       .rules = {.partner =
                     [](std::uint32_t level, std::uint64_t scan, std::uint32_t levels) {
                       return level + 1 < levels
                                  ? sampling::even_odd_partner(level, scan, levels - 1)
                                  : std::nullopt;
                     }}},
      {.name = "stones off by one",
       .what = "a stepping stone weighs with the step below its own",
       .checks = {stones_weigh},
       .rules = {.stone_log_weight =
                     [](std::span<const double> ladder, std::size_t level, double l) {
                       return sampling::stone_log_weight(ladder, level == 0 ? 0 : level - 1, l);
                     }}},
      {.name = "stones of zero density",
       .what = "log p_c of -inf is treated as 0 by stepping stones",
       .checks = {stones_weigh},
       .rules = {.stone_log_weight =
                     [](std::span<const double> ladder, std::size_t level, double l) {
                       return sampling::stone_log_weight(ladder, level, zero_for_log_zero(l));
                     }}},
      {.name = "ascent off by one",
       .what = "an ascent's step weighs with the temperatures of the one before",
       .checks = {ascents_weigh},
       .rules = {.ascent_log_weight =
                     [](const sampling::AscentStep& step) {
                       sampling::AscentStep before = step;
                       before.to = std::max<std::size_t>(step.to - 1, 1);
                       return sampling::ascent_log_weight(before);
                     }}},
      {.name = "ascent weighs the new state",
       .what = "an ascent's step weighs with the state after it in the place of the one before",
       .checks = {ascents_weigh},
       .rules = {.ascent_log_weight =
                     [](const sampling::AscentStep& step) {
                       sampling::AscentStep after = step;
                       after.l_before = step.l_after;
                       return sampling::ascent_log_weight(after);
                     }}},
      {.name = "level weights forgotten",
       .what = "simulated tempering moves as if all levels had weight 1",
       .checks = {levels_walk},
       .rules = {.log_level_ratio =
                     [](const sampling::LevelMove& move) {
                       return (move.ladder[move.to] - move.ladder[move.from]) * move.l;
                     }}},
      {.name = "level weights inverted",
       .what = "simulated tempering divides by weights where it should multiply",
       .checks = {levels_walk},
       .rules = {.log_level_ratio =
                     [](const sampling::LevelMove& move) {
                       return (move.ladder[move.to] - move.ladder[move.from]) * move.l +
                              move.log_weights[move.from] - move.log_weights[move.to];
                     }}},
      {.name = "level weights off by one",
       .what = "simulated tempering takes each level's weight from its cooler neighbour",
       .checks = {levels_walk},
       .rules = {.log_level_ratio =
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
       .rules = {.log_level_ratio =
                     [](const sampling::LevelMove& move) {
                       return move.ladder[move.to] * move.l + move.log_weights[move.to] -
                              move.log_weights[move.from];
                     }}},
      {.name = "levels turn back at the ends",
       .what = "a move beyond an end goes the other way, and nothing makes up for it",
       .checks = {levels_walk},
       .rules = {.proposed_level =
                     [](std::uint32_t level, bool up, std::uint32_t levels) {
                       const std::uint32_t to = sampling::proposed_level(level, up, levels);
                       return to == level ? sampling::proposed_level(level, !up, levels) : to;
                     }}},
      {.name = "way up not weighed",
       .what = "a tempered transition's ratio has the way down alone",
       .checks = {excursions_keep},
       .rules = {.excursion_log_weight =
                     [](const sampling::ExcursionStep& step) {
                       return step.down ? sampling::excursion_log_weight(step) : 0.0;
                     }}},
      {.name = "excursion inverted",
       .what = "a tempered transition is accepted with the inverse ratio",
       .checks = {excursions_keep},
       .rules = {.excursion_log_weight =
                     [](const sampling::ExcursionStep& step) {
                       return -sampling::excursion_log_weight(step);
                     }}},
      {.name = "excursion's first step left out",
       .what = "the step from the coolest temperature weighs nothing, down or up",
       .checks = {excursions_keep},
       .rules = {.excursion_log_weight =
                     [](const sampling::ExcursionStep& step) {
                       return step.above >= 0.8 ? 0.0 : sampling::excursion_log_weight(step);
                     }}},
      {.name = "excursion accepted always",
       .what = "a tempered transition's candidate is never rejected",
       .checks = {excursions_keep},
       .rules = {.excursion_log_weight = [](const sampling::ExcursionStep&) { return 0.0; }}},
  };
}

}  // namespace sleight::statistical
