#include "common/math/island_odds.h"

#include <algorithm>
#include <cmath>

#include "common/math/elementary.h"

namespace sleight::math {

double IslandOdds::log_error_of(double count) const {
  return relative_sd / std::sqrt(count);
}

// NaN fails every comparison.
bool IslandOdds::known() const {
  return islands >= k_islands_min && largest_share <= k_largest_share_max && relative_sd >= 0;
}

void IslandSums::add(double log_estimate) {
  ++islands_;
  if (std::isnan(log_estimate) || log_estimate == std::numeric_limits<double>::infinity()) {
    is_void_ = true;
    return;
  }
  if (log_estimate == k_log_zero) return;
  if (log_estimate <= greatest_) {
    const double estimate = math::exp(log_estimate - greatest_);
    sum_ += estimate;
    squares_ += estimate * estimate;
    return;
  }
  // The sums are relative to the greatest estimate. This estimate is greater, so rescale the sums.
  const double factor = greatest_ == k_log_zero ? 0 : math::exp(greatest_ - log_estimate);
  sum_ = sum_ * factor + 1;
  squares_ = squares_ * factor * factor + 1;
  greatest_ = log_estimate;
}

IslandOdds IslandSums::odds() const {
  IslandOdds odds{.islands = islands_};
  if (islands_ == 0 || is_void_) return odds;
  odds.log_mean = k_log_zero;
  if (sum_ == 0) return odds;
  const auto count = static_cast<double>(islands_);
  odds.log_mean = greatest_ + math::log(sum_) - math::log(count);
  odds.largest_share = 1 / sum_;
  if (islands_ < 2) return odds;
  // (mean square - squared mean) / squared mean. Rounding may make this negative.
  const double relative_variance = count * squares_ / (sum_ * sum_) - 1;
  odds.relative_sd = std::sqrt(std::max(relative_variance, 0.0) * count / (count - 1));
  return odds;
}

IslandOdds island_odds(std::span<const double> log_estimates) {
  IslandSums sums;
  for (const double log_estimate : log_estimates)
    sums.add(log_estimate);
  return sums.odds();
}

}  // namespace sleight::math
