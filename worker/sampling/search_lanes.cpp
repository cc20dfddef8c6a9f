#include "worker/sampling/search_lanes.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/check.h"

namespace sleight::sampling {

using plan::k_search_lanes;

SearchLanes::SearchLanes(std::uint64_t seed, std::uint64_t wanted, SearchTexts texts)
    : seed_(seed), texts_(std::move(texts)), lanes_(k_search_lanes), finds_{.wanted = wanted} {
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
    const std::vector<double>& values = record.method_values;
    Reached& reached = lane.reached.emplace_back();
    if (!values.empty()) reached.furthest = static_cast<std::uint32_t>(values[0]);
    if (values.size() == 3)
      reached.nearest = Miss{.kind = static_cast<std::uint32_t>(values[1]), .amount = values[2]};
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
    if (lane.found[scan]) {
      ++finds_.found;
      found_.push_back({.start = counted_ - 1, .log_p = lane.log_ps[scan]});
      --found_ahead_;
      in_vain_ = 0;
    }
    if (in_vain_ < k_starts_in_vain_max) continue;
    finds_.gave_up = true;
    finds_.gave_up_because = why_in_vain();
  }
}

std::string SearchLanes::why_in_vain() const {
  // Say which stage no start passed.
  std::vector<Reached> starts;
  for (std::uint64_t start = counted_ - in_vain_; start < counted_; ++start)
    starts.push_back(lanes_[start % k_search_lanes].reached[start / k_search_lanes]);
  const std::uint32_t furthest = std::ranges::max(starts, {}, &Reached::furthest).furthest;
  const bool is_stuck = furthest < texts_.stages.size();
  std::string text =
      fmt::format("None of the last {} tries {}.", starts.size(),
                  is_stuck ? "got past " + texts_.stages[furthest]
                           : "satisfied the constraint when all bodies moved together");

  // List the share of starts that passed each earlier stage. If all starts that passed a stage also
  // passed the next one, list only the next one.
  constexpr std::size_t k_shares_max = 8;
  std::vector<std::string> shares;
  std::ptrdiff_t listed = 0;
  for (std::size_t stage = std::min<std::size_t>(furthest, texts_.stages.size());
       stage-- > 0 && shares.size() < k_shares_max;) {
    const std::ptrdiff_t passed =
        std::ranges::count_if(starts, [&](const Reached& one) { return one.furthest > stage; });
    if (passed == std::exchange(listed, passed)) continue;
    const double percent = 100.0 * static_cast<double>(passed) / static_cast<double>(starts.size());
    shares.push_back(fmt::format("{} got past {}",
                                 percent < 100 ? fmt::format("{:.0f}%", percent) : "All",
                                 texts_.stages[stage]));
  }
  std::ranges::reverse(shares);
  if (!shares.empty()) text += fmt::format(" {}.", fmt::join(shares, ", "));

  // Name the nearest miss of the stage that no start passed.
  std::optional<Miss> nearest;
  for (const Reached& one : starts) {
    if (one.furthest == furthest && one.nearest && (!nearest || *one.nearest < *nearest))
      nearest = one.nearest;
  }
  if (nearest && nearest->kind < texts_.misses.size()) {
    const MissKind& kind = texts_.misses[nearest->kind];
    const double amount = nearest->amount;
    text += fmt::format(
        " The nearest missed {} by {} {}.", kind.name,
        amount < 999.5 ? fmt::format("{:.3g}", amount) : fmt::format("{:.0f}", amount), kind.unit);
  }
  if (!texts_.advice.empty()) text += " " + texts_.advice;
  return text;
}

}  // namespace sleight::sampling
