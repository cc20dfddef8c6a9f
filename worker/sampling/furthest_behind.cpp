#include "worker/sampling/furthest_behind.h"

#include <algorithm>

#include "common/base/check.h"

namespace sleight::sampling {

FurthestBehind::FurthestBehind(std::size_t chains) : scans_(chains, 0) {
  CHECK_GE(chains, 1U);
  for (std::size_t chain = 0; chain < chains; ++chain)
    by_scans_.emplace(0, chain);
  may_give_ = by_scans_;
}

std::uint64_t FurthestBehind::sum(std::uint64_t end) const {
  std::uint64_t sum = 0;
  for (const std::uint64_t scans : scans_)
    sum += std::min(scans, end);
  return sum;
}

std::size_t FurthestBehind::going(std::uint64_t horizon) {
  if (horizon != horizon_) {
    horizon_ = horizon;
    const auto goes = [horizon](std::uint64_t scans) { return scans < horizon; };
    going_ = static_cast<std::size_t>(std::ranges::count_if(scans_, goes));
  }
  return going_;
}

void FurthestBehind::moved(std::size_t chain, std::uint64_t scans) {
  const std::uint64_t before = std::exchange(scans_[chain], scans);
  CHECK_GE(scans, before);
  if (scans != before) {
    auto node = by_scans_.extract({before, chain});
    node.value().first = scans;
    by_scans_.insert(std::move(node));
    may_give_.erase({before, chain});
    if (before < horizon_ && scans >= horizon_) --going_;
  }
  may_give_.emplace(scans, chain);
}

}  // namespace sleight::sampling
