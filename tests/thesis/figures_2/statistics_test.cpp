// Goal: the numbers that support the thesis's statements are right. Method: compare the statistics
// of short made-up chains with known values.
#include "tests/thesis/figures_2/statistics.h"

#include <gtest/gtest.h>

namespace sleight::thesis {
namespace {

using worlds::spelling::Kind;

Chain chain_of(const std::vector<std::uint32_t>& filled) {
  Chain chain{.balls = 10, .vertices = 2};
  for (const std::uint32_t k : filled) {
    chain.iterations.push_back({.filled = k,
                                .log_p = 5.0 * k,
                                .log_p_offsets = -4,
                                .kind = Kind::change_ball,
                                .accepted = true});
  }
  return chain;
}

TEST(Statistics, DistinctOrdersDifferInHalf) {
  const std::vector<Order> orders{
      {0, -1, 1, 2, 3}, {1, -1, 0, 2, 3}, {1, -1, 2, 0, 3}, {0, 1, 2, -1, 3}};
  EXPECT_EQ(different_bins(orders[0], orders[1]), 2U);
  EXPECT_EQ(different_bins(orders[1], orders[2]), 2U);
  EXPECT_EQ(distinct_count(orders, 4), 4U);
  EXPECT_EQ(distinct_count(orders, 5), 3U);  // the second is too close to the first
  EXPECT_EQ(distinct_count({}, 4), 0U);
  const auto most = most_different(orders);
  EXPECT_EQ(different_bins(most.first, most.second), 4U);
}

TEST(Statistics, VisitsEndWhenTheSpellingIsLeft) {
  const Statistics none = statistics_of(chain_of({3, 9, 9, 4}));
  EXPECT_FALSE(none.first_correct);
  EXPECT_EQ(none.visits, 0U);
  EXPECT_EQ(none.longest_stay, 0U);
  // There are two visits. During the first visit, a ball is elsewhere for two iterations. The
  // second visit lasts one iteration.
  const Statistics two = statistics_of(chain_of({8, 10, 9, 8, 10, 10, 7, 10}));
  EXPECT_EQ(two.first_correct, 1U);
  EXPECT_EQ(two.visits, 2U);
  EXPECT_EQ(two.stays, 3U);
  EXPECT_EQ(two.longest_stay, 2U);
  EXPECT_EQ(two.correct_share, 0.5);
  EXPECT_EQ(two.log_p_offsets, -2);
}

TEST(Statistics, TheChangeAllEffectFallsInKAndRisesInLogP) {
  Chain chain = chain_of({10, 7, 10, 8, 10, 6});
  for (Iteration& iteration : chain.iterations)
    iteration.kind = Kind::change_all;
  chain.iterations[1].log_p = 51;
  chain.iterations[1].log_p_offsets = 26;
  chain.iterations[3].log_p = 51;  // a drop of two balls is not sharp
  Statistics statistics = statistics_of(chain);
  EXPECT_EQ(statistics.sharp_change_alls, 2U);  // in the second, log p falls
  EXPECT_EQ(statistics.change_all_effects, std::vector<std::uint64_t>{1});
  EXPECT_EQ(statistics.effect_log_p_offsets, 30);
  EXPECT_EQ(statistics.proposed[0], 5U);
  EXPECT_EQ(statistics.accepted[0], 5U);
  // Rejected proposals and proposals of other kinds don't count as change-all effects.
  chain.iterations[1].kind = Kind::change_vertices;
  EXPECT_TRUE(statistics_of(chain).change_all_effects.empty());
  chain.iterations[1].kind = Kind::change_all;
  chain.iterations[1].accepted = false;
  statistics = statistics_of(chain);
  EXPECT_TRUE(statistics.change_all_effects.empty());
  EXPECT_EQ(statistics.accepted[0], 4U);
}

}  // namespace
}  // namespace sleight::thesis
