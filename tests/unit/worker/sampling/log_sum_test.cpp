#include "worker/sampling/log_sum.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/random/stream.h"
#include "tests/support/property.h"

namespace sleight::sampling::log_sum_test {

constexpr std::uint64_t k_seed = 577215;

TEST(LogSum, IsNothingAtFirst) {
  // Goal: an empty sum is 0, and its mean is NaN. Each added zero counts as a number.
  LogSum sum;
  EXPECT_EQ(sum.log_sum(), k_log_zero);
  EXPECT_TRUE(std::isnan(sum.log_mean()));
  sum.add(k_log_zero);
  EXPECT_EQ(sum.count(), 1U);
  EXPECT_EQ(sum.log_sum(), k_log_zero);
  EXPECT_EQ(sum.log_mean(), k_log_zero);
  sum.add(std::log(6.0));
  sum.add(k_log_zero);
  EXPECT_EQ(sum.count(), 3U);
  EXPECT_NEAR(sum.log_mean(), std::log(2.0), 1e-15);
}

TEST(LogSum, EqualsASumInWiderArithmetic) {
  // Goal: LogSum adds numbers of all sizes correctly in any order, including zeros. Method: add
  // random numbers in the range of a long double. Compare with a plain sum of long doubles. The
  // tolerance allows for 1000 rounding errors of 1e-16.
  for (const std::uint64_t index : property::cases(50)) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, index);
    const double range = index % 2 == 0 ? 3 : 5000;
    LogSum sum;
    long double plain = 0;
    for (int i = 0; i < 1000; ++i) {
      const double x = stream.uniform() < 0.1 ? k_log_zero : range * (stream.uniform() - 0.5);
      sum.add(x);
      plain += std::exp(static_cast<long double>(x));
    }
    EXPECT_EQ(sum.count(), 1000U);
    EXPECT_NEAR(sum.log_sum(), static_cast<double>(std::log(plain)), 1e-12);
    EXPECT_NEAR(sum.log_mean(), static_cast<double>(std::log(plain / 1000)), 1e-12);
  }
}

TEST(LogSum, HoldsWhatNoDoubleHolds) {
  // Goal: LogSum adds numbers that are far beyond exp's range, in rising and in falling order.
  // Method: in two orders, add two numbers with the log 1e6 and two numbers with the log -1e6. The
  // two larger numbers determine the sum.
  for (const double first : {-1e6, 1e6}) {
    LogSum sum;
    sum.add(first);
    sum.add(-first);
    sum.add(-first);
    sum.add(first);
    EXPECT_NEAR(sum.log_sum(), 1e6 + std::log(2.0), 1e-9);
  }
}

TEST(LogSum, AddsSums) {
  // Goal: the sums of parts add up to the whole sum. Method: use four parts. One part contains only
  // zeros, and one part is empty.
  random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, 1000);
  LogSum whole;
  LogSum parts[4];
  for (int i = 0; i < 300; ++i) {
    const double x = i % 3 == 2 ? k_log_zero : 2000 * (stream.uniform() - 0.5);
    whole.add(x);
    parts[i % 3].add(x);
  }
  LogSum sum;
  for (const LogSum& part : parts)
    sum.add(part);
  EXPECT_EQ(sum.count(), whole.count());
  EXPECT_NEAR(sum.log_sum(), whole.log_sum(), 1e-12);
}

}  // namespace sleight::sampling::log_sum_test
