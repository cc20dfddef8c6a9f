#include "worker/sampling/index_process.h"

#include <algorithm>

#include "common/base/check.h"

namespace sleight::sampling {

void IndexProcess::add(std::uint64_t scan, std::span<const std::uint32_t> replica) {
  CHECK_LT(replica.size(), std::size_t{k_no_level});
  CHECK(moments_.empty() || moments_.back().scan < scan);
  if (scan % stride_ != 0) return;
  Moment& moment = moments_.emplace_back();
  moment.scan = scan;
  if (!replica.empty()) moment.level.resize(std::ranges::max(replica) + std::size_t{1}, k_no_level);
  for (std::size_t level = 0; level < replica.size(); ++level)
    moment.level[replica[level]] = static_cast<std::uint16_t>(level);
  while (moments_.size() > k_moments_max) {
    stride_ *= 2;
    std::erase_if(moments_, [&](const Moment& kept) { return kept.scan % stride_ != 0; });
  }
}

}  // namespace sleight::sampling
