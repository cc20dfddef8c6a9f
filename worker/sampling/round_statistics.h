// What one round of a ladder says: how often neighbours swapped, how the constraint's density lay
// at each level, and from that log Z and the probability of a throw that satisfies.
//
// With l = log p_c and E_beta the mean at inverse temperature beta (Xie et al. 2011, stepping
// stones):
//
//   log Z = sum over levels of log E_{beta_i}[exp((beta_{i+1} - beta_i) l)]
//   log P(satisfied) = log Z + log E_1[1{satisfied} / p_c]
//
// Error bars are a jackknife's: the round is cut into k_batches parts of equal length, and each is
// left out in turn. That counts what replicas have in common and how slowly they move, as long as a
// part is longer than they remember.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/sampling/log_sum.h"

namespace sleight::sampling {

inline constexpr std::size_t k_batches = 20;

/// A number and its standard error; the error is NaN where the round is too short to say.
struct Estimate {
  double value = 0;
  double error = 0;
};

/// Of one level in one scan.
struct LevelScan {
  double log_constraint = 0;
  bool satisfied = false;
};

class RoundStatistics {
 public:
  /// Of so many scans to come.
  RoundStatistics(std::vector<double> ladder, std::uint64_t scans);

  /// The next scan, all levels from the hottest on.
  void add(std::span<const LevelScan> levels);

  const std::vector<double>& ladder() const { return ladder_; }
  std::uint64_t scans() const { return scans_; }
  /// With those to come.
  std::uint64_t scans_wanted() const { return scans_wanted_; }
  /// Between each level and the next: the mean of 1 - min(1, swap ratio). NaN before the first
  /// scan.
  std::vector<double> rejections() const;
  Estimate log_z() const;
  /// log Z_{i+1} - log Z_i: what log_z sums up.
  std::vector<double> log_z_steps() const;
  /// -infinity, without an error, where nothing satisfied.
  Estimate log_satisfied() const;

 private:
  struct Batch {
    std::vector<LogSum> steps;  ///< by level: of exp((beta_{i+1} - beta_i) l)
    LogSum inverse;             ///< of 1{satisfied} / p_c at the coolest
  };
  /// Of all batches but one; of all if it is none.
  double log_z_without(std::size_t left_out) const;
  template <class Value>
  Estimate jackknife(const Value& value) const;

  std::vector<double> ladder_;
  std::uint64_t scans_wanted_;
  std::uint64_t scans_ = 0;
  std::vector<double> rejected_;  ///< sums
  std::array<Batch, k_batches> batches_;
};

}  // namespace sleight::sampling
