// Tests that Metropolis-Hastings leaves p_w p_c^beta invariant, and that the test rejects wrong
// kernels.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "tests/statistical/support/ball_fixture.h"
#include "tests/statistical/support/broken_kernels.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/support/property.h"

namespace sleight::statistical::invariance_test {

constexpr std::uint64_t k_seed = 415926;

/// With this number of draws, the test detects each of the known bugs.
constexpr std::size_t k_draws_that_tell = 8000;

using Columns = std::array<std::vector<double>, k_ball_functions>;

void append(Columns& columns, const BallSample& sample) {
  const auto values = ball_functions(sample);
  for (std::size_t i = 0; i < values.size(); ++i)
    columns[i].push_back(values[i]);
}

/// Moves `size` exact draws by `steps` iterations, and compares them with `size` fresh exact draws.
/// Returns the p-value of each function. `repeat` selects the random numbers.
std::array<double, k_ball_functions> p_values(Bug bug, double beta, std::uint64_t steps,
                                              std::size_t size, std::uint32_t repeat) {
  const Ball ball{worlds::ball_2d::Parameters{}};
  Columns moved;
  Columns fresh;
  for (std::size_t i = 0; i < size; ++i) {
    const auto chain = static_cast<std::uint32_t>(2 * (repeat * size + i));
    random::Stream start = streams_of(k_seed, chain).at(random::Purpose::prior, 0);
    BallSample sample = exact_draw(ball, beta, start);
    for (std::uint64_t iteration = 1; iteration <= steps; ++iteration) {
      step(ball, bug, beta, streams_of(k_seed, chain), iteration, sample);
    }
    append(moved, sample);
    random::Stream other = streams_of(k_seed, chain + 1).at(random::Purpose::prior, 0);
    append(fresh, exact_draw(ball, beta, other));
  }
  std::array<double, k_ball_functions> p{};
  for (std::size_t i = 0; i < p.size(); ++i)
    p[i] = kolmogorov_smirnov_p(moved[i], fresh[i]);
  return p;
}

class Invariance : public testing::TestWithParam<std::tuple<double, std::uint64_t>> {};

TEST_P(Invariance, ExactDrawsStayExact) {
  // Goal: the Metropolis-Hastings kernel leaves its target invariant. Method: make exact draws by
  // rejection and move them with the kernel. Compare 8 functions of the moved draws with those of
  // fresh exact draws. The test fails if a p-value is below 1e-5 / 8. By chance, this happens once
  // in 10^5 runs.
  const auto [beta, steps] = GetParam();
  const auto p = p_values(Bug::none, beta, steps, property::of_tier(k_draws_that_tell, 30000), 0);
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_GT(p[i], 1e-5 / k_ball_functions) << k_ball_function_names[i] << ", seed " << k_seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Betas, Invariance,
                         testing::Combine(testing::Values(0.0, 0.2, 1.0),
                                          testing::Values(std::uint64_t{1}, std::uint64_t{10},
                                                          std::uint64_t{100})));

TEST(InvarianceRepeats, PValuesAreUniform) {
  // Goal: the kernel has no bias, even below what a single invariance test detects. Method: repeat
  // the invariance test 400 times, with 300 draws each time. Compare each function's p-values with
  // the uniform distribution. The test fails by chance with probability 8e-5.
  std::array<std::vector<double>, k_ball_functions> collected;
  for (std::uint32_t repeat = 1; repeat <= 400; ++repeat) {
    const auto p = p_values(Bug::none, 1.0, 10, 300, repeat);
    for (std::size_t i = 0; i < p.size(); ++i)
      collected[i].push_back(p[i]);
  }
  for (std::size_t i = 0; i < k_ball_functions; ++i) {
    EXPECT_GT(uniformity_p(collected[i]), 1e-5) << k_ball_function_names[i] << ", seed " << k_seed;
  }
}

class BrokenKernel : public testing::TestWithParam<Bug> {};

TEST_P(BrokenKernel, IsCaught) {
  // Goal: the invariance test rejects each known wrong kernel. The fast tier's few draws suffice.
  // Method: move exact draws by 100 steps of a wrong kernel. At least one p-value must be below the
  // test's threshold.
  const auto p = p_values(GetParam(), 1.0, 100, k_draws_that_tell, 0);
  EXPECT_LT(*std::min_element(p.begin(), p.end()), 1e-5 / k_ball_functions) << name_of(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Bugs, BrokenKernel, testing::ValuesIn(k_bugs), [](const auto& instance) {
  std::string name = name_of(instance.param);
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
});

}  // namespace sleight::statistical::invariance_test
