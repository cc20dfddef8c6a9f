#include "worker/sampling/diagnostics/standard_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/sampling/diagnostics/beta_quantile.h"
#include "worker/sampling/diagnostics/effective_sample_size.h"
#include "worker/sampling/diagnostics/transforms.h"

namespace sleight::sampling {

double mcse_mean(const Chains& draws) {
  return std::sqrt(variance_of(draws.values)) / std::sqrt(ess_mean(draws));
}

double mcse_sd(const Chains& draws) {
  check_shape(draws);
  const double mean = mean_of(draws.values);
  std::vector<double> squares;
  std::vector<double> fourth_powers;
  for (const double value : draws.values) {
    const double square = (value - mean) * (value - mean);
    squares.push_back(square);
    fourth_powers.push_back(square * square);
  }
  const double effective =
      ess_mean({.values = squares, .chains = draws.chains, .draws = draws.draws});
  const double variance = mean_of(squares);
  const double variance_of_variance = (mean_of(fourth_powers) - variance * variance) / effective;
  return std::sqrt(variance_of_variance / variance / 4);
}

double mcse_quantile(const Chains& draws, double probability) {
  const double effective = ess_quantile(draws, probability);
  if (std::isnan(effective)) return effective;
  const Beta open{.a = effective * probability + 1, .b = effective * (1 - probability) + 1};
  const auto count = static_cast<double>(draws.values.size());
  const double low = std::max(std::floor(beta_quantile(open, 0.1586553) * count), 1.0);
  const double high = std::min(std::ceil(beta_quantile(open, 0.8413447) * count), count);

  std::vector<double> sorted(draws.values.begin(), draws.values.end());
  std::sort(sorted.begin(), sorted.end());
  const auto draw_at = [&](double rank) { return sorted[static_cast<std::size_t>(rank) - 1]; };
  return (draw_at(high) - draw_at(low)) / 2;
}

}  // namespace sleight::sampling
