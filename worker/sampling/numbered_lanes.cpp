#include "worker/sampling/numbered_lanes.h"

#include <algorithm>

#include "common/base/check.h"

namespace sleight::sampling {

NumberedLanes::NumberedLanes(std::uint32_t first_lane, std::uint32_t lanes, std::uint64_t seed)
    : first_lane_(first_lane), seed_(seed), scans_(lanes, 0) {
  CHECK_GE(lanes, 1U);
  for (std::uint32_t id = 0; id < lanes; ++id)
    idle_.emplace_hint(idle_.end(), 0, id);
}

std::optional<plan::Unit> NumberedLanes::next_unit(std::uint64_t end, std::uint32_t scans_max) {
  CHECK_GE(scans_max, 1U);
  if (idle_.empty()) return std::nullopt;
  const auto [scan, id] = *idle_.begin();
  // Count the lane's numbers below the end.
  const std::uint64_t scans_of_lane = (end + scans_.size() - 1 - id) / scans_.size();
  // This lane has the least unfinished number. If this lane has no work below the end, no other
  // lane has.
  if (scan >= scans_of_lane) return std::nullopt;
  idle_.erase(idle_.begin());
  const std::uint64_t scans = std::min<std::uint64_t>(scans_of_lane - scan, scans_max);
  return plan::Unit{.replica = {base::ChainId{first_lane_ + id}, base::ReplicaId{0}},
                    .seed = seed_,
                    .first_scan = base::ScanIndex{scan},
                    .scans = static_cast<std::uint32_t>(scans),
                    .starts = true};
}

void NumberedLanes::consume(base::ChainId lane, base::ScanIndex first_scan, std::size_t records) {
  const std::uint32_t id = lane.value - first_lane_;
  CHECK_LT(id, scans_.size());
  CHECK_EQ(first_scan.value, scans_[id]);
  idle_.erase({scans_[id], id});  // Still idle if results come from a run store.
  scans_[id] += records;
  consumed_ += records;
  idle_.emplace(scans_[id], id);
  while (done_ / scans_.size() < scans_[done_ % scans_.size()])
    ++done_;
}

}  // namespace sleight::sampling
