// Statistics of a ladder's round: swap rejection rates, log Z, and the probability P(satisfied)
// that a throw satisfies the constraint.
//
// Stepping stones (Xie et al. 2011). Let l = log p_c, and let E_beta be the mean at beta:
//
//   log Z = sum over levels of log E_{beta_i}[exp((beta_{i+1} - beta_i) l)]
//   log P(satisfied) = log Z + log E_1[1{satisfied} / p_c].
//
// Errors are jackknife errors over k_batches equal parts of the round. These errors include
// correlations between replicas and over time if a part is longer than the correlation time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/sampling/log_sum.h"

namespace sleight::sampling {

inline constexpr std::size_t k_batches = 20;

/// A number and its standard error. If the round is too short for an error, the error is NaN.
struct Estimate {
  double value = 0;
  double error = 0;
};

struct LevelScan {
  double log_constraint = 0;
  bool satisfied = false;
};

class RoundStatistics {
 public:
  RoundStatistics(std::vector<double> ladder, std::uint64_t scans);

  /// Adds the next scan. `levels` starts with the hottest level.
  void add(std::span<const LevelScan> levels);

  const std::vector<double>& ladder() const { return ladder_; }
  std::uint64_t scans() const { return scans_; }
  /// Length of the round, including scans to come.
  std::uint64_t scans_wanted() const { return scans_wanted_; }
  /// The mean of 1 - min(1, swap ratio) between each level and the next. NaN before the first scan.
  std::vector<double> rejections() const;
  Estimate log_z() const;
  /// log Z_{i+1} - log Z_i, whose sum is log_z.
  std::vector<double> log_z_steps() const;
  /// If no state is satisfied, the value is -infinity and the error is NaN.
  Estimate log_satisfied() const;

 private:
  struct Batch {
    std::vector<LogSum> steps;  ///< Sums of exp((beta_{i+1} - beta_i) l) by level.
    LogSum inverse;             ///< Sum of 1{satisfied} / p_c at the coolest level.
  };
  /// Estimates log Z without batch `left_out`. If `left_out` is k_batches, all batches count.
  double log_z_without(std::size_t left_out) const;
  template <class Value>
  Estimate jackknife(const Value& value) const;

  std::vector<double> ladder_;
  std::uint64_t scans_wanted_;
  std::uint64_t scans_ = 0;
  std::vector<double> rejected_;  ///< Sums of rejection probabilities, by gap.
  std::array<Batch, k_batches> batches_;
};

}  // namespace sleight::sampling
