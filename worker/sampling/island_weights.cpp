#include "worker/sampling/island_weights.h"

#include <algorithm>

#include "common/base/check.h"
#include "common/math/elementary.h"

namespace sleight::sampling {

IslandWeights::IslandWeights(std::size_t particles) : log_weights_(particles, 0.0) {
  CHECK_GE(particles, 1U);
}

bool IslandWeights::all_dead() const {
  return std::ranges::all_of(log_weights_,
                             [](double log_weight) { return log_weight == k_log_zero; });
}

std::vector<double> IslandWeights::shares() const {
  const double greatest = *std::ranges::max_element(log_weights_);
  CHECK_GT(greatest, k_log_zero);
  std::vector<double> shares;
  shares.reserve(log_weights_.size());
  double sum = 0;
  for (const double log_weight : log_weights_)
    sum += shares.emplace_back(log_weight == k_log_zero ? 0 : math::exp(log_weight - greatest));
  for (double& share : shares)
    share /= sum;
  return shares;
}

void IslandWeights::start_again() {
  start_again(log_mean());
}

void IslandWeights::start_again(double log_factor) {
  log_z_before_ += log_factor;
  std::ranges::fill(log_weights_, 0.0);
}

double IslandWeights::log_mean() const {
  LogSum sum;
  for (const double log_weight : log_weights_)
    sum.add(log_weight);
  return sum.log_mean();
}

}  // namespace sleight::sampling
