// Pearson's chi-square test, which compares counts with exact probabilities.
#pragma once

#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace sleight::statistical {

/// Returns the probability that a right sampler's counts deviate as much or more. Merges all cells
/// whose expected count is below 10. Returns 0 if a cell of probability 0 has a count.
inline double chi_square_p(const std::vector<double>& counts,
                           const std::vector<double>& probabilities) {
  double total = 0;
  for (const double count : counts)
    total += count;
  double statistic = 0;
  int cells = 0;
  double rare_count = 0;
  double rare_expected = 0;
  const auto add = [&](double count, double expected) {
    statistic += (count - expected) * (count - expected) / expected;
    ++cells;
  };
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double expected = total * probabilities.at(i);
    if (expected == 0 && counts[i] > 0) return 0;
    if (expected >= 10) {
      add(counts[i], expected);
    } else {
      rare_count += counts[i];
      rare_expected += expected;
    }
  }
  if (rare_expected > 0) add(rare_count, rare_expected);
  return boost::math::gamma_q(0.5 * (cells - 1), 0.5 * statistic);
}

/// Returns the p-value of two samples of counts. The hypothesis is that both have the same
/// distribution (Numerical Recipes, 14.3, for unequal numbers).
inline double two_sample_p(std::span<const double> a, std::span<const double> b) {
  double sum_a = 0;
  double sum_b = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum_a += a[i];
    sum_b += b[i];
  }
  double chi_square = 0;
  int cells = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] + b[i] == 0) continue;
    const double off = std::sqrt(sum_b / sum_a) * a[i] - std::sqrt(sum_a / sum_b) * b[i];
    chi_square += off * off / (a[i] + b[i]);
    ++cells;
  }
  return boost::math::gamma_q(0.5 * (cells - 1), 0.5 * chi_square);
}

}  // namespace sleight::statistical
