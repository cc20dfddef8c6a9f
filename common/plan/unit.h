// Units of work: what a sampling method asks for and what a worker gives back.
//
// A unit is one replica of one chain over consecutive scans, each at its own inverse temperature. A
// replica's first scan draws its start from the prior, and so does every scan at inverse
// temperature 0: there a new lineage begins. A unit's result is a pure function of (request, unit,
// state before), so it may be computed anywhere, twice, or again after a crash, always to the same
// bits. How many scans a unit has may follow measured cost; no stored result depends on it (docs/
// DETERMINISM).
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

/// The logical address of a chain's state: ordered by chain, then replica.
struct ReplicaKey {
  base::ChainId chain;
  base::ReplicaId replica;
  friend auto operator<=>(const ReplicaKey&, const ReplicaKey&) = default;
};

/// The starts of a search are numbered over so many lanes, which to workers and stores are chains
/// with one replica, numbered from k_first_lane on: start n is scan n / k_search_lanes of lane n %
/// k_search_lanes. No start knows a state before it. Draws from the prior that stand beside a run's
/// samples have lanes of their own, and so have islands where nothing but the odds is asked for.
inline constexpr std::uint32_t k_first_lane = 65536;
inline constexpr std::uint32_t k_search_lanes = 64;
inline constexpr std::uint32_t k_first_prior_lane = k_first_lane + k_search_lanes;
inline constexpr std::uint32_t k_prior_lanes = 64;
inline constexpr std::uint32_t k_first_island_lane = k_first_prior_lane + k_prior_lanes;
/// More than there are islands at work at once.
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

/// REQUIRES: a search's lane.
inline std::uint64_t start_number(base::ChainId lane, std::uint64_t scan) {
  return scan * k_search_lanes + (lane.value - k_first_lane);
}

/// REQUIRES: a lane of the prior.
inline std::uint64_t prior_draw_number(base::ChainId lane, std::uint64_t scan) {
  return scan * k_prior_lanes + (lane.value - k_first_prior_lane);
}

/// REQUIRES: a lane of islands.
inline std::uint64_t island_number(base::ChainId lane, std::uint64_t scan) {
  return scan * k_island_lanes + (lane.value - k_first_island_lane);
}

/// The island's lane, and its scan there.
inline std::pair<base::ChainId, std::uint64_t> place_of_island(std::uint64_t number) {
  const auto lane = static_cast<std::uint32_t>(number % k_island_lanes);
  return {base::ChainId{k_first_island_lane + lane}, number / k_island_lanes};
}

/// More replicas than a chain can have: lineages are numbered by it.
inline constexpr std::uint64_t k_replicas_end = 4096;

/// The lineage that begins with a replica's draw from the prior at a scan: each such draw of a
/// chain has its own; replica 0's start has 0.
inline std::uint64_t lineage_from(base::ReplicaId replica, std::uint64_t scan) {
  return scan * k_replicas_end + replica.value;
}

/// The scan at which a lineage began.
inline std::uint64_t scan_of_lineage(std::uint64_t lineage) {
  return lineage / k_replicas_end;
}

struct Unit {
  ReplicaKey replica;
  std::uint64_t seed = 0;  ///< of the run: all random numbers of the unit are addressed from here
  base::ScanIndex first_scan;
  std::uint32_t scans = 0;    ///< at least 1
  bool starts = false;        ///< with the replica's first scan: there is no state before
  std::uint64_t lineage = 0;  ///< of the state before
  /// beta of p_w p_c^beta, in [0, 1], of each scan; a single one holds for all.
  std::vector<double> inverse_temperatures{1};
  /// By which the sizes of proposals are multiplied, by kind; empty: by 1.
  std::vector<double> proposal_scales{};
  /// Of the tempered transition that ends each scan: the inverse temperatures that it goes down
  /// through, below the scan's own; empty: none.
  std::vector<double> excursion{};

  /// Each scan is then a start of a search, with no state before it; `starts` holds.
  bool searches() const { return is_search_lane(replica.chain); }
  /// Each scan is a draw from the prior, with no state before it or after; `starts` holds.
  bool draws_prior() const { return is_prior_lane(replica.chain); }
  /// Each scan is a free island, likewise.
  bool makes_islands() const { return is_island_lane(replica.chain); }
  double inverse_temperature(std::uint32_t nth) const {
    return inverse_temperatures.size() == 1 ? inverse_temperatures.front()
                                            : inverse_temperatures[nth];
  }
  friend bool operator==(const Unit&, const Unit&) = default;
};

/// One scan's result. The state before it is not part of it.
struct ScanRecord {
  double log_prior = 0;       ///< log p_w of the state after the scan, normalised
  double log_constraint = 0;  ///< log p_c of its outcome, at inverse temperature 1; may be -inf
  bool satisfied = false;
  std::uint64_t lineage = 0;  ///< which visit of this chain to the prior the state descends from
  double inverse_temperature = 1;         ///< at which it was sampled
  std::vector<std::uint32_t> proposed{};  ///< proposals made in this scan, by kind
  std::vector<std::uint32_t> accepted{};  ///< of these, accepted
  std::vector<double> outcome{};          ///< the world's outcome scalars, in its layout's order
  FailureCounts failures{};               ///< of simulations that this scan made
  /// Simulations of this scan that could not begin, since bodies overlap at the start: p_c = 0.
  std::uint64_t overlapping_starts = 0;
  /// What the method asks of a scan besides: what an island estimates (worker/sampling/island.h),
  /// or what a burn-in is judged by (burn_in_judge.h).
  std::vector<double> method_values{};
  /// The state, at scans that are archived (every `thin`-th) or satisfied; empty at others.
  base::Bytes state{};
  friend bool operator==(const ScanRecord&, const ScanRecord&) = default;
};

/// A simulation that failed in a scan.
struct FailedSimulation {
  base::ScanIndex scan;
  SimulationFailure failure;
  friend bool operator==(const FailedSimulation&, const FailedSimulation&) = default;
};

/// Of a unit's failed simulations so many come back whole; all are counted.
inline constexpr std::size_t k_failed_told_max = 10;

struct UnitResult {
  Unit unit;
  std::vector<ScanRecord> scans;           ///< unit.scans of them
  std::vector<FailedSimulation> failed{};  ///< the first k_failed_told_max, in order; never stored
  base::Bytes state_after;                 ///< where the replica's next unit begins
  double cost_s = 0;                       ///< measured time: for cutting units, never stored
  std::uint64_t simulations = 0;           ///< that it took: for people, never stored
};

/// What a worker's memory of samples has done so far.
struct CacheUse {
  std::uint64_t hits = 0;    ///< states that were held when a unit began with them
  std::uint64_t misses = 0;  ///< that weren't, and were simulated again or asked for
  std::uint64_t evictions = 0;
  std::uint64_t bytes = 0;
  std::uint64_t bytes_max = 0;
  friend bool operator==(const CacheUse&, const CacheUse&) = default;
};

/// What computes units. Thread-safe: run may be called from several threads at once.
class UnitWorker {
 public:
  virtual ~UnitWorker() = default;
  /// REQUIRES: `state` is the replica's state before unit.first_scan; for its first scan the one
  /// that it starts with (Plan::start_state), or empty.
  virtual UnitResult run(const Unit& unit, base::BytesView state) const = 0;
  /// The same from the sample that this worker holds since it ran the unit before, if it does.
  virtual std::optional<UnitResult> run_from_held(const Unit&) const { return std::nullopt; }
  /// Whether it has that sample now. REQUIRES: !unit.starts.
  virtual bool holds(const Unit&) const { return false; }
  virtual CacheUse cache_use() const { return {}; }
};

}  // namespace sleight::plan
