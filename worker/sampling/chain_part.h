// One chain's part of a plan, after its burn-in: what runs next, and what follows from results.
//
// A burn-in by parallel tempering (ladder_run.h) has found temperatures, proposal sizes, log Z at
// each level, and a state at inverse temperature 1: a part goes on from there.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/plan/report.h"
#include "common/plan/unit.h"
#include "worker/sampling/solutions.h"

namespace sleight::sampling {

/// What a burn-in leaves.
struct BurnIn {
  std::uint64_t seed = 0;
  base::ChainId chain;
  std::uint64_t scans = 0;     ///< the next one is the part's first
  base::ReplicaId coolest;     ///< whose state is at inverse temperature 1
  base::ReplicaId first_free;  ///< no replica has had this id, or a greater one
  std::uint64_t lineage = 0;   ///< of the coolest's state
  /// Of the last round: levels ascending, what proposals' sizes were, and log Z_{i+1} - log Z_i.
  std::vector<double> ladder;
  std::vector<std::vector<double>> scales;
  std::vector<double> log_z_steps;
  /// What that round says is better: for methods that need no log Z.
  std::vector<double> next_ladder;
  std::vector<std::vector<double>> next_scales;
};

class ChainPart {
 public:
  virtual ~ChainPart() = default;
  /// As Plan::next_unit, of scans below the horizon.
  virtual std::optional<plan::Unit> next_unit(std::uint64_t horizon, std::uint32_t scans_max) = 0;
  /// As Plan::consume.
  virtual void consume(base::ReplicaId replica, std::uint64_t first_scan,
                       std::span<const plan::ScanRecord> records) = 0;
  /// Scans that all its replicas have, burn-in included.
  virtual std::uint64_t scans() const = 0;
  /// Of these, records at inverse temperature 1.
  virtual std::uint64_t draws() const = 0;
  virtual const Solutions& solutions() const = 0;
  /// One row of a table per chain: values over some dimension of its own.
  struct Row {
    const char* name;
    const char* meaning;
    const char* dimension;  ///< none: a scalar
    std::vector<double> values;
  };
  virtual std::vector<Row> rows() const = 0;
  /// As plan::Report's.
  virtual const char* warning() const { return ""; }
};

}  // namespace sleight::sampling
