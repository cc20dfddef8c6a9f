// Units of work: what a sampling method requests and a worker returns.
//
// A unit consists of consecutive scans of one replica of one chain. Each scan has its own inverse
// temperature. A replica's first scan draws its start from the prior. Every scan at inverse
// temperature 0 is a prior draw too. Each such draw from the prior begins a lineage. A unit's
// result is a pure function of (request, unit, state before), so it can be computed anywhere, or
// again after a crash, with the same bits. A unit's size may depend on measured cost. No stored
// result depends on the size (docs/DETERMINISM).
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/ids.h"
#include "common/plan/failure.h"

namespace sleight::plan {

/// The logical address of a chain's state, ordered by chain, then replica.
struct ReplicaKey {
  base::ChainId chain;
  base::ReplicaId replica;
  friend auto operator<=>(const ReplicaKey&, const ReplicaKey&) = default;
};

/// A search's starts are numbered over k_search_lanes lanes: start n is scan n / k_search_lanes of
/// lane n % k_search_lanes. To workers and stores, lanes are chains with one replica, numbered from
/// k_first_lane on. No start of a search depends on an earlier state. Prior lanes make the prior
/// draws that are stored beside a run's samples. Island lanes make free islands, if a run requests
/// only the odds.
inline constexpr std::uint32_t k_first_lane = 65536;
inline constexpr std::uint32_t k_search_lanes = 64;
inline constexpr std::uint32_t k_first_prior_lane = k_first_lane + k_search_lanes;
inline constexpr std::uint32_t k_prior_lanes = 64;
inline constexpr std::uint32_t k_first_island_lane = k_first_prior_lane + k_prior_lanes;
/// The number of islands in progress at a time is always smaller than this.
inline constexpr std::uint32_t k_island_lanes = 1024;

inline bool is_search_lane(base::ChainId chain) {
  return chain.value >= k_first_lane && chain.value < k_first_prior_lane;
}
inline bool is_prior_lane(base::ChainId chain) {
  return chain.value >= k_first_prior_lane && chain.value < k_first_prior_lane + k_prior_lanes;
}

inline bool is_island_lane(base::ChainId chain) {
  return chain.value >= k_first_island_lane && chain.value < k_first_island_lane + k_island_lanes;
}

/// REQUIRES: a search lane.
inline std::uint64_t start_number(base::ChainId lane, std::uint64_t scan) {
  return scan * k_search_lanes + (lane.value - k_first_lane);
}

/// REQUIRES: a prior lane.
inline std::uint64_t prior_draw_number(base::ChainId lane, std::uint64_t scan) {
  return scan * k_prior_lanes + (lane.value - k_first_prior_lane);
}

/// REQUIRES: an island lane.
inline std::uint64_t island_number(base::ChainId lane, std::uint64_t scan) {
  return scan * k_island_lanes + (lane.value - k_first_island_lane);
}

/// Returns the island's lane, and the island's scan in this lane.
inline std::pair<base::ChainId, std::uint64_t> place_of_island(std::uint64_t number) {
  const auto lane = static_cast<std::uint32_t>(number % k_island_lanes);
  return {base::ChainId{k_first_island_lane + lane}, number / k_island_lanes};
}

/// Every chain has fewer replicas than this. So different arguments of lineage_from() give
/// different results.
inline constexpr std::uint64_t k_replicas_end = 4096;

/// The lineage that begins with the prior draw of `replica` at `scan`. Each prior draw of a chain
/// has its own lineage. The start of replica 0 has lineage 0.
inline std::uint64_t lineage_from(base::ReplicaId replica, std::uint64_t scan) {
  return scan * k_replicas_end + replica.value;
}

inline std::uint64_t scan_of_lineage(std::uint64_t lineage) {
  return lineage / k_replicas_end;
}

struct Unit {
  ReplicaKey replica;
  std::uint64_t seed = 0;  ///< Seed of the run, which addresses all random numbers of the unit.
  base::ScanIndex first_scan;
  std::uint32_t scans = 0;    ///< At least 1.
  bool starts = false;        ///< The unit has the replica's first scan.
  std::uint64_t lineage = 0;  ///< Lineage of the state before the unit.
  /// For each scan, beta of p_w p_c^beta, in [0, 1]. If there is only one value, it applies to all
  /// scans.
  std::vector<double> inverse_temperatures{1};
  /// Factors by which proposal scales are multiplied, by kind of proposal. Empty: all 1.
  std::vector<double> proposal_scales{};
  /// Each scan ends with a tempered transition at these inverse temperatures. They descend, and all
  /// are below the scan's own. Empty: no transition.
  std::vector<double> excursion{};

  /// Returns whether each scan is a start of a search. A start has no previous state. Implies
  /// `starts`.
  bool searches() const { return is_search_lane(replica.chain); }
  /// Returns whether each scan is a draw from the prior. Implies `starts`.
  bool draws_prior() const { return is_prior_lane(replica.chain); }
  /// Returns whether each scan is a free island. Implies `starts`.
  bool makes_islands() const { return is_island_lane(replica.chain); }
  double inverse_temperature(std::uint32_t nth) const {
    return inverse_temperatures.size() == 1 ? inverse_temperatures.front()
                                            : inverse_temperatures[nth];
  }
  friend bool operator==(const Unit&, const Unit&) = default;
};

/// One scan's result.
struct ScanRecord {
  double log_prior = 0;       ///< log p_w of the state after the scan, normalised.
  double log_constraint = 0;  ///< log p_c of its outcome, at inverse temperature 1; may be -inf.
  bool satisfied = false;
  std::uint64_t lineage = 0;       ///< Prior draw of this chain from which the state descends.
  double inverse_temperature = 1;  ///< At which the scan was sampled.
  std::vector<std::uint32_t> proposed{};  ///< Proposals made in this scan, by kind.
  std::vector<std::uint32_t> accepted{};  ///< Accepted proposals, by kind.
  std::vector<double> outcome{};          ///< The world's outcome scalars, in its layout's order.
  FailureCounts failures{};               ///< Failures of this scan's simulations.
  /// Number of simulations that could not begin, because bodies overlap at the start: p_c = 0.
  std::uint64_t overlapping_starts = 0;
  /// Estimates by islands (island_estimate.h), or values by which a burn-in is judged
  /// (burn_in_judge.h).
  std::vector<double> method_values{};
  /// The state after the scan. Present if the scan is archived (every `thin`-th) or the state
  /// satisfies the constraint; otherwise empty.
  base::Bytes state{};
  friend bool operator==(const ScanRecord&, const ScanRecord&) = default;
};

struct FailedSimulation {
  base::ScanIndex scan;
  SimulationFailure failure;
  friend bool operator==(const FailedSimulation&, const FailedSimulation&) = default;
};

/// Maximum number of failed simulations that a unit returns. Counts include all of them.
inline constexpr std::size_t k_failed_told_max = 10;

struct UnitResult {
  Unit unit;
  std::vector<ScanRecord> scans;           ///< unit.scans of them.
  std::vector<FailedSimulation> failed{};  ///< The first k_failed_told_max, in order; never stored.
  base::Bytes state_after;                 ///< Where the replica's next unit begins.
  double cost_s = 0;                       ///< Measured time, for sizing units; never stored.
  std::uint64_t simulations = 0;           ///< Number of simulations, for display; never stored.
};

/// Statistics of a worker's sample cache.
struct CacheUse {
  std::uint64_t hits = 0;    ///< States that were held when a unit began with them.
  std::uint64_t misses = 0;  ///< States that weren't held, and were simulated again or requested.
  std::uint64_t evictions = 0;
  std::uint64_t bytes = 0;
  std::uint64_t bytes_max = 0;
  friend bool operator==(const CacheUse&, const CacheUse&) = default;
};

/// Computes units. Thread-safe: run may be called from several threads at once.
class UnitWorker {
 public:
  virtual ~UnitWorker() = default;
  /// REQUIRES: `state` is the replica's state before unit.first_scan. For the first scan, `state`
  /// is the result of Plan::start_state().
  virtual UnitResult run(const Unit& unit, base::BytesView state) const = 0;
  /// Runs the unit from the sample that this worker holds for it. Returns nothing if the worker
  /// holds none.
  virtual std::optional<UnitResult> run_from_held(const Unit&) const { return std::nullopt; }
  /// Returns whether the worker holds the sample for the unit now. REQUIRES: !unit.starts.
  virtual bool holds(const Unit&) const { return false; }
  virtual CacheUse cache_use() const { return {}; }
};

}  // namespace sleight::plan
