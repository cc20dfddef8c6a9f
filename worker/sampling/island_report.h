// What the free islands of chains have said of the target, for archives: tables by chain and
// island.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/plan/report.h"
#include "common/plan/unit.h"
#include "worker/sampling/island_estimate.h"

namespace sleight::sampling {

/// The free islands of one chain's scans, in order. Its start has none.
class IslandsOfChain {
 public:
  /// The next scan's.
  void add(const plan::ScanRecord& record);
  const std::vector<IslandEstimate>& estimates() const { return estimates_; }
  /// Of its first so many scans. REQUIRES: they are there.
  std::size_t count_of(std::uint64_t scans) const { return scans == 0 ? 0 : ends_[scans - 1]; }
  std::uint64_t scans() const { return ends_.size(); }

 private:
  std::vector<IslandEstimate> estimates_;
  std::vector<std::size_t> ends_;  ///< by scan: estimates up to and with it
};

/// Of the islands of each chain's first `scans` scans; nothing where these have none.
plan::Report report_of(std::span<const IslandsOfChain* const> chains, std::uint64_t scans);

}  // namespace sleight::sampling
