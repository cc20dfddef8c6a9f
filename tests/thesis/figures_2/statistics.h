// What section 2.4.3 says of its chains, as numbers.
//
// A stay is a run of iterations with all designated bins filled. A visit has one or more stays, and
// ends when k has fallen k_sharp_drop below that: changing one ball and changing it back is a stay
// more and no visit.
//
// The change-all effect (figure 2.9): a change_all is accepted, k falls by k_sharp_drop or more,
// and log p(A) rises.
//
// Thread safety: pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "tests/thesis/figures_2/chain.h"
#include "worker/worlds/spelling/proposals.h"

namespace sleight::thesis {

inline constexpr std::uint32_t k_sharp_drop = 3;

struct Statistics {
  std::optional<std::uint64_t> first_correct;  ///< iteration; the start is 0
  std::uint64_t visits = 0;
  std::uint64_t stays = 0;
  std::uint64_t longest_stay = 0;                 ///< iterations
  double correct_share = 0;                       ///< of all iterations
  std::uint64_t sharp_change_alls = 0;            ///< accepted ones that lowered k by k_sharp_drop
  std::vector<std::uint64_t> change_all_effects;  ///< at which iterations
  double effect_log_p_offsets = 0;  ///< what these gained in log p of the offsets, mean
  double log_p_offsets = 0;         ///< mean for each vertex, over all iterations
  std::array<std::uint64_t, worlds::spelling::k_kinds> proposed{};
  std::array<std::uint64_t, worlds::spelling::k_kinds> accepted{};
};

/// REQUIRES: the start at least.
Statistics statistics_of(const Chain& chain);

}  // namespace sleight::thesis
