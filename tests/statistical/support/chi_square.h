// Pearson's chi-square test of counts against exact probabilities of any size.
#pragma once

#include <boost/math/special_functions/gamma.hpp>
#include <cstddef>
#include <vector>

namespace sleight::statistical {

/// The probability that a right sampler deviates as much or more. Cells that are expected fewer
/// than 10 times count as one; a count where the probability is 0 gives 0.
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

}  // namespace sleight::statistical
