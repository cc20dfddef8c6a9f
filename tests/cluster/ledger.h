// All scans of a run with their states, by replica: what a store holds, and what a serial run comes
// to. Not thread-safe.
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

  /// Whether the result goes on where its replica was, or begins it.
  bool continues(const plan::UnitResult& result) const;
  /// REQUIRES: it continues.
  void add(plan::UnitResult result);
  std::uint64_t scans() const;
};

/// One number for all bits, in logical order.
std::uint64_t digest_of(const Ledger& ledger);
/// Where two differ first, for people; nothing if they don't.
std::string difference(const Ledger& expected, const Ledger& found);

/// What the plan comes to when one scan is run after another. The plan is finished then.
Ledger run_serially(plan::Plan& plan, const plan::UnitWorker& worker);

}  // namespace sleight::cluster
