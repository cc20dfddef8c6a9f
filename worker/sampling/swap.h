// The swap of two neighbouring levels of a ladder: who swaps with whom, with which ratio, by which
// random number.
//
//   partners    after scan s the levels i and i+1 with i + s even (deterministic even-odd swaps,
//               which carry states through the ladder like a conveyor)
//   log ratio   (beta' - beta) (l - l'): beta' is the cooler level's inverse temperature, l and l'
//               are log p_c of the hotter and the cooler level's state
//   swapped     if log u < log ratio, u uniform from (seed, chain, the hotter level, scan)
//
// A swap needs two densities and its place, nothing else: whoever decides it decides the same. Who
// waits for whom is in swap_flow.h.
//
// Thread safety: pure functions. The formulas are in swap.cpp and nothing else is, so that a test
// program can link wrong ones in their place (tests/unit/worker/sampling/replaced_formulas.h).
#pragma once

#include <cstdint>
#include <optional>

#include "common/base/ids.h"
#include "common/math/elementary.h"

namespace sleight::sampling {

/// Where a swap is.
struct SwapPlace {
  std::uint64_t seed = 0;
  base::ChainId chain;
  std::uint32_t level = 0;  ///< the hotter one's
  std::uint64_t scan = 0;
};

/// Two neighbouring levels, and log p_c of the states at them.
struct SwapPair {
  double hotter = 0;  ///< inverse temperatures
  double cooler = 1;
  double log_constraint_hotter = 0;
  double log_constraint_cooler = 0;
};

/// The level that swaps with this one after a scan; none for an end that has no neighbour then.
std::optional<std::uint32_t> even_odd_partner(std::uint32_t level, std::uint64_t scan,
                                              std::uint32_t levels);

/// log of p_hotter(x') p_cooler(x) / (p_hotter(x) p_cooler(x')), x and x' being the two states.
double log_swap_ratio(const SwapPair& pair);

/// The number that decides: u.
double swap_number(const SwapPlace& place);

/// With probability min(1, ratio).
inline bool swaps(const SwapPlace& place, const SwapPair& pair) {
  return math::log(swap_number(place)) < log_swap_ratio(pair);
}

}  // namespace sleight::sampling
