#include "worker/sampling/diagnostics/r_hat.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/sampling/diagnostics/transforms.h"

namespace sleight::sampling {
namespace {

/// Returns the variance about a given mean. The divisor is n - 1. NaN for a single draw.
double variance_about(double mean, std::span<const double> draws) {
  if (draws.size() == 1) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  for (const double draw : draws)
    sum += (draw - mean) * (draw - mean);
  return sum / static_cast<double>(draws.size() - 1);
}

double potential_scale_reduction(const OwnedChains& owned) {
  const Chains draws = owned.view();
  if (is_degenerate(draws.values)) return std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> means = chain_means(draws);
  std::vector<double> variances;
  for (std::size_t c = 0; c < draws.chains; ++c)
    variances.push_back(variance_about(means[c], draws.chain(c)));
  const auto length = static_cast<double>(draws.draws);
  const double between = length * variance_of(means);
  const double within = mean_of(variances);
  return std::sqrt((between / within + length - 1) / length);
}

}  // namespace

double r_hat_bulk(const Chains& draws) {
  return potential_scale_reduction(normal_scores(split_in_halves(draws).view()));
}

double r_hat_tail(const Chains& draws) {
  const OwnedChains distances = folded(draws);
  return potential_scale_reduction(normal_scores(split_in_halves(distances.view()).view()));
}

double r_hat(const Chains& draws) {
  const double bulk = r_hat_bulk(draws);
  const double tail = r_hat_tail(draws);
  return std::isnan(bulk) || std::isnan(tail) ? bulk + tail : std::max(bulk, tail);
}

}  // namespace sleight::sampling
