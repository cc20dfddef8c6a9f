// Goal: each group's share of the satisfying draws is right, and so is its error, which is computed
// from lineages. Method: compare small cases with known results. In random cases, count draw by
// draw. Compare the errors with the scatter of shares over many random runs.
#include "clients/gallery_server/shares.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "common/random/stream.h"

namespace sleight::gallery {
namespace {

using Groups = std::vector<std::optional<std::size_t>>;

TEST(Shares, ADrawGoesToWhatWasKeptLastOfItsLineage) {
  // Goal: each draw counts for an animation of its lineage: the latest animation at or before the
  // draw, or else the first animation. If a lineage has no kept animation, its draws are counted
  // separately.
  const std::vector<LineageDraw> kept{{.chain = 0, .lineage = 5, .draw = 10},
                                      {.chain = 0, .lineage = 5, .draw = 20},
                                      {.chain = 1, .lineage = 5, .draw = 3}};
  const std::vector<LineageDraw> satisfied{
      {.chain = 0, .lineage = 5, .draw = 10}, {.chain = 0, .lineage = 5, .draw = 19},
      {.chain = 0, .lineage = 5, .draw = 20}, {.chain = 0, .lineage = 5, .draw = 9},
      {.chain = 1, .lineage = 5, .draw = 30}, {.chain = 1, .lineage = 6, .draw = 31}};
  const SatisfiedDraws draws = satisfied_draws(satisfied, kept);
  EXPECT_EQ(draws.draws, 5U);
  EXPECT_EQ(draws.elsewhere, 1U);
  ASSERT_EQ(draws.lineages.size(), 2U);
  EXPECT_EQ(draws.lineages[0].draws, 4U);
  const std::vector<Share> shares = shares_of(draws, Groups{0, 1, 1}, 3);
  ASSERT_EQ(shares.size(), 3U);
  EXPECT_DOUBLE_EQ(shares[0].value, 3.0 / 5);
  EXPECT_DOUBLE_EQ(shares[1].value, 2.0 / 5);
  EXPECT_DOUBLE_EQ(shares[2].value, 0);
  // sqrt(2 * ((3 - 0.6 * 4)^2 + (0 - 0.6 * 1)^2)) / 5
  EXPECT_NEAR(shares[0].error, std::sqrt(2 * (0.36 + 0.36)) / 5, 1e-15);
  EXPECT_DOUBLE_EQ(shares[2].error, 0);
}

TEST(Shares, NoDrawsAndOneLineage) {
  // Goal: if there are no draws, there are no shares. If there is one lineage, the error is
  // unknown. If an animation is in no group, it adds to no share.
  EXPECT_TRUE(shares_of({}, Groups{}, 2).empty());
  const std::vector<LineageDraw> kept{{.chain = 0, .lineage = 1, .draw = 1}};
  const std::vector<LineageDraw> twice{kept[0], {.chain = 0, .lineage = 1, .draw = 2}};
  const SatisfiedDraws draws = satisfied_draws(twice, kept);
  const std::vector<Share> shares = shares_of(draws, Groups{0}, 1);
  EXPECT_DOUBLE_EQ(shares[0].value, 1);
  EXPECT_TRUE(std::isnan(shares[0].error));
  EXPECT_DOUBLE_EQ(shares_of(draws, Groups{std::nullopt}, 1)[0].value, 0);
}

TEST(Shares, AreWhatCountingDrawByDrawSays) {
  // Goal: shares equal those of a slow count. Method: count 300 random runs draw by draw (seed 27).
  random::Stream stream({.seed = 27, .purpose = random::Purpose::prior}, 0);
  const auto below = [&](std::uint64_t end) { return stream.bits() % end; };
  for (int run = 0; run < 300; ++run) {
    std::vector<LineageDraw> kept;
    std::vector<LineageDraw> satisfied;
    for (std::uint64_t draw = 0; draw < 60; ++draw) {
      const LineageDraw one{
          .chain = below(2), .lineage = static_cast<std::int64_t>(below(4)), .draw = draw};
      if (below(3) == 0) continue;
      satisfied.push_back(one);
      if (below(4) == 0) kept.push_back(one);
    }
    Groups group_of;
    for (std::size_t i = 0; i < kept.size(); ++i)
      group_of.push_back(below(5) == 0 ? std::nullopt : std::optional<std::size_t>(below(3)));
    std::vector<double> counted(3, 0.0);
    double all = 0;
    for (const LineageDraw& draw : satisfied) {
      std::optional<std::size_t> last;
      std::optional<std::size_t> first;
      for (std::size_t i = 0; i < kept.size(); ++i) {
        if (kept[i].chain != draw.chain || kept[i].lineage != draw.lineage) continue;
        if (!first) first = i;
        if (kept[i].draw <= draw.draw) last = i;
      }
      if (!first) continue;
      all += 1;
      if (const auto group = group_of[last.value_or(*first)]) counted[*group] += 1;
    }
    const std::vector<Share> shares = shares_of(satisfied_draws(satisfied, kept), group_of, 3);
    ASSERT_EQ(shares.empty(), all == 0);
    for (std::size_t group = 0; group < shares.size(); ++group)
      EXPECT_DOUBLE_EQ(shares[group].value, counted[group] / all);
  }
}

TEST(Shares, ErrorsAreHowSharesScatter) {
  // Goal: a share's reported error equals the share's scatter between runs. Method: make 2,000
  // random runs. Each run has 60 lineages, and each lineage has 1 to 12 draws. Each lineage is in
  // the group with probability 0.3 (seed 28). The mean error must equal the shares' standard
  // deviation to within a tenth.
  random::Stream stream({.seed = 28, .purpose = random::Purpose::prior}, 0);
  const auto below = [&](std::uint64_t end) { return stream.bits() % end; };
  double sum = 0;
  double squares = 0;
  double errors = 0;
  constexpr int k_runs = 2000;
  for (int run = 0; run < k_runs; ++run) {
    SatisfiedDraws draws;
    Groups group_of;
    for (std::size_t lineage = 0; lineage < 60; ++lineage) {
      const std::uint64_t count = 1 + below(12);
      draws.lineages.push_back(
          {.draws = count, .counts = {{.animation = lineage, .draws = count}}});
      draws.draws += count;
      group_of.push_back(below(10) < 3 ? 0 : 1);
    }
    const Share share = shares_of(draws, group_of, 2)[0];
    sum += share.value;
    squares += share.value * share.value;
    errors += share.error;
  }
  const double scatter = std::sqrt(squares / k_runs - std::pow(sum / k_runs, 2));
  EXPECT_NEAR(sum / k_runs, 0.3, 0.01);
  EXPECT_NEAR(errors / k_runs / scatter, 1, 0.1);
}

}  // namespace
}  // namespace sleight::gallery
