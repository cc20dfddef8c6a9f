// Pearson's chi-square test of draws against exact probabilities.
//
// A test draws k_draws values from a printed seed and counts them in cells. If a distribution is
// continuous, the cells' edges are sample quantiles of a pilot run with another seed. So all cells
// are about equally likely. An oracle computes the cells' probabilities and shares no code with the
// sampler.
//
// Bounds: if a sampler is right, p is uniform on (0, 1). This folder's tests compute fewer than 200
// such p. A test refuses p below k_p_min = 1e-6 and p above 1 - k_p_min. So the chance of refusing
// a right sampler is below 4e-4 when the seeds are first chosen (then they stay fixed). If the mean
// is wrong by a fiftieth of the sd, or the sd by a fiftieth, p is below 1e-12 (see
// chi_square_test.cpp). If p is too near 1, the draws are more regular than chance, as on a grid.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/random/stream.h"
#include "tests/support/numbers.h"

namespace sleight::random {

constexpr int k_draws = 1000000;
constexpr int k_cells = 64;
constexpr double k_p_min = 1e-6;
constexpr std::uint64_t k_test_seed = 19990817;
constexpr std::uint64_t k_pilot_seed = 31415926;

inline Stream test_stream(std::uint64_t seed = k_test_seed) {
  return Stream({.seed = seed, .purpose = Purpose::prior}, 0);
}

/// Returns the probability that a right sampler's counts deviate at least as much as `counts`.
/// REQUIRES: there are as many probabilities as counts; they add up to 1; each expected count is at
/// least 10.
inline double chi_square_p_value(const std::vector<int>& counts,
                                 const std::vector<double>& probabilities) {
  double total = 0;
  for (const int count : counts)
    total += count;
  double statistic = 0;
  double mass = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double expected = total * probabilities.at(i);
    EXPECT_GE(expected, 10) << "cell " << i;
    statistic += (counts[i] - expected) * (counts[i] - expected) / expected;
    mass += probabilities[i];
  }
  EXPECT_NEAR(mass, 1, 1e-9);
  const auto freedom = static_cast<double>(counts.size() - 1);
  return boost::math::gamma_q(freedom / 2, statistic / 2);
}

inline double chi_square_p_value(const std::vector<int>& counts) {
  const auto cells = static_cast<double>(counts.size());
  return chi_square_p_value(counts, std::vector<double>(counts.size(), 1 / cells));
}

inline void expect_plausible(double p_value, const std::string& what) {
  EXPECT_GT(p_value, k_p_min) << what << ", seed " << k_test_seed;
  EXPECT_LT(p_value, 1 - k_p_min) << what << ", seed " << k_test_seed;
}

/// Tests draws of a continuous distribution on the line, and returns p. `mass(a, b)` is the
/// oracle's probability of the interval from a to b. The outermost edges are infinite.
inline double p_value_of_draws(const std::function<double(Stream&)>& draw,
                               const std::function<double(double, double)>& mass) {
  Stream pilot_stream = test_stream(k_pilot_seed);
  std::vector<double> pilot(static_cast<std::size_t>(100 * k_cells));
  for (double& x : pilot)
    x = draw(pilot_stream);
  std::sort(pilot.begin(), pilot.end());
  std::vector<double> edges;
  for (std::size_t i = 100; i < pilot.size(); i += 100)
    edges.push_back(pilot[i]);

  // Cell i holds draws with edges[i-1] <= x < edges[i].
  Stream stream = test_stream();
  std::vector<int> counts(edges.size() + 1);
  for (int i = 0; i < k_draws; ++i) {
    const auto above = std::upper_bound(edges.begin(), edges.end(), draw(stream));
    ++counts[static_cast<std::size_t>(above - edges.begin())];
  }

  std::vector<double> probabilities;
  for (std::size_t i = 0; i <= edges.size(); ++i) {
    probabilities.push_back(
        mass(i == 0 ? -k_infinity : edges[i - 1], i == edges.size() ? k_infinity : edges[i]));
  }
  return chi_square_p_value(counts, probabilities);
}

}  // namespace sleight::random
