// What the free islands of chains have said of the target, for archives: tables by chain and
// island. And what they say of P(satisfied) together, for the stop rule that asks for it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/math/island_odds.h"
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

/// Of P(satisfied), by the islands of each chain's scans from `first` on and before `end`, chain
/// after chain. REQUIRES: they are there.
math::IslandOdds odds_between(std::span<const IslandsOfChain* const> chains, std::uint64_t first,
                              std::uint64_t end);

/// Of the islands of each chain's first `scans` scans; nothing where these have none. The islands
/// from scan `odds_from` on alone tell the odds, where a stop rule chose how many these are; then
/// they are told too. REQUIRES: odds_from at most `scans`.
plan::Report report_of(std::span<const IslandsOfChain* const> chains, std::uint64_t scans,
                       std::optional<std::uint64_t> odds_from = {});

}  // namespace sleight::sampling
