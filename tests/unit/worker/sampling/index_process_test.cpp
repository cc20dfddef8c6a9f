#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "worker/sampling/index_process.h"

namespace sleight::sampling {
namespace {

TEST(IndexProcess, KeepsWhatTheNumberOfScansSays) {
  // Goal: the process never stores more moments than its bound. After enough scans, the process
  // stores at least half of the bound. Moments are evenly spaced and contain the right levels, for
  // any first scan. Method: after each of 10,000 scans, compare the moments with the scans so far.
  // In every third scan, the two replicas have each other's levels.
  for (const std::uint64_t first : {0U, 1U, 777U}) {
    IndexProcess process;
    std::uint64_t stride = 1;
    for (std::uint64_t scan = first; scan < first + 10'000; ++scan) {
      const std::vector<std::uint32_t> replica =
          scan % 3 == 0 ? std::vector<std::uint32_t>{4, 1} : std::vector<std::uint32_t>{1, 4};
      process.add(scan, replica);
      const std::vector<IndexProcess::Moment>& moments = process.moments();
      ASSERT_LE(moments.size(), IndexProcess::k_moments_max);
      const std::uint64_t added = scan + 1 - first;
      ASSERT_GE(moments.size(), std::min<std::uint64_t>(added, IndexProcess::k_moments_max / 2));
      if (moments.size() > 1) stride = moments[1].scan - moments[0].scan;
      std::uint64_t expected = (first + stride - 1) / stride * stride;
      for (const IndexProcess::Moment& moment : moments) {
        ASSERT_EQ(moment.scan, expected);
        expected += stride;
      }
      ASSERT_GT(expected, scan);
    }
    EXPECT_EQ(stride, 16U);
    EXPECT_GT(process.moments().size(), IndexProcess::k_moments_max / 2);
    for (const IndexProcess::Moment& moment : process.moments()) {
      const std::uint16_t of_four = moment.scan % 3 == 0 ? 0 : 1;
      const std::uint16_t none = IndexProcess::k_no_level;
      EXPECT_EQ(moment.level,
                (std::vector<std::uint16_t>{none, static_cast<std::uint16_t>(1 - of_four), none,
                                            none, of_four}));
    }
  }
}

}  // namespace
}  // namespace sleight::sampling
