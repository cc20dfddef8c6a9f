// Independent solutions of one chain: which lineages have satisfied at inverse temperature 1, and
// at which scan first. Not thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "common/plan/unit.h"

namespace sleight::sampling {

class Solutions {
 public:
  /// Results of one lineage come in the order of scans.
  void add(std::uint64_t scan, const plan::ScanRecord& record);
  std::uint64_t count() const { return scans_.size(); }
  std::uint64_t before(std::uint64_t scan) const;
  /// At which a lineage first satisfied, ascending.
  const std::vector<std::uint64_t>& scans() const { return scans_; }

 private:
  std::vector<std::uint64_t> lineages_;  ///< ascending
  std::vector<std::uint64_t> scans_;
};

}  // namespace sleight::sampling
