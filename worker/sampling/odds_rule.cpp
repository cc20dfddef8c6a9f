#include "worker/sampling/odds_rule.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace sleight::sampling {

void OddsRule::add(double log_satisfied) {
  CHECK(!is_over_);
  all_.add(log_satisfied);
  if (is_sized()) {
    batch_.add(log_satisfied);
    judge_batch();
  } else {
    pilot_.add(log_satisfied);
    judge_pilot();
  }
}

void OddsRule::judge_pilot() {
  const math::IslandOdds odds = pilot_.odds();
  if (odds.islands % k_pilot_islands != 0) return;
  // If all estimates are 0, the largest share is NaN and counts as too large.
  const bool is_wild = !(odds.largest_share <= k_pilot_share_max);
  if (is_wild && odds.islands < k_pilot_islands_max) return;
  if (!std::isfinite(odds.log_mean)) {
    is_over_ = true;
    return;
  }
  const double relative_sd = odds.relative_sd / log_error_;
  const double islands = std::ceil(k_variance_lacking * relative_sd * relative_sd);
  first_islands_ = std::max(math::k_islands_min, static_cast<std::uint64_t>(islands));
  batch_islands_ = first_islands_;
}

void OddsRule::judge_batch() {
  const math::IslandOdds odds = batch_.odds();
  if (odds.islands < batch_islands_) return;
  is_over_ = odds.known() || batch_islands_ >= k_batch_growth_max * first_islands_;
  if (!is_over_) batch_islands_ += first_islands_ / 2;
}

std::uint64_t OddsRule::needed() const {
  const std::uint64_t pilot = pilot_islands();
  if (is_sized()) return pilot + batch_islands_;
  if (is_over_) return pilot;
  // After the pilot's next part, a batch usually follows. So count that part and the smallest
  // batch.
  return pilot / k_pilot_islands * k_pilot_islands + k_pilot_islands + math::k_islands_min;
}

}  // namespace sleight::sampling
