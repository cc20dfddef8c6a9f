#include "tests/thesis/figures_2/statistics.h"

#include <algorithm>

#include "common/base/check.h"

namespace sleight::thesis {
namespace {

using worlds::spelling::Kind;

void count_stays(const Chain& chain, Statistics& statistics) {
  bool away = true;
  std::uint64_t stay = 0;
  std::uint64_t correct = 0;
  for (std::uint64_t i = 0; i < chain.iterations.size(); ++i) {
    const std::uint32_t k = chain.iterations[i].filled;
    if (k + k_sharp_drop <= chain.balls) away = true;
    if (k != chain.balls) {
      stay = 0;
      continue;
    }
    ++correct;
    if (!statistics.first_correct) statistics.first_correct = i;
    if (stay++ == 0) ++statistics.stays;
    if (away) ++statistics.visits;
    away = false;
    statistics.longest_stay = std::max(statistics.longest_stay, stay);
  }
  statistics.correct_share =
      static_cast<double>(correct) / static_cast<double>(chain.iterations.size());
}

void count_proposals(const Chain& chain, Statistics& statistics) {
  double gained = 0;
  for (std::uint64_t i = 1; i < chain.iterations.size(); ++i) {
    const Iteration& before = chain.iterations[i - 1];
    const Iteration& now = chain.iterations[i];
    const auto kind = static_cast<std::size_t>(now.kind);
    ++statistics.proposed[kind];
    if (!now.accepted) continue;
    ++statistics.accepted[kind];
    if (now.kind != Kind::change_all || now.filled + k_sharp_drop > before.filled) continue;
    ++statistics.sharp_change_alls;
    if (now.log_p <= before.log_p) continue;
    statistics.change_all_effects.push_back(i);
    gained += now.log_p_offsets - before.log_p_offsets;
  }
  if (!statistics.change_all_effects.empty()) {
    statistics.effect_log_p_offsets =
        gained / static_cast<double>(statistics.change_all_effects.size());
  }
}

}  // namespace

Statistics statistics_of(const Chain& chain) {
  CHECK(!chain.iterations.empty());
  Statistics statistics;
  count_stays(chain, statistics);
  count_proposals(chain, statistics);
  for (const Iteration& iteration : chain.iterations)
    statistics.log_p_offsets += iteration.log_p_offsets;
  statistics.log_p_offsets /= static_cast<double>(chain.iterations.size()) * chain.vertices;
  return statistics;
}

}  // namespace sleight::thesis
