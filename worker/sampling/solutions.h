// Independent solutions of one chain. A lineage's solution is its first scan at inverse temperature
// 1 that satisfies the constraint. Not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/plan/plan.h"
#include "common/plan/unit.h"

namespace sleight::sampling {

class Solutions {
 public:
  /// The first satisfied scan of a lineage.
  struct First {
    std::uint64_t scan = 0;
    std::uint64_t lineage = 0;
    double log_p = 0;  ///< log p_w + log p_c of the state at that scan.
  };

  /// Adds a result. REQUIRES: one lineage's results come in the order of scans.
  void add(std::uint64_t scan, const plan::ScanRecord& record);
  std::uint64_t count() const { return firsts_.size(); }
  std::uint64_t before(std::uint64_t scan) const;
  /// Solutions with first <= scan < end, by (scan, lineage).
  std::span<const First> between(std::uint64_t first, std::uint64_t end) const;

 private:
  std::vector<std::uint64_t> lineages_;  ///< Ascending.
  std::vector<First> firsts_;            ///< By (scan, lineage).
};

/// Returns the chains' solutions with after < decided <= until, ordered by (decided, chain). A
/// solution is decided once all chains have completed its scan. Null chains are skipped.
std::vector<plan::Solution> solutions_between(std::span<const Solutions* const> chains,
                                              std::uint64_t after, std::uint64_t until);

}  // namespace sleight::sampling
