#include "worker/sampling/ladder_round.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace sleight::sampling {
namespace {

const double k_grown = std::exp(2.1);  ///< size factor if all proposals are accepted

LadderOptions options_of(bool levels_chosen) {
  return {.seed = 1,
          .chain = {},
          .first_ladder = {0, 0.25, 1},
          .levels_chosen = levels_chosen,
          .levels_max = 64,
          .ladder_adapts = levels_chosen,
          .has_scale = {true, false, true},
          .round_scans = 5,
          .anneal_scans = 7};
}

/// A whole round in which all swaps are accepted, or no swap is accepted. For each of the first two
/// kinds, the three levels accept 0, 100 and 30 of 100 proposals. The third kind accepts none of 49
/// proposals.
RoundReport round_of(const LadderOptions& options, bool swaps) {
  RoundReport round = first_round(options);
  for (std::uint64_t scan = 0; scan < options.round_scans; ++scan) {
    round.statistics.add(std::vector<LevelScan>{{.log_constraint = -1},
                                                {.log_constraint = swaps ? -1 : 1e6},
                                                {.log_constraint = swaps ? -1 : 2e6}});
  }
  const std::uint32_t accepted[3] = {0, 100, 30};
  for (std::size_t level = 0; level < 3; ++level) {
    round.counts[level].add(std::vector<std::uint32_t>{100}, std::vector{accepted[level]});
    round.counts[level].add(std::vector<std::uint32_t>{0, 100, 49},
                            std::vector<std::uint32_t>{0, accepted[level], 0});
  }
  round.round_trips = round.restarts = 3;
  return round;
}

TEST(LadderRound, LearnsSizesLevelByLevel) {
  // Goal: a round multiplies each level's proposal size by exp(3 (acceptance - 0.3)). The hottest
  // level uses its neighbour's factor. Kinds without a size or with few proposals don't change. The
  // next round begins at the previous round's end and is twice as long. It has no counts yet.
  const RoundReport round = round_of(options_of(false), true);
  EXPECT_EQ(round.first_scan, 7U);
  const RoundReport next = next_round(options_of(false), round);
  EXPECT_EQ(next.first_scan, 12U);
  EXPECT_EQ(next.end_scan(), 22U);
  EXPECT_EQ(next.statistics.scans(), 0U);
  EXPECT_EQ(next.round_trips + next.restarts, 0U);
  EXPECT_TRUE(next.counts.at(1).proposed.empty());
  EXPECT_EQ(next.ladder(), round.ladder());
  ASSERT_EQ(next.scales.size(), 3U);
  const double first_kind[3] = {k_grown, k_grown, 1};
  for (std::size_t level = 0; level < 3; ++level) {
    ASSERT_EQ(next.scales[level].size(), 3U);
    EXPECT_NEAR(next.scales[level][0], first_kind[level], 1e-13);
    EXPECT_EQ(next.scales[level][1], 1);
    EXPECT_EQ(next.scales[level][2], 1);
  }
}

TEST(LadderRound, ReadsSizesOffWhereTheNewLevelsAre) {
  // Goal: the number of new levels is twice the barrier plus one, but at least 2. The logarithm of
  // a proposal size is linear between old levels. Method: accept all swaps, so the barrier is 0.
  // Then reject all swaps, so the barrier is 2.
  for (const auto& [swaps, levels] : {std::pair{true, 2U}, {false, 5U}}) {
    const RoundReport next = next_round(options_of(true), round_of(options_of(true), swaps));
    ASSERT_EQ(next.ladder().size(), levels);
    for (std::size_t level = 0; level < levels; ++level) {
      const double beta = next.ladder()[level];
      const double share = beta < 0.25 ? 1 : (1 - beta) / 0.75;
      EXPECT_NEAR(std::log(next.scales[level][0]), 2.1 * share, 1e-12) << beta;
    }
  }
}

TEST(Tuned, StaysWithinBounds) {
  // Goal: tuned() keeps proposal sizes within fixed bounds. Method: tune the sizes of two kinds for
  // a hundred rounds. One kind rejects all proposals, and the other accepts all.
  const KindCounts counts{.proposed = {60, 60}, .accepted = {0, 60}};
  std::vector<double> scales{1, 1};
  for (int round = 0; round < 100; ++round)
    scales = tuned(scales, counts, {true, true});
  EXPECT_EQ(scales, (std::vector{k_scale_min, k_scale_max}));
}

}  // namespace
}  // namespace sleight::sampling
