#include "worker/sampling/ladder_round.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "worker/sampling/ladder.h"

namespace sleight::sampling {
namespace {

RoundReport begun(std::uint64_t first_scan, std::vector<double> ladder, std::uint64_t scans,
                  std::vector<std::vector<double>> scales) {
  const std::size_t levels = ladder.size();
  return {.first_scan = first_scan,
          .statistics = RoundStatistics(std::move(ladder), scans),
          .round_trips = 0,
          .restarts = 0,
          .counts = std::vector<KindCounts>(levels),
          .scales = std::move(scales)};
}

std::vector<double> next_ladder(const LadderOptions& options, const RoundReport& last) {
  const std::vector<double> rejections = last.statistics.rejections();
  auto levels = static_cast<std::uint32_t>(last.ladder().size());
  if (options.levels_chosen)
    levels = std::clamp(levels_for(cumulative_barrier(rejections).back()), k_levels_min,
                        options.levels_max);
  const bool moves = options.ladder_adapts || levels != last.ladder().size();
  return moves ? respaced(last.ladder(), rejections, levels) : last.ladder();
}

/// Tunes proposal scales at the old levels, then interpolates them at the new levels.
std::vector<std::vector<double>> next_scales(const LadderOptions& options, const RoundReport& last,
                                             const std::vector<double>& ladder) {
  std::vector<std::vector<double>> scales(ladder.size());
  if (std::ranges::find(options.has_scale, true) == options.has_scale.end()) return scales;
  std::vector<std::vector<double>> learnt;
  std::size_t kinds = 0;
  for (std::size_t level = 0; level < last.ladder().size(); ++level) {
    learnt.push_back(tuned(last.scales[level], last.counts[level], options.has_scale));
    kinds = std::max(kinds, learnt.back().size());
  }
  // The hottest level draws from the prior without proposals, so it copies its neighbour's scales.
  learnt.front() = learnt[1];
  for (std::size_t kind = 0; kind < kinds; ++kind) {
    std::vector<double> logs;
    for (const std::vector<double>& level : learnt)
      logs.push_back(kind < level.size() ? math::log(level[kind]) : 0);
    for (std::size_t level = 0; level < ladder.size(); ++level)
      scales[level].push_back(math::exp(interpolated(last.ladder(), logs, ladder[level])));
  }
  return scales;
}

}  // namespace

double RoundReport::mean_swap_acceptance() const {
  const std::vector<double> rejections = statistics.rejections();
  CHECK(!rejections.empty());
  return 1 - std::accumulate(rejections.begin(), rejections.end(), 0.0) /
                 static_cast<double>(rejections.size());
}

RoundReport first_round(const LadderOptions& options) {
  return begun(options.anneal_scans, options.first_ladder, options.round_scans,
               std::vector<std::vector<double>>(options.first_ladder.size()));
}

RoundReport next_round(const LadderOptions& options, const RoundReport& last) {
  std::vector<double> ladder = next_ladder(options, last);
  std::vector<std::vector<double>> scales = next_scales(options, last, ladder);
  return begun(last.end_scan(), std::move(ladder), 2 * last.statistics.scans_wanted(),
               std::move(scales));
}

}  // namespace sleight::sampling
