// What independent, unbiased estimates of a number too small for doubles say of it together: the
// log of their mean, and how well that is known. Free islands give such estimates of Z and of
// P(satisfied) (worker/sampling/island.h), as logs.
//
// Idea. The mean of the estimates is unbiased, whatever their spread; the mean of their logs is
// not. Its standard error is their standard deviation over the square root of their number, and in
// nats, the unit of the log, that relative to the mean. Few large estimates can carry the sum: then
// the standard deviation is as little known as the mean, and mostly too small, since what is larger
// still has not been seen. So an error counts only where no estimate has more than a tenth of the
// sum, and where there are enough of them.
//
// A run may choose the number of estimates by what earlier ones say, not by what the counted ones
// say: to stop where the estimate looks good is to stop where large ones have not come yet
// (worker/sampling/odds_rule.h).
//
// Invariant: equal sequences give equal bits. Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

namespace sleight::math {

/// Of the sum, that one estimate may have where the error is to count.
inline constexpr double k_largest_share_max = 0.1;
/// Estimates that it takes. Of fewer the large ones mostly have not come: intervals of 48 islands
/// of a box of two balls missed the truth by three errors or more 4 to 13% of the times, of 144
/// islands 4 to 7% (docs/MEASUREMENTS, "Intervals by islands").
inline constexpr std::uint64_t k_islands_min = 100;

struct IslandOdds {
  std::uint64_t islands = 0;
  /// Of the mean; -infinity where all estimates are 0, NaN where there are none.
  double log_mean = std::numeric_limits<double>::quiet_NaN();
  /// Standard deviation of one estimate over the mean; NaN where there are fewer than two, or all
  /// are 0.
  double relative_sd = std::numeric_limits<double>::quiet_NaN();
  /// What the largest estimate has of the sum, in [0, 1]; NaN where that is 0 or nothing.
  double largest_share = std::numeric_limits<double>::quiet_NaN();

  /// Standard error of log_mean, in nats; NaN as relative_sd.
  double log_error() const { return log_error_of(static_cast<double>(islands)); }
  /// What it will be of so many estimates. REQUIRES: count above 0.
  double log_error_of(double count) const;
  /// Whether log_error can be given for log_mean.
  bool known() const;
};

/// Estimates one by one, none of which is kept.
class IslandSums {
 public:
  /// The log of an estimate; -infinity: it is 0. A NaN or +infinity, which no estimate has, makes
  /// all that is said of the sums NaN.
  void add(double log_estimate);
  IslandOdds odds() const;

 private:
  static constexpr double k_log_zero = -std::numeric_limits<double>::infinity();

  std::uint64_t islands_ = 0;
  double greatest_ = k_log_zero;
  double sum_ = 0;      ///< of exp(x - greatest)
  double squares_ = 0;  ///< of their squares
  bool is_void_ = false;
};

/// Of these logs, in order.
IslandOdds island_odds(std::span<const double> log_estimates);

}  // namespace sleight::math
