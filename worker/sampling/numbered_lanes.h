// Numbered work, dealt to lanes in turn: number n is scan n / lanes of lane n % lanes. The result
// of an item depends only on its number. The lane that is furthest behind comes first. Not
// thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/plan/unit.h"

namespace sleight::sampling {

class NumberedLanes {
 public:
  /// A lane is a chain with one replica. Lanes are numbered from `first_lane` on. REQUIRES: at
  /// least one lane.
  NumberedLanes(std::uint32_t first_lane, std::uint32_t lanes, std::uint64_t seed);

  /// Returns some lane's next numbers below `end`. Each unit has `starts` set.
  std::optional<plan::Unit> next_unit(std::uint64_t end, std::uint32_t scans_max);
  /// Marks the lane's next numbers as done. REQUIRES: the lane's earlier numbers are done.
  void consume(base::ChainId lane, base::ScanIndex first_scan, std::size_t records);
  /// Count of numbers before the first unfinished number.
  std::uint64_t done() const { return done_; }
  /// Count of all finished numbers.
  std::uint64_t consumed() const { return consumed_; }

 private:
  std::uint32_t first_lane_;
  std::uint64_t seed_;
  std::vector<std::uint64_t> scans_;                        ///< Consumed scans by lane.
  std::set<std::pair<std::uint64_t, std::uint32_t>> idle_;  ///< Lanes with no unit out, by scan.
  std::uint64_t done_ = 0;
  std::uint64_t consumed_ = 0;
};

}  // namespace sleight::sampling
