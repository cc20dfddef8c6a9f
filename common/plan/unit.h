// Units of work: what a sampling method asks for and what a worker gives back.
//
// A unit is one replica of one chain over consecutive scans. Its result is a pure function of
// (request, unit, state before), so it may be computed anywhere, twice, or again after a crash,
// always to the same bits. How many scans a unit has may follow measured cost; no stored result
// depends on it (DESIGN C1).
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/ids.h"

namespace sleight::plan {

/// The logical address of a chain's state: ordered by chain, then replica.
struct ReplicaKey {
  base::ChainId chain;
  base::ReplicaId replica;
  friend auto operator<=>(const ReplicaKey&, const ReplicaKey&) = default;
};

struct Unit {
  ReplicaKey replica;
  base::ScanIndex first_scan;      ///< scan 0 draws the start from the prior
  std::uint32_t scans = 0;         ///< at least 1
  double inverse_temperature = 1;  ///< beta of p_w p_c^beta, in [0, 1]
  friend bool operator==(const Unit&, const Unit&) = default;
};

/// One scan's result. The state before it is not part of it.
struct ScanRecord {
  double log_prior = 0;       ///< log p_w of the state after the scan, normalised
  double log_constraint = 0;  ///< log p_c of its outcome, at inverse temperature 1; may be -inf
  bool satisfied = false;
  std::uint64_t lineage = 0;  ///< which visit of this chain to the prior the state descends from
  std::vector<std::uint32_t> proposed;  ///< proposals made in this scan, by kind
  std::vector<std::uint32_t> accepted;  ///< of these, accepted
  std::vector<double> outcome;          ///< the world's outcome scalars, in its layout's order
  /// The state, at scans that are archived (every `thin`-th) or satisfied; empty at others.
  base::Bytes state;
  friend bool operator==(const ScanRecord&, const ScanRecord&) = default;
};

struct UnitResult {
  Unit unit;
  std::vector<ScanRecord> scans;  ///< unit.scans of them
  base::Bytes state_after;        ///< where the replica's next unit begins
  double cost_s = 0;              ///< measured time: for cutting units, never stored
};

/// What computes units. Thread-safe: run may be called from several threads at once.
class UnitWorker {
 public:
  virtual ~UnitWorker() = default;
  /// REQUIRES: `state` is the replica's state before unit.first_scan; empty for scan 0.
  virtual UnitResult run(const Unit& unit, base::BytesView state) const = 0;
};

}  // namespace sleight::plan
