#include "tests/statistical/support/rank_tests.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sleight::statistical {
namespace {

/// Returns the tail of Kolmogorov's distribution at sqrt(n) d. Corrects for small n.
double kolmogorov_tail(double d, double n) {
  const double root = std::sqrt(n);
  const double x = d * (root + 0.12 + 0.11 / root);
  if (x < 0.2) return 1;
  double sum = 0;
  for (int k = 1; k <= 100; ++k) {
    const double term = std::exp(-2.0 * k * k * x * x);
    sum += k % 2 == 1 ? term : -term;
    if (term < 1e-18) break;
  }
  return std::clamp(2 * sum, 0.0, 1.0);
}

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double autocovariance(std::span<const double> series, double mean, std::size_t lag) {
  double sum = 0;
  for (std::size_t i = lag; i < series.size(); ++i) {
    sum += (series[i] - mean) * (series[i - lag] - mean);
  }
  return sum / static_cast<double>(series.size());
}

}  // namespace

double kolmogorov_smirnov_p(std::span<const double> a, std::span<const double> b) {
  std::vector<double> left(a.begin(), a.end());
  std::vector<double> right(b.begin(), b.end());
  std::sort(left.begin(), left.end());
  std::sort(right.begin(), right.end());
  const auto n = static_cast<double>(left.size());
  const auto m = static_cast<double>(right.size());
  double largest = 0;
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < left.size() && j < right.size()) {
    const double x = std::min(left[i], right[j]);
    while (i < left.size() && left[i] == x)
      ++i;
    while (j < right.size() && right[j] == x)
      ++j;
    largest = std::max(largest, std::abs(static_cast<double>(i) / n - static_cast<double>(j) / m));
  }
  return kolmogorov_tail(largest, n * m / (n + m));
}

double uniformity_p(std::span<const double> values) {
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const auto n = static_cast<double>(sorted.size());
  double largest = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    largest = std::max({largest, static_cast<double>(i + 1) / n - sorted[i],
                        sorted[i] - static_cast<double>(i) / n});
  }
  return kolmogorov_tail(largest, n);
}

double effective_sample_size(std::span<const double> series) {
  const double mean = mean_of(series);
  const double variance = autocovariance(series, mean, 0);
  if (variance == 0) return 1;
  // If a chain is reversible, sums of neighbouring autocovariances are positive and decrease.
  double sum = 0;
  double pair_before = 2 * variance;
  for (std::size_t lag = 0; lag + 1 < series.size() / 2; lag += 2) {
    const double pair = std::min(
        pair_before, autocovariance(series, mean, lag) + autocovariance(series, mean, lag + 1));
    if (pair <= 0) break;
    sum += pair;
    pair_before = pair;
  }
  const double integrated_time = std::max((2 * sum - variance) / variance, 1e-3);
  return static_cast<double>(series.size()) / integrated_time;
}

MeanWithError mean_of_chains(std::span<const std::vector<double>> chains) {
  MeanWithError total;
  double variance_of_sum = 0;
  for (const std::vector<double>& chain : chains) {
    const double mean = mean_of(chain);
    total.mean += mean;
    variance_of_sum += autocovariance(chain, mean, 0) / effective_sample_size(chain);
  }
  const auto count = static_cast<double>(chains.size());
  return {.mean = total.mean / count, .standard_error = std::sqrt(variance_of_sum) / count};
}

MeanWithError mean_over_independent_chains(std::span<const std::vector<double>> chains) {
  std::vector<double> means;
  for (const std::vector<double>& chain : chains)
    means.push_back(mean_of(chain));
  return mean_of_independent(means);
}

MeanWithError mean_of_independent(std::span<const double> draws) {
  const double mean = mean_of(draws);
  return {.mean = mean,
          .standard_error =
              std::sqrt(autocovariance(draws, mean, 0) / static_cast<double>(draws.size()))};
}

}  // namespace sleight::statistical
