// Estimates which share of a run's satisfied draws looks like a group's animations.
//
// Only distinct animations are kept, so a group's number of animations doesn't show how probable
// such animations are. The draws do. A satisfied draw is assigned to an animation of its (chain,
// lineage): the last one kept up to and including that draw. A draw whose animation wasn't kept
// resembled a kept animation, or exceeded the limit per lineage. Draws of lineages without kept
// animations are counted separately.
//
// Draws within a lineage are dependent, so the error treats only lineages as independent. Let n_l
// be the number of satisfied draws of lineage l, g_l the group's part, and p = sum g / sum n. The
// error is
//
//     sqrt(L / (L - 1) * sum (g_l - p n_l)^2) / sum n
//
// (Cochran, "Sampling Techniques", 1977, section 6.4, ratio of clusters' sums).
//
// Thread safety: pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sleight::gallery {

/// A satisfied draw, or the draw of a kept animation.
struct LineageDraw {
  std::uint64_t chain = 0;
  std::int64_t lineage = 0;
  std::uint64_t draw = 0;
};

/// The draws of one lineage, by the animation that they are assigned to.
struct LineageCounts {
  struct Count {
    std::size_t animation = 0;
    std::uint64_t draws = 0;
  };
  std::uint64_t draws = 0;  ///< sum of `counts`
  std::vector<Count> counts{};
};

/// Lineages with kept animations, in the order of (chain, lineage).
struct SatisfiedDraws {
  std::vector<LineageCounts> lineages{};
  std::uint64_t draws = 0;      ///< satisfied draws of these lineages
  std::uint64_t elsewhere = 0;  ///< satisfied draws of other lineages
};

/// `satisfied` may have any order; kept[i] is the draw of animation i.
SatisfiedDraws satisfied_draws(std::span<const LineageDraw> satisfied,
                               std::span<const LineageDraw> kept);

struct Share {
  double value = 0;
  double error = 0;  ///< NaN for fewer than two lineages
};

/// Shares of groups; empty if there are no draws. group_of[i] is the group of animation i, or none.
std::vector<Share> shares_of(const SatisfiedDraws& draws,
                             std::span<const std::optional<std::size_t>> group_of,
                             std::size_t groups);

}  // namespace sleight::gallery
