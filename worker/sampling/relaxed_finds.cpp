#include "worker/sampling/relaxed_finds.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/check.h"

namespace sleight::sampling {

RelaxedFinds::RelaxedFinds(SearchLanes lanes, const RelaxedOptions& options)
    : lanes_(std::move(lanes)), options_(options) {
  CHECK_EQ(lanes_.finds().wanted, options_.takes);
  CHECK(options_.takes >= 1 && options_.scans >= 1);
}

RelaxedFinds::Chain& RelaxedFinds::chain(std::size_t id) {
  if (chains_.size() <= id) chains_.resize(id + 1);
  return chains_[id];
}

std::optional<plan::Unit> RelaxedFinds::next_unit(std::uint32_t scans_max) {
  CHECK_GE(scans_max, 1U);
  if (finished()) return std::nullopt;
  if (auto unit = lanes_.next_unit(scans_max)) return unit;
  if (idle_.empty()) return std::nullopt;
  const auto [first, id] = *idle_.begin();
  idle_.erase(idle_.begin());
  const std::uint64_t scans = std::min<std::uint64_t>(chain_length() - first, scans_max);
  return plan::Unit{.replica = {base::ChainId{static_cast<std::uint32_t>(id)}, base::ReplicaId{0}},
                    .seed = options_.seed,
                    .first_scan = base::ScanIndex{first},
                    .scans = static_cast<std::uint32_t>(scans),
                    .starts = first == 0};
}

base::BytesView RelaxedFinds::start_state(plan::ReplicaKey replica) const {
  if (replica.chain.value >= chains_.size()) return {};
  return chains_[replica.chain.value].start;
}

void RelaxedFinds::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                           std::span<const plan::ScanRecord> records) {
  if (SearchLanes::has(replica.chain)) {
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (records[i].satisfied)
        found_ahead_[plan::start_number(replica.chain, first_scan.value + i)] = records[i].state;
    }
    lanes_.consume(replica.chain, first_scan, records);
  } else {
    const std::size_t id = replica.chain.value;
    Chain& moved = chain(id);
    CHECK_EQ(first_scan.value, moved.scans);
    idle_.erase({moved.scans, id});  // Still idle if results come from a run store.
    moved.scans += records.size();
    moved.satisfied = records.back().satisfied;
    moved.start = {};
    chain_scans_ += records.size();
    if (moved.is_known && moved.scans < chain_length()) idle_.emplace(moved.scans, id);
    judge_chains();
  }
  begin_chains();
}

void RelaxedFinds::begin_chains() {
  for (const plan::Find& find : lanes_.finds_between(known_starts_, lanes_.starts_done())) {
    // No chain numbers are left for further finds.
    if (begun_ == plan::k_first_lane) break;
    Chain& next = chain(begun_);
    auto found = found_ahead_.extract(find.start);
    CHECK(!found.empty());
    next.is_known = true;
    if (next.scans == 0) next.start = std::move(found.mapped());
    if (next.scans < chain_length()) idle_.emplace(next.scans, begun_);
    ++begun_;
  }
  known_starts_ = lanes_.starts_done();
}

void RelaxedFinds::judge_chains() {
  while (judged_ < chains_.size() && chains_[judged_].scans >= chain_length()) {
    ++in_vain_;
    if (chains_[judged_++].satisfied) {
      ++takes_;
      in_vain_ = 0;
    }
  }
  lanes_.want(options_.takes + judged_ - takes_);
}

bool RelaxedFinds::finished() const {
  if (takes_ >= options_.takes || in_vain_ >= k_starts_in_vain_max) return true;
  return judged_ == plan::k_first_lane || (lanes_.finds().gave_up && judged_ == begun_);
}

plan::Finds RelaxedFinds::finds() const {
  plan::Finds finds = lanes_.finds();
  finds.is_all = true;
  finds.relaxed = std::min(takes_, options_.takes);
  finds.relaxed_wanted = options_.takes;
  if (finds.gave_up || !finished() || takes_ >= options_.takes) return finds;
  finds.gave_up = true;
  finds.gave_up_because = fmt::format(
      "After relaxation, none of the last {} finds satisfied the constraint.", in_vain_);
  return finds;
}

std::optional<std::uint64_t> RelaxedFinds::scans_total() const {
  return lanes_.starts() + lanes_.finds().wanted * chain_length();
}

}  // namespace sleight::sampling
