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
  if (options_.keep_per_lineage == 0 || full_lineages_.contains(record.lineage)) return;

  // Compare the animation with others of its lineage. A lineage's first animation needs no
  // likeness, and most lineages have only one animation.
  const auto lineage = by_lineage_.find(record.lineage);
  std::vector<double> likeness;
  if (lineage != by_lineage_.end()) {
    likeness = reader_.likeness(record.state);
    if (!is_distinct(lineage->second, likeness)) return;
  }
  if (!plays_out(record)) return;

  // Keep the animation, and store its likeness for later comparisons.
  auto& kept = lineage != by_lineage_.end() ? lineage->second : by_lineage_[record.lineage];
  if (kept.size() + 1 >= options_.keep_per_lineage) {
    forget(kept);
    by_lineage_.erase(record.lineage);
    full_lineages_.insert(record.lineage);
  } else {
    kept.push_back({.index = of_chain_.size()});
    hold(kept.back(), std::move(likeness));
  }
  of_chain_.push_back({scan, chain, record});
}

bool DistinctSelector::plays_out(const plan::ScanRecord& record) {
  const PlaysOut ends = reader_.play(record.state).ends;
  if (ends == PlaysOut::failed) ++failed_;
  return ends == PlaysOut::yes;
}

bool DistinctSelector::is_distinct(std::vector<Compared>& kept, std::span<const double> likeness) {
  return std::ranges::all_of(kept, [&](Compared& other) {
    if (!other.likeness.empty())
      return reader_.is_unlike(other.likeness, likeness, options_.min_distance);
    std::vector<double> asked = reader_.likeness(of_chain_[other.index].record.state);
    const bool is_unlike = reader_.is_unlike(asked, likeness, options_.min_distance);
    hold(other, std::move(asked));
    return is_unlike;
  });
}

void DistinctSelector::hold(Compared& compared, std::vector<double> likeness) {
  const std::size_t bytes = likeness.size() * sizeof(double);
  if (bytes > options_.likeness_bytes_max - likeness_bytes_) return;
  likeness_bytes_ += bytes;
  compared.likeness = std::move(likeness);
}

void DistinctSelector::forget(std::vector<Compared>& kept) {
  for (const Compared& compared : kept)
    likeness_bytes_ -= compared.likeness.size() * sizeof(double);
  kept.clear();
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
  full_lineages_.clear();
  likeness_bytes_ = 0;
}

std::vector<KeptAnimation> DistinctSelector::finish() {
  close_chain();
  return std::exchange(merged_, {});
}

}  // namespace sleight::archive
