// A ChainPart continues one chain after the chain's burn-in. The burn-in is parallel tempering
// (ladder_run.h).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/plan/unit.h"
#include "worker/sampling/solutions.h"

namespace sleight::sampling {

/// Results of a burn-in.
struct BurnIn {
  std::uint64_t seed = 0;
  base::ChainId chain;
  std::uint64_t scans = 0;     ///< Scans of the burn-in. The part's first scan has this number.
  base::ReplicaId coolest;     ///< The replica at inverse temperature 1.
  base::ReplicaId first_free;  ///< The smallest unused replica id; all greater ids are unused too.
  std::uint64_t lineage = 0;   ///< The lineage of the coolest replica's state.
  /// From the last round: ascending levels, proposal scales, and log Z_{i+1} - log Z_i.
  std::vector<double> ladder;
  std::vector<std::vector<double>> scales;
  std::vector<double> log_z_steps;
  /// Improved values that the last round suggests. Only methods that need no log Z can use them.
  std::vector<double> next_ladder;
  std::vector<std::vector<double>> next_scales;
};

class ChainPart {
 public:
  virtual ~ChainPart() = default;
  /// Like Plan::next_unit, but only for scans below the horizon.
  virtual std::optional<plan::Unit> next_unit(std::uint64_t horizon, std::uint32_t scans_max) = 0;
  virtual void consume(base::ReplicaId replica, std::uint64_t first_scan,
                       std::span<const plan::ScanRecord> records) = 0;
  /// Number of scans that all replicas of the part have completed, including the burn-in's scans.
  virtual std::uint64_t scans() const = 0;
  /// Number of the part's records at inverse temperature 1.
  virtual std::uint64_t draws() const = 0;
  virtual const Solutions& solutions() const = 0;
  /// One chain's row of a table.
  struct Row {
    const char* name;
    const char* meaning;
    const char* dimension;  ///< Empty for a scalar.
    std::vector<double> values;
  };
  virtual std::vector<Row> rows() const = 0;
  /// A warning for plan::Report.
  virtual const char* warning() const { return ""; }
};

}  // namespace sleight::sampling
