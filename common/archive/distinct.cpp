#include "common/archive/distinct.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "common/base/check.h"

namespace sleight::archive {
namespace {

bool earlier(const KeptAnimation& a, const KeptAnimation& b) {
  return std::tie(a.scan, a.chain) < std::tie(b.scan, b.chain);
}

}  // namespace

void DistinctSelector::offer(base::ChainId chain, base::ScanIndex scan,
                             const plan::ScanRecord& record) {
  CHECK_GE(chain, chain_);
  if (chain != chain_) {
    close_chain();
    chain_ = chain;
  }
  if (!record.satisfied || of_chain_.size() >= options_.keep_max) return;
  CHECK(!record.state.empty());
  const auto lineage = by_lineage_.find(record.lineage);
  if (lineage == by_lineage_.end()) {
    if (options_.keep_per_lineage == 0 || !plays_out(record)) return;
    by_lineage_[record.lineage] = {of_chain_.size()};
  } else {
    if (!is_distinct(lineage->second, record) || !plays_out(record)) return;
    lineage->second.push_back(of_chain_.size());
  }
  of_chain_.push_back({scan, chain, record});
}

bool DistinctSelector::plays_out(const plan::ScanRecord& record) {
  const PlaysOut ends = reader_.play(record.state).ends;
  if (ends == PlaysOut::failed) ++failed_;
  return ends == PlaysOut::yes;
}

bool DistinctSelector::is_distinct(const std::vector<std::size_t>& kept_of_lineage,
                                   const plan::ScanRecord& record) const {
  if (kept_of_lineage.size() >= options_.keep_per_lineage) return false;
  return std::ranges::all_of(kept_of_lineage, [&](std::size_t index) {
    return reader_.likeness_distance(of_chain_[index].record.state, record.state) >
           options_.min_distance;
  });
}

void DistinctSelector::close_chain() {
  std::vector<KeptAnimation> both;
  both.reserve(merged_.size() + of_chain_.size());
  std::ranges::merge(std::make_move_iterator(merged_.begin()),
                     std::make_move_iterator(merged_.end()),
                     std::make_move_iterator(of_chain_.begin()),
                     std::make_move_iterator(of_chain_.end()), std::back_inserter(both), earlier);
  if (both.size() > options_.keep_max) both.resize(options_.keep_max);
  merged_ = std::move(both);
  of_chain_.clear();
  by_lineage_.clear();
}

std::vector<KeptAnimation> DistinctSelector::finish() {
  close_chain();
  return std::exchange(merged_, {});
}

}  // namespace sleight::archive
