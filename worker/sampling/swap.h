// Whether two neighbouring levels of a ladder swap after a scan: a pure function of the two
// states' densities and of where the swap is, so whoever decides it decides the same.
#pragma once

#include <cstdint>

#include "common/base/ids.h"
#include "common/math/elementary.h"
#include "common/random/stream.h"
#include "worker/sampling/rules.h"

namespace sleight::sampling {

/// Two levels that are partners after a scan. The random number is drawn from (seed, chain, level,
/// scan).
struct SwapPair {
  std::uint64_t seed = 1;
  base::ChainId chain;
  std::uint64_t scan = 0;
  std::uint32_t level = 0;  ///< the hotter one's
  double hotter = 0;        ///< inverse temperatures
  double cooler = 1;
  double log_constraint_hotter = 0;  ///< log p_c of the states
  double log_constraint_cooler = 0;
};

inline bool swaps(const Rules& rules, const SwapPair& pair) {
  const double log_ratio = rules.log_swap_ratio(
      pair.hotter, pair.cooler, pair.log_constraint_hotter, pair.log_constraint_cooler);
  const random::StreamKey key{.seed = pair.seed,
                              .chain = pair.chain,
                              .replica = base::ReplicaId{pair.level},
                              .purpose = random::Purpose::swap};
  return math::log(rules.swap_number(key, pair.scan)) < log_ratio;
}

}  // namespace sleight::sampling
