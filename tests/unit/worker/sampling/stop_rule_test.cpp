#include "worker/sampling/stop_rule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace sleight::sampling {
namespace {

std::uint64_t none(std::uint64_t /*scan*/) {
  return 0;
}

TEST(StopJudge, CountsRoundsFromAfterTheScansBefore) {
  // Goal: scans count everything, rounds and solutions what comes after `before`. Method: by hand.
  const StopRule scans{.scans = 100, .rounds = {}, .independent_solutions = {}};
  EXPECT_EQ(StopJudge(scans, 10, 35).end(), 100U);
  EXPECT_EQ(StopJudge(scans, 10, 200).end(), 100U);
  EXPECT_EQ(StopJudge(scans, 10, 35).horizon(), 100U);
  const StopRule rounds{.scans = {}, .rounds = 2, .independent_solutions = {}};
  EXPECT_EQ(StopJudge(rounds, 10, 35).end(), 65U);
  EXPECT_EQ(StopJudge(rounds, 10, 0).end(), 30U);
  EXPECT_EQ(StopJudge(rounds, 10, StopJudge::k_no_end - 5).end(), StopJudge::k_no_end);
  const StopRule both{.scans = 60, .rounds = 2, .independent_solutions = {}};
  EXPECT_EQ(StopJudge(both, 10, 35).end(), 60U);
  EXPECT_EQ(StopJudge(both, 10, 5).end(), 35U);
}

TEST(StopJudge, JudgesSolutionsAtRoundEnds) {
  // Goal: nothing beyond a round's end is handed out before it is judged, with what satisfied
  // before it; the first end with enough is the run's. Method: rounds end at 17, 37 and 77.
  const StopRule rule{.scans = {}, .rounds = {}, .independent_solutions = 3};
  StopJudge judge(rule, 10, 7);
  EXPECT_EQ(judge.horizon(), 17U);
  EXPECT_EQ(judge.end(), StopJudge::k_no_end);
  judge.judge(16, [](std::uint64_t) -> std::uint64_t { return 99; });
  EXPECT_EQ(judge.horizon(), 17U);
  judge.judge(17, [](std::uint64_t scan) -> std::uint64_t { return scan == 17 ? 2 : 99; });
  EXPECT_EQ(judge.horizon(), 37U);
  // Over two ends at once, as after a replay.
  judge.judge(80, [](std::uint64_t scan) -> std::uint64_t { return scan == 77 ? 3 : 2; });
  EXPECT_EQ(judge.end(), 77U);
  EXPECT_EQ(judge.horizon(), 77U);
  judge.judge(80, none);
  EXPECT_EQ(judge.end(), 77U);
}

/// So many islands of this spread, of which one has this share.
math::IslandOdds islands(std::uint64_t count, double relative_sd, double largest_share = 0.05) {
  return {.islands = count,
          .log_mean = -200,
          .relative_sd = relative_sd,
          .largest_share = largest_share};
}

constexpr StopRule k_to_a_tenth{
    .scans = {}, .rounds = {}, .independent_solutions = {}, .odds = 0.1};

TEST(StopJudge, OddsSizeTheLastRound) {
  // Goal: once the islands so far say that the next round's will do, that one is the last, whatever
  // its own islands say. Method: rounds end at 17, 37, 77 and 157; six islands a scan of spread 2:
  // it takes 400, the third round of 240 has too few and the fourth of 480 is enough.
  StopJudge judge(k_to_a_tenth, 10, 7);
  std::vector<std::pair<std::uint64_t, std::uint64_t>> asked;
  const auto odds = [&](std::uint64_t first, std::uint64_t end) {
    asked.emplace_back(first, end);
    return islands(6 * (end - first), 2);
  };
  EXPECT_EQ(judge.horizon(), 17U);
  judge.judge(16, none, odds);
  EXPECT_TRUE(asked.empty());
  judge.judge(17, none, odds);
  EXPECT_EQ(judge.horizon(), 37U);
  judge.judge(76, none, odds);
  EXPECT_EQ(judge.horizon(), 77U);
  EXPECT_FALSE(judge.sized_round());
  judge.judge(77, none, odds);
  EXPECT_EQ(judge.horizon(), 157U);
  EXPECT_EQ(judge.end(), 157U);
  ASSERT_TRUE(judge.sized_round());
  EXPECT_EQ(judge.sized_round()->first, 77U);
  EXPECT_EQ(judge.sized_round()->end, 157U);
  // The burn-in's islands do not size, and what the last round says changes nothing.
  EXPECT_EQ(asked,
            (std::vector<std::pair<std::uint64_t, std::uint64_t>>{{7, 17}, {7, 37}, {7, 77}}));
  judge.judge(157, none, odds);
  EXPECT_EQ(asked.size(), 3U);
  EXPECT_EQ(judge.end(), 157U);
  // At once, as after a replay.
  StopJudge replayed(k_to_a_tenth, 10, 7);
  replayed.judge(1000, none, odds);
  EXPECT_EQ(replayed.end(), 157U);
  EXPECT_EQ(replayed.sized_round()->first, 77U);
}

TEST(StopJudge, OddsAreSizedByWhatIsHalfKnownOnly) {
  // Goal: too few islands, a heavy tail, or none that satisfies size nothing. Method: each, of no
  // spread that would matter.
  const auto sizes = [](const math::IslandOdds& odds) {
    StopJudge judge(k_to_a_tenth, 10, 7);
    judge.judge(17, none, [&](std::uint64_t, std::uint64_t) { return odds; });
    return judge.sized_round().has_value();
  };
  EXPECT_TRUE(sizes(islands(60, 0.1)));
  EXPECT_TRUE(sizes(islands(60, 0.1, 0.1)));
  EXPECT_FALSE(sizes(islands(60, 0.1, 0.101)));
  EXPECT_FALSE(sizes(islands(49, 0.1)));
  EXPECT_TRUE(sizes(islands(50, 0.1)));
  // After a second round of twice as many the next has less than twice as many as both together:
  // those have to be enough to be told.
  const auto sizes_after_two = [](std::uint64_t of_both) {
    StopJudge judge(k_to_a_tenth, 10, 7);
    judge.judge(37, none, [&](std::uint64_t, std::uint64_t end) {
      return islands(end == 37 ? of_both : 1, 0.1);
    });
    return judge.sized_round().has_value();
  };
  EXPECT_TRUE(sizes_after_two(75));   // and then 100
  EXPECT_FALSE(sizes_after_two(72));  // and then 96
  EXPECT_FALSE(sizes(islands(60, std::nan(""), std::nan(""))));
  EXPECT_FALSE(sizes({}));
}

TEST(StopJudge, ComesToAnEndWhereRoundsGrowBeyondAllCounts) {
  // Goal: no endless loop. Method: the largest count reached without a solution.
  const StopRule rule{.scans = {}, .rounds = {}, .independent_solutions = 1};
  StopJudge judge(rule, std::uint64_t{1} << 60U, 7);
  judge.judge(StopJudge::k_no_end, none);
  EXPECT_EQ(judge.horizon(), StopJudge::k_no_end);
}

TEST(StopJudgeDeathTest, WantsARuleAndARound) {
  // Goal: misuse is a bug. Method: no rule; rounds of no scans.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(StopJudge({.scans = {}, .rounds = {}, .independent_solutions = {}}, 10),
               "check failed");
  EXPECT_DEATH(StopJudge({.scans = 1, .rounds = {}, .independent_solutions = {}}, 0),
               "check failed");
  StopJudge without_islands(k_to_a_tenth, 10);
  EXPECT_DEATH(without_islands.judge(10, none), "check failed");
}

}  // namespace
}  // namespace sleight::sampling
