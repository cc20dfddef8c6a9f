#include "worker/sampling/diagnostics/effective_sample_size.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/elementary.h"
#include "worker/sampling/diagnostics/autocovariance.h"
#include "worker/sampling/diagnostics/transforms.h"

namespace sleight::sampling {
namespace {

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t k_draws_min = 3;
// If the sum of two autocorrelations is below this limit, it counts as 0: its error is some 1e-15.
constexpr double k_zero_pair = 1e-12;

/// Autocorrelations by lag. The lags form pairs (0, 1), (2, 3), ...; `end` is the first omitted
/// lag.
struct Autocorrelations {
  std::vector<double> at_lag;
  std::size_t end = 0;  ///< Even. at_lag[end] has half a pair: 0 unless positive.
};

/// Geyer's initial positive sequence: take pairs as long as their sums are positive.
template <class AtLag>
Autocorrelations positive_pairs(const AtLag& rho, std::size_t draws) {
  Autocorrelations kept{.at_lag = std::vector<double>(draws, 0.0)};
  kept.at_lag[0] = 1;
  kept.at_lag[1] = rho(1);
  double even = 1;
  double pair = even + kept.at_lag[1];
  // Omit the last lags, which have few products.
  while (kept.end + 5 < draws && pair > k_zero_pair) {
    kept.end += 2;
    even = rho(kept.end);
    const double odd = rho(kept.end + 1);
    pair = even + odd;
    if (pair >= -k_zero_pair) {
      kept.at_lag[kept.end] = even;
      kept.at_lag[kept.end + 1] = odd;
    }
  }
  if (even > 0) kept.at_lag[kept.end] = even;
  return kept;
}

/// Geyer's initial monotone sequence: no pair's sum exceeds the previous pair's sum.
void make_monotone(Autocorrelations& kept) {
  std::vector<double>& rho = kept.at_lag;
  for (std::size_t t = 2; t + 2 <= kept.end; t += 2) {
    const double before = rho[t - 2] + rho[t - 1];
    if (rho[t] + rho[t + 1] > before) rho[t] = rho[t + 1] = before / 2;
  }
}

double effective_sample_size(const OwnedChains& owned) {
  const Chains draws = owned.view();
  if (draws.draws < k_draws_min || is_degenerate(draws.values)) return k_nan;

  // Estimate the variance of the target, and from it the autocorrelation at each lag.
  const std::vector<double> autocovariances = mean_autocovariances(draws);
  const auto length = static_cast<double>(draws.draws);
  const double within = autocovariances[0] * length / (length - 1);
  double variance = autocovariances[0];
  if (draws.chains > 1) variance += variance_of(chain_means(draws));
  if (!std::isfinite(variance) || variance == 0) return k_nan;
  const auto rho = [&](std::size_t lag) { return 1 - (within - autocovariances[lag]) / variance; };

  // Sum the autocorrelations up to where noise dominates.
  Autocorrelations kept = positive_pairs(rho, draws.draws);
  make_monotone(kept);
  double sum = kept.at_lag[0];  // posterior counts lag 0 even if no pair is used.
  for (std::size_t t = 1; t < kept.end; ++t)
    sum += kept.at_lag[t];
  const double tau = -1 + 2 * sum + kept.at_lag[kept.end];

  // Limit the effective sample size of antithetic chains.
  const auto count = static_cast<double>(draws.values.size());
  const double tau_min = math::log(10) / math::log(count);
  return count / std::max(tau, tau_min);
}

}  // namespace

double ess_bulk(const Chains& draws) {
  return effective_sample_size(normal_scores(split_in_halves(draws).view()));
}

double ess_tail(const Chains& draws) {
  const double low = ess_quantile(draws, 0.05);
  const double high = ess_quantile(draws, 0.95);
  return std::isnan(low) || std::isnan(high) ? k_nan : std::min(low, high);
}

double ess_mean(const Chains& draws) {
  return effective_sample_size(split_in_halves(draws));
}

double ess_quantile(const Chains& draws, double probability) {
  check_shape(draws);
  CHECK(probability >= 0 && probability <= 1);
  if (is_degenerate(draws.values)) return k_nan;
  const auto count = static_cast<double>(draws.values.size());
  const double quantile =
      quantile_of(draws.values, probability == 1 ? (count - 0.5) / count : probability);
  std::vector<double> indicators;
  indicators.reserve(draws.values.size());
  for (const double value : draws.values)
    indicators.push_back(value <= quantile ? 1 : 0);
  return ess_mean({.values = indicators, .chains = draws.chains, .draws = draws.draws});
}

double mcse_mean(const Chains& draws) {
  return std::sqrt(variance_of(draws.values)) / std::sqrt(ess_mean(draws));
}

}  // namespace sleight::sampling
