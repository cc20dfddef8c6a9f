// Proposals that learn: how large those of each kind are at each temperature, set between rounds
// from how many were accepted.
//
// A kind's size is multiplied by exp(gain (acceptance - target)), bounded per round and in all; a
// kind that was hardly proposed is left as it is. Within a round sizes are constant, so each scan
// keeps its distribution.
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sleight::sampling {

/// Between the best for one dimension, 0.44, and for many, 0.234 (Roberts and Rosenthal 2001).
inline constexpr double k_acceptance_target = 0.3;
/// Fewer proposals of a kind in a round say nothing.
inline constexpr std::uint64_t k_proposals_min = 50;
inline constexpr double k_scale_min = 1e-3;
inline constexpr double k_scale_max = 1e3;

/// Proposals of a level in a round, by kind.
struct KindCounts {
  std::vector<std::uint64_t> proposed;
  std::vector<std::uint64_t> accepted;
  void add(std::span<const std::uint32_t> proposed_now,
           std::span<const std::uint32_t> accepted_now);
};

/// The sizes that follow; empty ones count as 1. `has_scale`: by kind; others stay as they are, as
/// do those beyond its end.
std::vector<double> tuned(std::span<const double> scales, const KindCounts& counts,
                          const std::vector<bool>& has_scale);

}  // namespace sleight::sampling
