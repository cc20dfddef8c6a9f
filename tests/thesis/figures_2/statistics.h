// Numbers that support the thesis's statements about its chains (section 2.4.3).
//
// A stay is a sequence of iterations in which all designated bins are filled. A visit consists of
// one or more stays, and ends when k has fallen by k_sharp_drop. If one ball leaves its bin and
// returns, this adds a stay but no visit.
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
  std::uint64_t longest_stay = 0;       ///< iterations
  double correct_share = 0;             ///< of all iterations
  std::uint64_t sharp_change_alls = 0;  ///< accepted change_alls that lowered k by k_sharp_drop
  std::vector<std::uint64_t> change_all_effects;  ///< iterations with the change-all effect
  double effect_log_p_offsets = 0;  ///< mean gain of log p of the offsets at these iterations
  double log_p_offsets = 0;         ///< mean per vertex, over all iterations
  std::array<std::uint64_t, worlds::spelling::k_kinds> proposed{};
  std::array<std::uint64_t, worlds::spelling::k_kinds> accepted{};
};

/// REQUIRES: at least the start.
Statistics statistics_of(const Chain& chain);

}  // namespace sleight::thesis
