#include "worker/sampling/tuning.h"

#include <algorithm>

#include "common/base/check.h"
#include "common/math/elementary.h"

namespace sleight::sampling {
namespace {

/// The factor at acceptance rate 1 is exp(3), about 20, times the factor at rate 0.
constexpr double k_gain = 3;

}  // namespace

void KindCounts::add(std::span<const std::uint32_t> proposed_now,
                     std::span<const std::uint32_t> accepted_now) {
  CHECK_EQ(proposed_now.size(), accepted_now.size());
  proposed.resize(std::max(proposed.size(), proposed_now.size()), 0);
  accepted.resize(proposed.size(), 0);
  for (std::size_t kind = 0; kind < proposed_now.size(); ++kind) {
    proposed[kind] += proposed_now[kind];
    accepted[kind] += accepted_now[kind];
  }
}

std::vector<double> tuned(std::span<const double> scales, const KindCounts& counts,
                          const std::vector<bool>& has_scale) {
  std::vector<double> next(scales.begin(), scales.end());
  next.resize(std::max(next.size(), counts.proposed.size()), 1);
  for (std::size_t kind = 0; kind < counts.proposed.size(); ++kind) {
    if (kind >= has_scale.size() || !has_scale[kind]) continue;
    if (counts.proposed[kind] < k_proposals_min) continue;
    const double rate =
        static_cast<double>(counts.accepted[kind]) / static_cast<double>(counts.proposed[kind]);
    next[kind] = std::clamp(next[kind] * math::exp(k_gain * (rate - k_acceptance_target)),
                            k_scale_min, k_scale_max);
  }
  return next;
}

}  // namespace sleight::sampling
