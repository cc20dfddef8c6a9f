// What a ladder of parallel tempering begins with, what one round of it came to, and what the next
// one takes from that: the learning, all of which happens between rounds.
//
// A round's ladder is spaced anew from the last round's rejection rates, with as many levels as the
// barrier asks for, and the sizes of proposals are set from their acceptance. Within a round
// nothing is learnt, so there the chain keeps its distribution.
//
// Thread safety: pure functions and values.
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
  std::vector<double> first_ladder;  ///< ascending, 0 first, 1 last
  bool levels_chosen = true;         ///< from the barrier; else as many as at first
  std::uint32_t levels_max = 64;
  bool ladder_adapts = true;
  /// By kind of proposal: whether it has a size that is tuned (target.h).
  std::vector<bool> has_scale;
  std::uint64_t round_scans = 64;  ///< of the first round; each later one is twice as long
  /// Simulated annealing first: so many scans in which each replica goes from the prior to its own
  /// temperature in equal steps. They belong to no round.
  std::uint64_t anneal_scans = 0;
  /// The first replicas start from searches, all but the hottest; then nothing is annealed.
  bool starts_by_search = false;
};

/// What one round came to; of the present one, so far.
struct RoundReport {
  std::uint64_t first_scan = 0;
  RoundStatistics statistics;
  std::uint64_t round_trips = 0;            ///< hottest to coolest and back, ended in this round
  std::uint64_t restarts = 0;               ///< arrivals at the coolest level from the hottest
  std::vector<KindCounts> counts;           ///< by level
  std::vector<std::vector<double>> scales;  ///< by level, by kind

  const std::vector<double>& ladder() const { return statistics.ladder(); }
  /// Over all pairs of neighbours, what share of swaps is accepted. REQUIRES: a scan.
  double mean_swap_acceptance() const;
  /// The first scan that isn't of the round.
  std::uint64_t end_scan() const { return first_scan + statistics.scans_wanted(); }
};

RoundReport first_round(const LadderOptions& options);

/// The round after one that is over: twice as long.
RoundReport next_round(const LadderOptions& options, const RoundReport& last);

}  // namespace sleight::sampling
