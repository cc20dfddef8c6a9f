#include "worker/sampling/search_lanes.h"

#include <algorithm>

#include "common/base/check.h"

namespace sleight::sampling {

using plan::k_search_lanes;

SearchLanes::SearchLanes(std::uint64_t seed, std::uint64_t wanted,
                         std::vector<std::string> stage_names)
    : seed_(seed),
      stage_names_(std::move(stage_names)),
      lanes_(k_search_lanes),
      finds_{.wanted = wanted} {
  for (std::uint32_t lane = 0; lane < k_search_lanes; ++lane)
    idle_.emplace(0, lane);
}

void SearchLanes::want(std::uint64_t finds) {
  finds_.wanted = std::max(finds_.wanted, finds);
  count();
}

std::optional<plan::Unit> SearchLanes::next_unit(std::uint32_t scans_max) {
  CHECK_GE(scans_max, 1U);
  if (finished() || idle_.empty()) return std::nullopt;
  const std::uint64_t missing = finds_.wanted - finds_.found;
  // Starts in progress are expected to succeed as often as earlier starts.
  const std::uint64_t finds = finds_.found + found_ahead_;
  const std::uint64_t expected = out_ * (finds + 1) / (starts_ + 1) + found_ahead_;
  // If the starts in progress are expected to yield all missing finds, hand out no further starts.
  if (expected >= missing && out_ > 0) return std::nullopt;

  // A lane gets several starts at once only if every lane could get this number of starts.
  const std::uint64_t each = expected >= missing ? 0 : (missing - expected) / k_search_lanes;
  const auto [scan, id] = *idle_.begin();
  idle_.erase(idle_.begin());
  const std::uint64_t scans = std::clamp<std::uint64_t>(each, 1, scans_max);
  lanes_[id].handed_out = scan + scans;
  out_ += scans;
  return plan::Unit{.replica = {base::ChainId{plan::k_first_lane + id}, base::ReplicaId{0}},
                    .seed = seed_,
                    .first_scan = base::ScanIndex{scan},
                    .scans = static_cast<std::uint32_t>(scans),
                    .starts = true};
}

void SearchLanes::consume(base::ChainId chain, base::ScanIndex first_scan,
                          std::span<const plan::ScanRecord> records) {
  const std::uint32_t id = chain.value - plan::k_first_lane;
  CHECK_LT(id, k_search_lanes);
  Lane& lane = lanes_[id];
  CHECK_EQ(first_scan.value, lane.found.size());
  idle_.erase({lane.found.size(), id});  // Still idle if results come from a run store.
  if (lane.handed_out > lane.found.size()) out_ -= records.size();
  for (const plan::ScanRecord& record : records) {
    lane.found.push_back(record.satisfied);
    lane.furthest.push_back(record.method_values.empty()
                                ? 0
                                : static_cast<std::uint32_t>(record.method_values.front()));
    lane.log_ps.push_back(record.log_prior + record.log_constraint);
    if (record.satisfied) ++found_ahead_;
  }
  starts_ += records.size();
  lane.handed_out = std::max<std::uint64_t>(lane.handed_out, lane.found.size());
  if (lane.handed_out == lane.found.size()) idle_.emplace(lane.found.size(), id);
  count();
}

std::vector<plan::Find> SearchLanes::finds_between(std::uint64_t first, std::uint64_t end) const {
  const auto begin = std::ranges::lower_bound(found_, first, {}, &plan::Find::start);
  return {begin, std::ranges::lower_bound(begin, found_.end(), end, {}, &plan::Find::start)};
}

void SearchLanes::count() {
  while (!finished()) {
    const Lane& lane = lanes_[counted_ % k_search_lanes];
    const std::uint64_t scan = counted_ / k_search_lanes;
    if (scan >= lane.found.size()) return;
    ++counted_;
    ++in_vain_;
    furthest_ = std::max(furthest_, lane.furthest[scan]);
    if (lane.found[scan]) {
      ++finds_.found;
      found_.push_back({.start = counted_ - 1, .log_p = lane.log_ps[scan]});
      --found_ahead_;
      in_vain_ = 0;
      furthest_ = 0;
    }
    if (in_vain_ < k_starts_in_vain_max) continue;
    finds_.gave_up = true;
    if (furthest_ < stage_names_.size()) finds_.stuck_at = stage_names_[furthest_];
  }
}

}  // namespace sleight::sampling
