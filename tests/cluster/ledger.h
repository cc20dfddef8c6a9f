// All scans of a stored or serial run, by replica. Each scan has its state. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/plan/plan.h"
#include "common/plan/unit.h"

namespace sleight::cluster {

struct Ledger {
  struct Replica {
    std::uint64_t first_scan = 0;
    std::vector<plan::ScanRecord> scans;
    base::Bytes state;  ///< after the last
    std::uint64_t next_scan() const { return first_scan + scans.size(); }
  };
  std::map<plan::ReplicaKey, Replica> replicas;

  /// Returns whether the result is its replica's first result, or directly continues the replica.
  bool continues(const plan::UnitResult& result) const;
  /// REQUIRES: continues(result).
  void add(plan::UnitResult result);
  std::uint64_t scans() const;
};

/// A digest of all bits, in logical order.
std::uint64_t digest_of(const Ledger& ledger);
/// Returns a description of the first difference between two ledgers, or an empty string.
std::string difference(const Ledger& expected, const Ledger& found);

/// Runs the plan's scans one after another, and returns the results. The plan is finished
/// afterwards.
Ledger run_serially(plan::Plan& plan, const plan::UnitWorker& worker);

}  // namespace sleight::cluster
