// Goal: the discrete distributions draw with their exact probabilities. Method: test draws with
// chi-square tests. In some ranges, scaling a random word would be biased. Test extreme and invalid
// parameters.
#include "common/random/discrete_distributions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/numbers.h"
#include "tests/unit/common/random/chi_square.h"

namespace sleight::random {
namespace {

TEST(Bernoulli, is_true_with_its_probability) {
  for (const double p : {0.5, 0.3, 0.001, 0.9999}) {
    Stream stream = test_stream();
    std::vector<int> counts(2);
    for (int i = 0; i < k_draws; ++i)
      ++counts[Bernoulli{p}.draw(stream) ? 1 : 0];
    // If both counts equal their expected values, p is 1, so only the lower bound is checked.
    EXPECT_GT(chi_square_p_value(counts, {1 - p, p}), k_p_min) << p << ", seed " << k_test_seed;
    EXPECT_NEAR(Bernoulli{p}.log_density(true), std::log(p), 1e-15);
    EXPECT_NEAR(Bernoulli{p}.log_density(false), std::log1p(-p), 1e-15 * (1 - std::log1p(-p)));
  }
}

TEST(Bernoulli, is_certain_at_the_ends) {
  Stream stream = test_stream();
  for (int i = 0; i < 10000; ++i) {
    ASSERT_FALSE(Bernoulli{0}.draw(stream));
    ASSERT_TRUE(Bernoulli{1}.draw(stream));
  }
  EXPECT_EQ(Bernoulli{0}.log_density(true), -k_infinity);
  EXPECT_EQ(Bernoulli{0}.log_density(false), 0);
  EXPECT_EQ(Bernoulli{1}.log_density(true), 0);
  EXPECT_EQ(Bernoulli{1}.log_density(false), -k_infinity);
}

TEST(UniformInteger, draws_every_value_as_often) {
  for (const std::uint64_t count : {2, 3, 10, 64, 1000}) {
    const UniformInteger d{count};
    Stream stream = test_stream();
    std::vector<int> counts(count);
    for (int i = 0; i < k_draws; ++i)
      ++counts.at(d.draw(stream));
    expect_plausible(chi_square_p_value(counts), "count " + std::to_string(count));
    EXPECT_NEAR(d.log_density(count - 1), -std::log(static_cast<double>(count)), 1e-15 * 8);
    EXPECT_EQ(d.log_density(count), -k_infinity);
  }
}

TEST(UniformInteger, is_unbiased_where_scaling_a_word_is_not) {
  // If 2^64 words were scaled to 3 * 2^62 values, every third value would be drawn twice as often
  // as the other values.
  constexpr std::uint64_t k_count = std::uint64_t{3} << 62;
  const UniformInteger d{k_count};
  Stream stream = test_stream();
  std::vector<int> remainders(3);
  std::vector<int> sizes(64);
  for (int i = 0; i < k_draws; ++i) {
    const std::uint64_t x = d.draw(stream);
    ASSERT_LT(x, k_count);
    ++remainders[x % 3];
    ++sizes[x / (k_count / 64)];
  }
  expect_plausible(chi_square_p_value(remainders), "remainder by 3");
  expect_plausible(chi_square_p_value(sizes), "size");

  // Negative control: scale words without rejecting any.
  __extension__ using Wide = unsigned __int128;
  std::vector<int> biased(3);
  for (int i = 0; i < k_draws; ++i) {
    ++biased[static_cast<std::uint64_t>(Wide{stream.bits()} * k_count >> 64) % 3];
  }
  EXPECT_LT(chi_square_p_value(biased), 1e-12);
}

TEST(UniformInteger, handles_the_largest_and_smallest_counts) {
  Stream stream = test_stream();
  for (const std::uint64_t count : {~0ULL, (1ULL << 63) + 1, 1ULL << 63}) {
    std::vector<int> sizes(16);
    for (int i = 0; i < k_draws; ++i) {
      const std::uint64_t x = UniformInteger{count}.draw(stream);
      ASSERT_LT(x, count);
      // Each cell has at least 2^59 values. The last cell has at most 15 values more than the other
      // cells.
      ++sizes[std::min<std::uint64_t>(15, x / (count / 16))];
    }
    expect_plausible(chi_square_p_value(sizes), "count " + std::to_string(count));
  }
  for (int i = 0; i < 100; ++i)
    ASSERT_EQ(UniformInteger{1}.draw(stream), 0U);
  EXPECT_EQ(UniformInteger{1}.log_density(0), 0);
}

TEST(DrawByShare, draws_each_by_its_share) {
  // Goal: an index's probability is its share divided by the sum of shares, whatever the sum. If an
  // index's share is zero, the index is never drawn, even if it is the last. Method: test the
  // positive shares with a chi-square test. Count the draws whose share is zero.
  for (const double total : {1.0, 1e-300, 7e100}) {
    const std::vector<double> shares{0, 0.5 * total, 0, 0.125 * total, 0.375 * total, 0};
    Stream stream = test_stream();
    std::vector<int> counts(shares.size());
    for (int i = 0; i < k_draws; ++i)
      ++counts.at(draw_by_share(shares, stream));
    EXPECT_EQ(counts[0] + counts[2] + counts[5], 0);
    expect_plausible(chi_square_p_value({counts[1], counts[3], counts[4]}, {0.5, 0.125, 0.375}),
                     "total " + std::to_string(total));
  }
}

TEST(DiscreteDistributionsDeathTest, refuse_what_is_no_distribution) {
  Stream stream = test_stream();
  EXPECT_DEATH(Bernoulli{-0.1}.draw(stream), "check failed");
  EXPECT_DEATH(Bernoulli{1.1}.log_density(true), "check failed");
  EXPECT_DEATH(Bernoulli{std::numeric_limits<double>::quiet_NaN()}.draw(stream), "check failed");
  EXPECT_DEATH(UniformInteger{0}.draw(stream), "check failed");
}

}  // namespace
}  // namespace sleight::random
