// Archive tables of free islands' estimates, by chain and island.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/plan/report.h"
#include "common/plan/unit.h"
#include "worker/sampling/island_estimate.h"

namespace sleight::sampling {

/// One chain's free islands, ordered by scan. Scan 0, the start, has no islands.
class IslandsOfChain {
 public:
  /// Adds the next scan's islands.
  void add(const plan::ScanRecord& record);
  /// Adds the next scan's only island.
  void add(const IslandEstimate& island);
  const std::vector<IslandEstimate>& estimates() const { return estimates_; }
  /// Number of islands in the first `scans` scans. REQUIRES: islands of these scans have been
  /// added.
  std::size_t count_of(std::uint64_t scans) const { return scans == 0 ? 0 : ends_[scans - 1]; }
  std::uint64_t scans() const { return ends_.size(); }

 private:
  std::vector<IslandEstimate> estimates_;
  std::vector<std::size_t> ends_;  ///< By scan: number of estimates up to and including the scan's.
};

/// Scans first <= scan < end count towards the odds. `first` is set if earlier islands determined
/// the number of islands. `end` is set if islands decide on later scans.
struct OddsScans {
  std::optional<std::uint64_t> first{};
  std::optional<std::uint64_t> end{};
};

/// Reports the islands of each chain's first `scans` scans. REQUIRES: `odds` lies within them.
plan::Report report_of(std::span<const IslandsOfChain* const> chains, std::uint64_t scans,
                       const OddsScans& odds = {});

}  // namespace sleight::sampling
