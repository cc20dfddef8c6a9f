// Adapts proposal scales to acceptance rates. Each level has one scale for each kind of proposal.
//
// Between rounds, a kind's scale is multiplied by exp(gain (acceptance - target)). The change is
// bounded per round and in total. Kinds with few proposals stay unchanged. Scales are constant
// within a round, so each scan leaves its distribution invariant. Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sleight::sampling {

/// Target acceptance rate. The optimum is 0.44 in one dimension and 0.234 in many dimensions.
/// Source: Roberts and Rosenthal 2001.
inline constexpr double k_acceptance_target = 0.3;
/// Kinds with fewer proposals in a round are not tuned.
inline constexpr std::uint64_t k_proposals_min = 50;
inline constexpr double k_scale_min = 1e-3;
inline constexpr double k_scale_max = 1e3;

/// One level's proposals in a round, by kind.
struct KindCounts {
  std::vector<std::uint64_t> proposed;
  std::vector<std::uint64_t> accepted;
  void add(std::span<const std::uint32_t> proposed_now,
           std::span<const std::uint32_t> accepted_now);
};

/// Returns the tuned scales of the kinds in `has_scale`. Empty `scales` count as 1.
std::vector<double> tuned(std::span<const double> scales, const KindCounts& counts,
                          const std::vector<bool>& has_scale);

}  // namespace sleight::sampling
