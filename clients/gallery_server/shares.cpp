#include "clients/gallery_server/shares.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace sleight::gallery {
namespace {

/// The draws of a lineage's kept animations, and the indices of these animations.
using Kept = std::vector<std::pair<std::uint64_t, std::size_t>>;

}  // namespace

SatisfiedDraws satisfied_draws(std::span<const LineageDraw> satisfied,
                               std::span<const LineageDraw> kept) {
  std::map<std::pair<std::uint64_t, std::int64_t>, Kept> kept_of;
  for (std::size_t i = 0; i < kept.size(); ++i)
    kept_of[{kept[i].chain, kept[i].lineage}].emplace_back(kept[i].draw, i);
  std::map<std::pair<std::uint64_t, std::int64_t>, std::map<std::size_t, std::uint64_t>> counts;
  for (auto& [lineage, animations] : kept_of)
    std::ranges::sort(animations);

  SatisfiedDraws draws;
  for (const LineageDraw& one : satisfied) {
    const auto found = kept_of.find({one.chain, one.lineage});
    if (found == kept_of.end()) {
      ++draws.elsewhere;
      continue;
    }
    // Assign the draw to the last animation kept at this draw or before. If a failed simulation
    // lost earlier animations, the draw goes to the first kept animation.
    const Kept& animations = found->second;
    auto after = std::ranges::upper_bound(animations, one.draw, {},
                                          [](const auto& animation) { return animation.first; });
    if (after != animations.begin()) --after;
    ++counts[found->first][after->second];
    ++draws.draws;
  }
  for (const auto& [lineage, of_animations] : counts) {
    LineageCounts line;
    for (const auto& [animation, count] : of_animations) {
      line.counts.push_back({.animation = animation, .draws = count});
      line.draws += count;
    }
    draws.lineages.push_back(std::move(line));
  }
  return draws;
}

std::vector<Share> shares_of(const SatisfiedDraws& draws,
                             std::span<const std::optional<std::size_t>> group_of,
                             std::size_t groups) {
  if (draws.draws == 0) return {};
  const auto all = static_cast<double>(draws.draws);
  const auto lineages = static_cast<double>(draws.lineages.size());
  std::vector<std::vector<double>> of_lineage(groups);  // by group; lineages with its draws
  std::vector<double> sum(groups, 0.0);
  std::vector<std::vector<double>> size(groups);
  std::vector<double> squares_of_sizes(groups, 0.0);
  double squares = 0;
  for (const LineageCounts& line : draws.lineages) {
    const auto drawn = static_cast<double>(line.draws);
    squares += drawn * drawn;
    std::map<std::size_t, double> here;
    for (const LineageCounts::Count& count : line.counts) {
      if (const auto group = group_of[count.animation])
        here[*group] += static_cast<double>(count.draws);
    }
    for (const auto& [group, count] : here) {
      of_lineage[group].push_back(count);
      size[group].push_back(drawn);
      sum[group] += count;
      squares_of_sizes[group] += drawn * drawn;
    }
  }
  std::vector<Share> shares(groups);
  for (std::size_t group = 0; group < groups; ++group) {
    const double share = sum[group] / all;
    // In lineages without draws of the group, the deviation is `share * n`.
    double deviations = share * share * (squares - squares_of_sizes[group]);
    for (std::size_t i = 0; i < of_lineage[group].size(); ++i)
      deviations += std::pow(of_lineage[group][i] - share * size[group][i], 2);
    shares[group] = {.value = share,
                     .error = lineages < 2
                                  ? std::numeric_limits<double>::quiet_NaN()
                                  : std::sqrt(lineages / (lineages - 1) * deviations) / all};
  }
  return shares;
}

}  // namespace sleight::gallery
