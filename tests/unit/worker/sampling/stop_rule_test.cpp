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
  // Goal: a limit on scans counts all scans. Rounds begin after the first `before` scans.
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
  // Goal: the horizon stays at the end of a round until the round is judged. A run ends at the end
  // of the first round with enough solutions. Method: use rounds that end at scans 17, 37 and 77.
  const StopRule rule{.scans = {}, .rounds = {}, .independent_solutions = 3};
  StopJudge judge(rule, 10, 7);
  EXPECT_EQ(judge.horizon(), 17U);
  EXPECT_EQ(judge.end(), StopJudge::k_no_end);
  judge.judge(16, [](std::uint64_t) -> std::uint64_t { return 99; });
  EXPECT_EQ(judge.horizon(), 17U);
  judge.judge(17, [](std::uint64_t scan) -> std::uint64_t { return scan == 17 ? 2 : 99; });
  EXPECT_EQ(judge.horizon(), 37U);
  // Judge the ends of two rounds at once, as after a replay.
  judge.judge(80, [](std::uint64_t scan) -> std::uint64_t { return scan == 77 ? 3 : 2; });
  EXPECT_EQ(judge.end(), 77U);
  EXPECT_EQ(judge.horizon(), 77U);
  judge.judge(80, none);
  EXPECT_EQ(judge.end(), 77U);
}

TEST(StopJudge, SomeScansAreMadeInAnyCase) {
  // Goal: if solutions can end a run, the run contains at least its first round, unless a limit on
  // scans ends the run earlier.
  const StopRule by_solutions{.scans = {}, .rounds = {}, .independent_solutions = 1};
  EXPECT_EQ(StopJudge(by_solutions, 10, 7).scans_in_any_case(), 17U);
  const StopRule either{.scans = 12, .rounds = {}, .independent_solutions = 1};
  EXPECT_EQ(StopJudge(either, 10, 7).scans_in_any_case(), 12U);
  const StopRule by_scans{.scans = 12, .rounds = 3, .independent_solutions = {}};
  EXPECT_EQ(StopJudge(by_scans, 10, 7).scans_in_any_case(), std::nullopt);
}

TEST(StopJudge, ComesToAnEndWhereRoundsGrowBeyondAllCounts) {
  // Goal: judge() returns even if it reaches the largest number of scans without a solution.
  const StopRule rule{.scans = {}, .rounds = {}, .independent_solutions = 1};
  StopJudge judge(rule, std::uint64_t{1} << 60U, 7);
  judge.judge(StopJudge::k_no_end, none);
  EXPECT_EQ(judge.horizon(), StopJudge::k_no_end);
}

TEST(StopJudgeDeathTest, WantsARuleAndARound) {
  // Goal: a judge without a stop rule, or with rounds of zero scans, stops the process.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(StopJudge({.scans = {}, .rounds = {}, .independent_solutions = {}}, 10),
               "check failed");
  EXPECT_DEATH(StopJudge({.scans = 1, .rounds = {}, .independent_solutions = {}}, 0),
               "check failed");
}

}  // namespace
}  // namespace sleight::sampling
