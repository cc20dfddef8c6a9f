#include "service/core/block_size.h"

#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "tests/support/property.h"

namespace sleight::core::block_size_test {

constexpr std::uint64_t k_seed = 662607;
constexpr std::uint64_t k_any = 1'000'000;  ///< larger than any block

/// Options with round numbers. A block should take 20 ms. Handling takes 1 ms per thread, and may
/// take half of the time.
constexpr BlockSizeOptions k_round{.target_s = 0.020,
                                   .handling_s = 0.001,
                                   .handling_share = 0.5,
                                   .target_s_max = 1,
                                   .least_s = 0.004,
                                   .scans_max = 8192};

/// Runs blocks until the allowed size is stable. Each block is as large as allowed.
void settle(BlockSize& size, double scan_s, std::uint64_t threads = 1) {
  for (int i = 0; i < 60; ++i) {
    const std::uint32_t scans =
        size.limits({.all = threads, .at_work = threads}, k_any).block_scans_max;
    size.measured(scans, scans, scan_s * scans);
  }
}

TEST(BlockSize, BeginsWithOneScan) {
  // Goal: before any measurement, a block has one scan, whatever the number of threads.
  const BlockSize size(k_round);
  EXPECT_EQ(size.limits({.all = 1, .at_work = 1}, k_any).unit_scans_max, 1U);
  EXPECT_EQ(size.limits({.all = 5000, .at_work = 5000}, k_any).block_scans_max, 1U);
  EXPECT_EQ(size.expected_s(100), 0);
}

TEST(BlockSize, BlocksTakeAboutTheirTarget) {
  // Goal: blocks grow until they take target_s, and a block is at most eight times as large as the
  // block before. Method: measure blocks of scans that take 1 ms each.
  BlockSize size(k_round);
  std::uint32_t before = 1;
  bool grew_eightfold = false;
  for (int i = 0; i < 20; ++i) {
    size.measured(before, before, 0.001 * before);
    const std::uint32_t now = size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max;
    EXPECT_LE(now, 8 * before);
    grew_eightfold |= now == 8 * before;
    before = now;
  }
  EXPECT_TRUE(grew_eightfold);
  EXPECT_NEAR(before, 20, 1);
  EXPECT_NEAR(size.expected_s(before), 0.020, 0.001);
}

TEST(BlockSize, CheapScansComeToTheMostOfABlock) {
  // Goal: blocks of very cheap scans grow to scans_max and no further.
  for (const double scan_s : {1e-9, 0.0}) {
    BlockSize size(k_round);
    settle(size, scan_s);
    EXPECT_EQ(size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max, k_round.scans_max);
    EXPECT_EQ(size.limits({.all = 1, .at_work = 1}, k_any).unit_scans_max, k_round.scans_max);
  }
}

TEST(BlockSize, DearScansComeOneByOne) {
  // Goal: if a scan takes longer than the target, it is a block of its own, even after cheap scans.
  BlockSize size(k_round);
  settle(size, 1e-6);
  EXPECT_GT(size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max, 1000U);
  settle(size, 60);
  EXPECT_EQ(size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max, 1U);
  EXPECT_NEAR(size.expected_s(2), 120, 1);
}

TEST(BlockSize, UnitsAreNoLongerThanTheirReplicaMayGo) {
  // Goal: a replica's maximum number of scans limits its unit, but never a block of several units.
  // A unit may exceed this maximum if a shorter block would overload the coordinator. Method: limit
  // units in blocks of 20 scans. A block takes at least least_s, which is four scans.
  BlockSize size(k_round);
  settle(size, 0.001);
  for (const auto& [may, expected] : {std::pair{0U, 4U}, {1U, 4U}, {7U, 7U}, {500U, 20U}}) {
    const plan::BlockLimits limits = size.limits({.all = 1, .at_work = 1}, may);
    EXPECT_NEAR(limits.unit_scans_max, expected, 1) << may;
    EXPECT_LE(limits.unit_scans_max, std::max(may, 4U));
    EXPECT_NEAR(limits.block_scans_max, 20, 1);
  }
}

TEST(BlockSize, StartsCountUntilMoreIsKnown) {
  // Goal: a chain's start makes no proposal. A start's duration counts as a scan's cost only until
  // real scans are measured. Method: measure three blocks: eight starts, then one start and nine
  // scans, then eight starts that take a minute.
  BlockSize size(k_round);
  size.measured(8, 0, 0.016);
  EXPECT_EQ(size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max, 10U);
  EXPECT_EQ(size.expected_s(1), 0);
  size.measured(10, 9, 0.0009);
  EXPECT_DOUBLE_EQ(size.expected_s(1), 0.0001);
  EXPECT_EQ(size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max, 80U);
  size.measured(8, 0, 60);
  EXPECT_DOUBLE_EQ(size.expected_s(1), 0.0001);
  EXPECT_EQ(size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max, 80U);
}

TEST(BlockSize, ManyThreadsHaveLongerBlocks) {
  // Goal: if there are many threads, blocks are so long that handling one block for each thread
  // takes handling_share of the time. A block takes between target_s and target_s_max.
  const std::vector<std::pair<std::uint64_t, double>> expected{
      {0, 0.020}, {1, 0.020}, {10, 0.020}, {11, 0.022}, {100, 0.2}, {500, 1}, {100'000, 1}};
  for (const auto& [threads, block_s] : expected) {
    BlockSize size(k_round);
    settle(size, 0.0005, threads);
    EXPECT_NEAR(
        size.expected_s(size.limits({.all = threads, .at_work = threads}, k_any).block_scans_max),
        block_s, 0.001)
        << threads;
  }
}

TEST(BlockSize, HungerMakesBlocksShorter) {
  // Goal: while threads find no work, blocks shrink to least_s, or to the shortest duration that
  // the coordinator can handle. Afterwards they grow again. Method: call starved() many times, then
  // fed() many times. Use 1 thread and 8 threads.
  for (const auto& [threads, shortest_s] : {std::pair{1U, 0.004}, {8U, 0.016}}) {
    BlockSize size(k_round);
    settle(size, 0.0001, threads);
    const auto block_s = [&size, threads = threads] {
      return size.expected_s(
          size.limits({.all = threads, .at_work = threads}, k_any).block_scans_max);
    };
    EXPECT_NEAR(block_s(), 0.020, 0.0002);
    double before = block_s();
    for (int i = 0; i < 30; ++i) {
      size.starved();
      EXPECT_LE(block_s(), before);
      before = block_s();
    }
    EXPECT_NEAR(before, shortest_s, 0.0002);
    for (int i = 0; i < 2000; ++i) {
      size.fed();
      EXPECT_GE(block_s(), before);
      before = block_s();
    }
    EXPECT_NEAR(before, 0.020, 0.0002);
  }
}

TEST(BlockSize, AWellFedRunHasNoCredit) {
  // Goal: the first call of starved() makes blocks shorter, even after many calls of fed().
  BlockSize size(k_round);
  settle(size, 0.0001);
  for (int i = 0; i < 10'000; ++i)
    size.fed();
  const std::uint32_t before = size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max;
  size.starved();
  EXPECT_LT(size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max, before);
}

TEST(BlockSize, LongHungerIsForgottenSoon) {
  // Goal: starved() never makes blocks shorter than their minimum. So even after many calls of
  // starved(), calls of fed() soon bring blocks back to their target. Method: call starved() 10,000
  // times, then fed() 170 times. That is enough because 1.01^170 > 0.020 / 0.004.
  BlockSize size(k_round);
  settle(size, 0.0001);
  for (int i = 0; i < 10'000; ++i)
    size.starved();
  EXPECT_NEAR(size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max, 40, 1);
  for (int i = 0; i < 170; ++i)
    size.fed();
  EXPECT_NEAR(size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max, 200, 1);
}

TEST(BlockSize, StrangeCostsDoNoHarm) {
  // Goal: whatever costs are reported, block sizes stay within their bounds, and wrong costs are
  // forgotten. Method: report random costs. Some costs are invalid and must change nothing. Then
  // report correct costs.
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> costs{std::numeric_limits<double>::quiet_NaN(),
                                  -1,
                                  infinity,
                                  -infinity,
                                  0,
                                  -0.0,
                                  std::numeric_limits<double>::max(),
                                  std::numeric_limits<double>::denorm_min(),
                                  1e300,
                                  1e-300,
                                  0.01};
  random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, 0);
  const auto below = [&](std::uint64_t count) {
    return random::UniformInteger{.count = count}.draw(stream);
  };
  BlockSize size(k_round);
  for ([[maybe_unused]] const std::uint64_t step : property::in_turn(20'000)) {
    const std::uint64_t threads = below(2000);
    const std::uint64_t scans = 1 + below(k_round.scans_max);
    const double cost_s = costs[below(costs.size())];
    const double expected_s = size.expected_s(1);
    size.measured(scans, below(scans + 1), cost_s);
    if (!(cost_s >= 0 && cost_s < infinity)) {
      EXPECT_EQ(size.expected_s(1), expected_s);
    }
    if (below(3) == 0) size.starved();
    if (below(3) == 0) size.fed();
    const plan::BlockLimits limits =
        size.limits({.all = threads, .at_work = threads}, below(10'000));
    ASSERT_GE(limits.unit_scans_max, 1U);
    ASSERT_LE(limits.unit_scans_max, limits.block_scans_max);
    ASSERT_LE(limits.block_scans_max, k_round.scans_max);
    ASSERT_GE(size.expected_s(1), 0);
  }
  for (int i = 0; i < 5000; ++i) {
    size.fed();
    size.measured(20, 20, 0.020);
  }
  EXPECT_NEAR(size.limits({.all = 1, .at_work = 1}, k_any).block_scans_max, 20, 1);
}

}  // namespace sleight::core::block_size_test
