// Independent solutions of one chain: which lineages have satisfied at inverse temperature 1, and
// at which scan first. Not thread-safe.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "common/plan/plan.h"
#include "common/plan/unit.h"

namespace sleight::sampling {

class Solutions {
 public:
  /// Where a lineage first satisfied.
  struct First {
    std::uint64_t scan = 0;
    std::uint64_t lineage = 0;
    double log_p = 0;  ///< of the state there: log p_w + log p_c
  };

  /// Results of one lineage come in the order of scans.
  void add(std::uint64_t scan, const plan::ScanRecord& record);
  std::uint64_t count() const { return firsts_.size(); }
  std::uint64_t before(std::uint64_t scan) const;
  /// At which a lineage first satisfied, ascending.
  std::vector<std::uint64_t> scans() const;
  /// In scans from `first` on and before `end`, by (scan, lineage).
  std::span<const First> between(std::uint64_t first, std::uint64_t end) const;

 private:
  std::vector<std::uint64_t> lineages_;  ///< ascending
  std::vector<First> firsts_;            ///< by (scan, lineage)
};

/// Of several chains, by number, those of scans that are decided with after < decided <= until: of
/// each, all chains have its scan then. By (decided, chain).
std::vector<plan::Solution> solutions_between(std::span<const Solutions* const> chains,
                                              std::uint64_t after, std::uint64_t until);

}  // namespace sleight::sampling
