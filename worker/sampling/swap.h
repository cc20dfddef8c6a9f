// Decides whether two neighbouring levels of a ladder swap.
//
//   1. After scan s, levels i and i+1 with i + s even are partners. (Deterministic even-odd swaps
//      carry states through the ladder like a conveyor.)
//   2. The log ratio is (beta' - beta) (l - l'). beta' is the cooler level's inverse temperature,
//      and l and l' are log p_c of the hotter and the cooler level's state.
//   3. Partners swap if log u < log ratio. u is uniform, and a function of (seed, chain, hotter
//      level, scan).
//
// A swap depends only on two densities and the swap's place, so plan and worker decide alike.
// swap_flow.h defines which replicas wait for each other.
// Thread safety: pure functions. swap.cpp contains only formulas, so a test program can link wrong
// formulas instead (tests/unit/worker/sampling/replaced_formulas.h).
#pragma once

#include <cstdint>
#include <optional>

#include "common/base/ids.h"
#include "common/math/elementary.h"

namespace sleight::sampling {

struct SwapPlace {
  std::uint64_t seed = 0;
  base::ChainId chain;
  std::uint32_t level = 0;  ///< The hotter level.
  std::uint64_t scan = 0;
};

/// Two neighbouring levels, and log p_c of their states.
struct SwapPair {
  double hotter = 0;  ///< Inverse temperature; likewise `cooler`.
  double cooler = 1;
  double log_constraint_hotter = 0;
  double log_constraint_cooler = 0;
};

/// Returns the level that swaps with `level` after a scan. An end level may have no partner.
std::optional<std::uint32_t> even_odd_partner(std::uint32_t level, std::uint64_t scan,
                                              std::uint32_t levels);

/// Returns log of p_hotter(x') p_cooler(x) / (p_hotter(x) p_cooler(x')) for states x and x'.
double log_swap_ratio(const SwapPair& pair);

/// Returns u, the uniform number that decides the swap.
double swap_number(const SwapPlace& place);

/// Returns true with probability min(1, ratio).
inline bool swaps(const SwapPlace& place, const SwapPair& pair) {
  return math::log(swap_number(place)) < log_swap_ratio(pair);
}

}  // namespace sleight::sampling
