// Computes the log of the mean of independent, unbiased estimates, and its standard error. The
// estimated number may be too small for a double. Free islands provide logs of such estimates
// (worker/sampling/island.h).
//
// Idea. The mean of the estimates is unbiased for any spread; the mean of their logs is not. The
// mean's standard error is the estimates' standard deviation divided by the square root of their
// number. The mean's relative error is the error of its log, in nats. If a few large estimates
// dominate the sum, the standard deviation is mostly too small, because even larger estimates have
// not occurred yet. So an error is valid only if there are enough estimates, and no estimate
// exceeds a tenth of the sum.
//
// The number of counted estimates may depend on earlier estimates, but must not depend on the
// counted ones (worker/sampling/odds_rule.h). Invariant: equal sequences yield equal bits. Thread
// safety: values and pure functions.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

namespace sleight::math {

/// The error is invalid if one estimate's share of the sum is larger than this.
inline constexpr double k_largest_share_max = 0.1;
/// The error is invalid if there are fewer estimates, because they usually include none of the rare
/// large values. Measured for a box of two balls: the mean missed the truth by three errors or more
/// in 4 to 13% of cases with 48 islands, and in 4 to 7% of cases with 144 islands
/// (docs/MEASUREMENTS, "Intervals by islands").
inline constexpr std::uint64_t k_islands_min = 100;

struct IslandOdds {
  std::uint64_t islands = 0;
  /// Log of the mean. -infinity: all estimates are 0. NaN: there are no estimates.
  double log_mean = std::numeric_limits<double>::quiet_NaN();
  /// Standard deviation of one estimate, divided by the mean. NaN for fewer than two estimates, or
  /// if all estimates are 0.
  double relative_sd = std::numeric_limits<double>::quiet_NaN();
  /// The largest estimate's share of the sum, in [0, 1]. NaN if the sum is 0 or empty.
  double largest_share = std::numeric_limits<double>::quiet_NaN();

  /// Standard error of log_mean, in nats; NaN if relative_sd is NaN.
  double log_error() const { return log_error_of(static_cast<double>(islands)); }
  /// Returns the standard error that log_mean would have if there were `count` estimates. REQUIRES:
  /// count > 0.
  double log_error_of(double count) const;
  /// Whether log_error is valid.
  bool known() const;
};

/// Sums over estimates. The single estimates are not stored.
class IslandSums {
 public:
  /// Adds an estimate, given by its log. The log of 0 is -infinity. NaN or +infinity makes all
  /// results NaN.
  void add(double log_estimate);
  IslandOdds odds() const;

 private:
  static constexpr double k_log_zero = -std::numeric_limits<double>::infinity();

  std::uint64_t islands_ = 0;
  double greatest_ = k_log_zero;
  double sum_ = 0;      ///< Sum of exp(x - greatest).
  double squares_ = 0;  ///< Sum of exp(x - greatest)^2.
  bool is_void_ = false;
};

IslandOdds island_odds(std::span<const double> log_estimates);

}  // namespace sleight::math
