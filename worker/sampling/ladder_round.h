// Adapts parallel tempering, but only between rounds. The last round's rejection rates respace the
// ladder, and the barrier sets the number of levels. Acceptance rates set the proposal scales.
// Within a round, the kernel is fixed and leaves its distribution invariant. Thread safety: pure
// functions and values.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/ids.h"
#include "worker/sampling/round_statistics.h"
#include "worker/sampling/tuning.h"

namespace sleight::sampling {

struct LadderOptions {
  std::uint64_t seed = 0;
  base::ChainId chain;
  std::vector<double> first_ladder;  ///< Ascending, from 0 to 1.
  bool levels_chosen = true;         ///< By the barrier; otherwise as in first_ladder.
  std::uint32_t levels_max = 64;
  bool ladder_adapts = true;
  /// By kind of proposal: whether the kind has a tuned scale (target.h).
  std::vector<bool> has_scale;
  std::uint64_t round_scans = 64;  ///< First round's length. Each later round is twice as long.
  /// Number of annealing scans before the first round. Over these scans, a replica's inverse
  /// temperature rises in equal steps to its level's inverse temperature.
  std::uint64_t anneal_scans = 0;
  /// Whether the first replicas, except the hottest, start from searches. Requires anneal_scans =
  /// 0.
  bool starts_by_search = false;
};

/// Results of a round. The current round's results are partial.
struct RoundReport {
  std::uint64_t first_scan = 0;
  RoundStatistics statistics;
  std::uint64_t round_trips = 0;            ///< Round trips that ended in this round.
  std::uint64_t restarts = 0;               ///< Arrivals at the coolest level from the hottest.
  std::vector<KindCounts> counts;           ///< By level.
  std::vector<std::vector<double>> scales;  ///< Proposal scales by level, then by kind.

  const std::vector<double>& ladder() const { return statistics.ladder(); }
  /// Mean acceptance rate of swaps over all neighbouring pairs. REQUIRES: at least one scan.
  double mean_swap_acceptance() const;
  /// The first scan after the round.
  std::uint64_t end_scan() const { return first_scan + statistics.scans_wanted(); }
};

RoundReport first_round(const LadderOptions& options);

/// Returns the round after `last`, which is completed. The new round is twice as long.
RoundReport next_round(const LadderOptions& options, const RoundReport& last);

}  // namespace sleight::sampling
