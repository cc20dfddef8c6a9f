// Work that is numbered and dealt to lanes in turn: number n is scan n / lanes of lane n % lanes.
// What a number comes to depends on nothing but the number, so that any of it can be done next.
// The lane that is furthest behind comes first. Not thread-safe.
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
  /// Lanes are chains with one replica, numbered from `first_lane` on. REQUIRES: one lane at least.
  NumberedLanes(std::uint32_t first_lane, std::uint32_t lanes, std::uint64_t seed);

  /// The next numbers of a lane, of those below `end`; `starts` holds of each unit.
  std::optional<plan::Unit> next_unit(std::uint64_t end, std::uint32_t scans_max);
  /// The next so many of a lane are done. REQUIRES: the lane is ours, and has done those before.
  void consume(base::ChainId lane, base::ScanIndex first_scan, std::size_t records);
  /// Numbers that are done with all before them.
  std::uint64_t done() const { return done_; }
  /// All that are done.
  std::uint64_t consumed() const { return consumed_; }

 private:
  std::uint32_t first_lane_;
  std::uint64_t seed_;
  std::vector<std::uint64_t> scans_;                        ///< consumed, by lane
  std::set<std::pair<std::uint64_t, std::uint32_t>> idle_;  ///< lanes with nothing out, by scan
  std::uint64_t done_ = 0;
  std::uint64_t consumed_ = 0;
};

}  // namespace sleight::sampling
