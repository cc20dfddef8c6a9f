// How sizes of proposals follow from what was accepted.
#include "worker/sampling/tuning.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sleight::sampling {
namespace {

KindCounts counts_of(std::vector<std::uint64_t> proposed, std::vector<std::uint64_t> accepted) {
  return {.proposed = std::move(proposed), .accepted = std::move(accepted)};
}

TEST(KindCounts, AddUpWhatTheyAreGiven) {
  // Goal: sums by kind, also when scans know more or fewer kinds than before.
  KindCounts counts;
  counts.add({}, {});
  counts.add(std::vector{5U, 1U}, std::vector{2U, 0U});
  counts.add(std::vector{7U}, std::vector{7U});
  counts.add(std::vector{0U, 2U, 9U}, std::vector{0U, 1U, 4U});
  EXPECT_EQ(counts.proposed, (std::vector<std::uint64_t>{12, 3, 9}));
  EXPECT_EQ(counts.accepted, (std::vector<std::uint64_t>{9, 1, 4}));
}

TEST(Tuned, MovesTowardsTheTarget) {
  // Goal: a size grows when more is accepted than wanted, shrinks when less, rests at the target;
  // by exp(3 (rate - 0.3)). Method: by hand, from no sizes (1) and from given ones.
  const KindCounts counts = counts_of({100, 100, 100}, {100, 30, 0});
  const std::vector<bool> all{true, true, true};
  const std::vector<double> from_one = tuned({}, counts, all);
  ASSERT_EQ(from_one.size(), 3U);
  EXPECT_NEAR(from_one[0], std::exp(2.1), 1e-14);
  EXPECT_EQ(from_one[1], 1);
  EXPECT_NEAR(from_one[2], std::exp(-0.9), 1e-14);
  const std::vector<double> on = tuned(std::vector{2.0, 3.0, 4.0}, counts, all);
  EXPECT_NEAR(on[0], 2 * std::exp(2.1), 1e-13);
  EXPECT_EQ(on[1], 3);
  EXPECT_NEAR(on[2], 4 * std::exp(-0.9), 1e-14);
}

TEST(Tuned, LeavesAloneWhatItKnowsNothingOf) {
  // Goal: kinds without a size, kinds hardly proposed, and kinds beyond the list stay.
  const KindCounts counts = counts_of({100, 49, 50, 100}, {0, 0, 0, 0});
  const std::vector<double> next =
      tuned(std::vector{2.0, 2.0, 2.0, 2.0, 2.0}, counts, {false, true, true});
  EXPECT_EQ(next[0], 2);
  EXPECT_EQ(next[1], 2);
  EXPECT_LT(next[2], 2);
  EXPECT_EQ(next[3], 2);
  EXPECT_EQ(next[4], 2);
  EXPECT_TRUE(tuned({}, {}, {true}).empty());
}

TEST(Tuned, StaysWithinBounds) {
  // Goal: no size runs away. Method: all rejected, and all accepted, for a hundred rounds.
  std::vector<double> scales{1, 1};
  for (int round = 0; round < 100; ++round)
    scales = tuned(scales, counts_of({60, 60}, {0, 60}), {true, true});
  EXPECT_EQ(scales, (std::vector{k_scale_min, k_scale_max}));
}

}  // namespace
}  // namespace sleight::sampling
