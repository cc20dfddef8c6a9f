#include "worker/sampling/independent_chains.h"

#include <algorithm>
#include <limits>

#include "common/base/check.h"

namespace sleight::sampling {
namespace {

constexpr std::uint64_t k_no_end = std::numeric_limits<std::uint64_t>::max();

}  // namespace

std::uint64_t scans_through_round(std::uint64_t round_scans, std::uint32_t rounds) {
  if (rounds >= 64) return k_no_end;
  const std::uint64_t lengths = (std::uint64_t{1} << rounds) - 1;
  if (round_scans > k_no_end / std::max<std::uint64_t>(lengths, 1)) return k_no_end;
  return round_scans * lengths;
}

IndependentChains::IndependentChains(const IndependentChainsOptions& options)
    : options_(options), chains_(options.chains), end_(k_no_end) {
  CHECK_GE(options.chains, 1U);
  CHECK_GE(options.round_scans, 1U);
  const StopRule& stop = options.stop;
  CHECK(stop.scans || stop.rounds || stop.independent_solutions);
  if (stop.scans) end_ = *stop.scans;
  if (stop.rounds) end_ = std::min(end_, scans_through_round(options.round_scans, *stop.rounds));
  for (std::uint32_t id = 0; id < options.chains; ++id)
    by_progress_.emplace_hint(by_progress_.end(), 0, id);
  idle_ = by_progress_;
  judge_rounds();
}

void IndependentChains::judge_rounds() {
  horizon_ = end_;
  if (!options_.stop.independent_solutions) return;
  const std::uint64_t reached = common_consumed();
  std::uint64_t round_end = scans_through_round(options_.round_scans, round_);
  while (reached >= round_end && round_end < end_) {
    // Count the lineages that had satisfied by this round's end.
    std::uint64_t solutions = 0;
    for (const Chain& chain : chains_) {
      solutions += static_cast<std::uint64_t>(
          std::count_if(chain.first_satisfied.begin(), chain.first_satisfied.end(),
                        [&](std::uint64_t scan) { return scan < round_end; }));
    }
    if (solutions >= *options_.stop.independent_solutions) {
      end_ = round_end;
      break;
    }
    round_end = scans_through_round(options_.round_scans, ++round_);
  }
  horizon_ = std::min(end_, round_end);
}

std::optional<plan::Unit> IndependentChains::next_unit(std::uint32_t scans_max) {
  CHECK_GE(scans_max, 1U);
  // Choose the idle chain that is furthest behind, the lowest id among equals.
  if (idle_.empty()) return std::nullopt;
  const auto [consumed, id] = *idle_.begin();
  if (consumed >= horizon_) return std::nullopt;
  idle_.erase(idle_.begin());
  return plan::Unit{
      .replica = {base::ChainId{id}, base::ReplicaId{0}},
      .first_scan = base::ScanIndex{consumed},
      .scans = static_cast<std::uint32_t>(std::min<std::uint64_t>(horizon_ - consumed, scans_max)),
      .inverse_temperature = 1};
}

void IndependentChains::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                                std::span<const plan::ScanRecord> records) {
  CHECK_LT(replica.chain.value, chains_.size());
  CHECK_EQ(replica.replica.value, 0U);
  Chain& chain = chains_[replica.chain.value];
  CHECK_EQ(first_scan.value, chain.consumed);
  by_progress_.erase({chain.consumed, replica.chain.value});
  idle_.erase({chain.consumed, replica.chain.value});  // there when it comes from a run store
  for (const plan::ScanRecord& record : records) {
    if (record.satisfied && chain.newest_satisfied_lineage != record.lineage) {
      chain.newest_satisfied_lineage = record.lineage;
      chain.first_satisfied.push_back(chain.consumed);
      ++solutions_;
    }
    ++chain.consumed;
  }
  by_progress_.emplace(chain.consumed, replica.chain.value);
  idle_.emplace(chain.consumed, replica.chain.value);
  judge_rounds();
}

bool IndependentChains::finished() const {
  return common_consumed() >= end_;
}

std::uint64_t IndependentChains::common_consumed() const {
  return by_progress_.begin()->first;
}

std::uint64_t IndependentChains::scans_common() const {
  return std::min(common_consumed(), end_);
}

std::uint64_t IndependentChains::scans_consumed() const {
  std::uint64_t sum = 0;
  for (const Chain& chain : chains_)
    sum += std::min(chain.consumed, end_);
  return sum;
}

std::optional<std::uint64_t> IndependentChains::scans_total() const {
  if (end_ == k_no_end) return std::nullopt;
  return end_ * chains_.size();
}

}  // namespace sleight::sampling
