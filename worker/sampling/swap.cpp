#include "worker/sampling/swap.h"

#include "common/random/stream.h"

namespace sleight::sampling {

std::optional<std::uint32_t> even_odd_partner(std::uint32_t level, std::uint64_t scan,
                                              std::uint32_t levels) {
  const bool is_hotter = (level + scan) % 2 == 0;
  if (is_hotter) return level + 1 < levels ? std::optional(level + 1) : std::nullopt;
  return level > 0 ? std::optional(level - 1) : std::nullopt;
}

double log_swap_ratio(const SwapPair& pair) {
  // Two states of zero density always swap, because -inf - -inf is NaN.
  if (pair.log_constraint_hotter == pair.log_constraint_cooler) return 0;
  return (pair.cooler - pair.hotter) * (pair.log_constraint_hotter - pair.log_constraint_cooler);
}

double swap_number(const SwapPlace& place) {
  const random::StreamKey key{.seed = place.seed,
                              .chain = place.chain,
                              .replica = base::ReplicaId{place.level},
                              .purpose = random::Purpose::swap};
  return random::Stream(key, place.scan).uniform();
}

}  // namespace sleight::sampling
