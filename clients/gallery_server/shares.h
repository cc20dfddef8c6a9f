// How large a share of a run's satisfied draws looks like a group's animations.
//
// Kept animations are distinct ones: how many of them a group has says nothing of how often the
// model has such animations. The draws do. A satisfied draw is put to the animation that was kept
// last of its (chain, lineage), at the draw or before it: what came after it and was not kept was
// like what is kept, or one too many of the lineage. Draws of lineages of which nothing is kept are
// counted apart.
//
// The error takes lineages as what is independent, as draws of one follow from one another: with
// n_l satisfied draws of lineage l, of which g_l are the group's, and p = sum g / sum n, it is
//     sqrt(L / (L - 1) * sum (g_l - p n_l)^2) / sum n
// (W. Cochran, "Sampling Techniques", 1977, section 6.4: ratio of clusters' sums).
//
// Thread safety: pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sleight::gallery {

/// A satisfied draw, or an animation that is kept of one.
struct LineageDraw {
  std::uint64_t chain = 0;
  std::int64_t lineage = 0;
  std::uint64_t draw = 0;
};

/// The draws of one lineage, by the animation they are put to.
struct LineageCounts {
  struct Count {
    std::size_t animation = 0;
    std::uint64_t draws = 0;
  };
  std::uint64_t draws = 0;  ///< all of them
  std::vector<Count> counts{};
};

/// Of lineages with something kept; in the order of (chain, lineage).
struct SatisfiedDraws {
  std::vector<LineageCounts> lineages{};
  std::uint64_t draws = 0;      ///< of these lineages
  std::uint64_t elsewhere = 0;  ///< satisfied draws of other lineages
};

/// REQUIRES: satisfied draws in any order; kept[i] is animation i.
SatisfiedDraws satisfied_draws(std::span<const LineageDraw> satisfied,
                               std::span<const LineageDraw> kept);

struct Share {
  double value = 0;
  double error = 0;  ///< NaN of fewer than two lineages
};

/// Shares of groups; group_of[i] is animation i's, or none: it is in no group. None of no draws.
std::vector<Share> shares_of(const SatisfiedDraws& draws,
                             std::span<const std::optional<std::size_t>> group_of,
                             std::size_t groups);

}  // namespace sleight::gallery
