// Log weights of an island's particles, and the resulting estimate of Z:
//
//   log Z = sum of log(mean weight) over resamplings + log(current mean weight).
//
// Dead particles count in the mean with weight 0. A value type.
#pragma once

#include <cstddef>
#include <vector>

#include "worker/sampling/log_sum.h"

namespace sleight::sampling {

class IslandWeights {
 public:
  /// All weights are 1. REQUIRES: at least one particle.
  explicit IslandWeights(std::size_t particles);

  bool is_dead(std::size_t particle) const { return log_weights_[particle] == k_log_zero; }
  void kill(std::size_t particle) { log_weights_[particle] = k_log_zero; }
  /// Multiplies a weight by exp(log_factor). REQUIRES: finite.
  void add(std::size_t particle, double log_factor) { log_weights_[particle] += log_factor; }
  void copy(std::size_t from, std::size_t to) { log_weights_[to] = log_weights_[from]; }
  double log_weight(std::size_t particle) const { return log_weights_[particle]; }
  bool all_dead() const;

  /// Returns the normalised weights. REQUIRES: at least one live particle.
  std::vector<double> shares() const;
  /// After resampling: multiplies Z by the mean weight and sets all weights to 1. REQUIRES: at
  /// least one particle was live.
  void start_again();
  /// Like start_again(), but multiplies Z by exp(log_factor).
  void start_again(double log_factor);

  double log_mean() const;
  double log_z() const { return log_z_before_ + log_mean(); }
  /// Log of Z's factors from the resamplings so far, without the current weights.
  double log_z_before() const { return log_z_before_; }

 private:
  std::vector<double> log_weights_;
  double log_z_before_ = 0;
};

}  // namespace sleight::sampling
