// What the free islands of chains have said of the target, for archives: tables by chain and
// island.
#pragma once

#include <cstdint>
#include <optional>
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
  /// The next scan's only one.
  void add(const IslandEstimate& island);
  const std::vector<IslandEstimate>& estimates() const { return estimates_; }
  /// Of its first so many scans. REQUIRES: they are there.
  std::size_t count_of(std::uint64_t scans) const { return scans == 0 ? 0 : ends_[scans - 1]; }
  std::uint64_t scans() const { return ends_.size(); }

 private:
  std::vector<IslandEstimate> estimates_;
  std::vector<std::size_t> ends_;  ///< by scan: estimates up to and with it
};

/// Scans of each chain whose islands tell the odds, where not all of them may: from `first` on, if
/// those before have chosen how many they are; before `end`, if islands decide whether there are
/// more.
struct OddsScans {
  std::optional<std::uint64_t> first{};
  std::optional<std::uint64_t> end{};
};

/// Of the islands of each chain's first `scans` scans; nothing where these have none.
/// REQUIRES: those of `odds` are among them.
plan::Report report_of(std::span<const IslandsOfChain* const> chains, std::uint64_t scans,
                       const OddsScans& odds = {});

}  // namespace sleight::sampling
