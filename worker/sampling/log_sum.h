// Logarithms of sums of exponentials. The sums may exceed the range of double.
#pragma once

#include <cstdint>
#include <limits>

#include "common/math/elementary.h"

namespace sleight::sampling {

inline constexpr double k_log_zero = -std::numeric_limits<double>::infinity();

/// The sum of exp(x) over numbers x, which are added one by one. Equal sequences yield equal bits.
class LogSum {
 public:
  /// REQUIRES: not NaN, not +infinity.
  void add(double log_value) {
    ++count_;
    if (log_value == k_log_zero) return;
    if (log_value <= greatest_) {
      sum_ += math::exp(log_value - greatest_);
      return;
    }
    sum_ = greatest_ == k_log_zero ? 1 : sum_ * math::exp(greatest_ - log_value) + 1;
    greatest_ = log_value;
  }
  void add(const LogSum& other) {
    const std::uint64_t count = count_ + other.count_;
    if (other.sum_ > 0) {
      const double value = other.log_sum();
      add(value);
    }
    count_ = count;
  }
  std::uint64_t count() const { return count_; }
  /// -infinity for an empty sum.
  double log_sum() const { return sum_ > 0 ? greatest_ + math::log(sum_) : k_log_zero; }
  /// Log of the mean; NaN for an empty sum.
  double log_mean() const {
    if (count_ == 0) return std::numeric_limits<double>::quiet_NaN();
    return log_sum() - math::log(static_cast<double>(count_));
  }

 private:
  double greatest_ = k_log_zero;
  double sum_ = 0;  ///< Sum of exp(x - greatest).
  std::uint64_t count_ = 0;
};

}  // namespace sleight::sampling
