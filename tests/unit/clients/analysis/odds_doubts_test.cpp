// Goal: the error of an estimate is reported only if all conditions hold. Each condition that fails
// gives its own kind of doubt. Method: change one value of a good example at a time, and test it
// just below and just above its limit.
#include "clients/analysis/odds_doubts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/numbers.h"

namespace sleight::analysis {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Returns four ladders that agree with each other and with the previous round.
LadderFacts good() {
  return {.judged = {{-4.8, 0.1}, {-4.7, 0.1}, {-4.9, 0.1}, {-4.8, 0.1}},
          .before = {{-4.6, 0.2}, {-4.9, 0.2}, {-4.8, 0.2}, {-5.0, 0.2}},
          .round_trips = {12, 10, 11, 9},
          .round = "round 7 of 7"};
}

std::vector<DoubtOf> kinds(const std::vector<Doubt>& doubts) {
  std::vector<DoubtOf> all;
  for (const Doubt& doubt : doubts)
    all.push_back(doubt.kind);
  return all;
}

std::vector<DoubtOf> kinds_of(const LadderFacts& facts) {
  return kinds(doubts_of(facts));
}

TEST(OddsDoubts, GoodLaddersHaveNone) {
  EXPECT_THAT(doubts_of(good()), IsEmpty());
}

TEST(OddsDoubts, EachLadderHasToMakeRoundTrips) {
  // A ladder without round trips biases the mean, however many round trips other ladders have.
  LadderFacts facts = good();
  facts.round_trips = {400, 0, 400, 400};
  std::vector<Doubt> doubts = doubts_of(facts);
  ASSERT_THAT(kinds(doubts), ElementsAre(DoubtOf::few_round_trips));
  EXPECT_EQ(doubts[0].longer, 5);
  EXPECT_TRUE(doubts[0].at_least);

  facts.round_trips = {400, 4, 2, 400};
  doubts = doubts_of(facts);
  ASSERT_THAT(kinds(doubts), ElementsAre(DoubtOf::few_round_trips));
  EXPECT_EQ(doubts[0].longer, 2.5);
  EXPECT_FALSE(doubts[0].at_least);

  facts.round_trips = {400, 5, 5, 400};
  EXPECT_THAT(doubts_of(facts), IsEmpty());
  facts.round_trips = {400, k_nan, 400, 400};
  EXPECT_THAT(kinds_of(facts), ElementsAre(DoubtOf::few_round_trips));
}

TEST(OddsDoubts, AllTogetherHaveToMakeRoundTrips) {
  LadderFacts facts = good();
  facts.round_trips = {10, 10, 10, 9};
  const std::vector<Doubt> doubts = doubts_of(facts);
  ASSERT_THAT(kinds(doubts), ElementsAre(DoubtOf::few_round_trips));
  EXPECT_NEAR(doubts[0].longer, 40.0 / 39, 1e-12);
  facts.round_trips = {10, 10, 10, 10};
  EXPECT_THAT(doubts_of(facts), IsEmpty());
}

TEST(OddsDoubts, OneLadderNeedsAllTheRoundTripsItself) {
  LadderFacts facts{.judged = {{-4.8, 0.1}},
                    .before = {{-4.7, 0.1}},
                    .round_trips = {39},
                    .round = "round 2 of 2"};
  EXPECT_THAT(kinds_of(facts), ElementsAre(DoubtOf::few_round_trips));
  facts.round_trips = {40};
  EXPECT_THAT(doubts_of(facts), IsEmpty());
}

TEST(OddsDoubts, TheFirstRoundIsNotTrusted) {
  LadderFacts facts = good();
  facts.before.clear();
  EXPECT_THAT(kinds_of(facts), ElementsAre(DoubtOf::first_round));
}

TEST(OddsDoubts, RoundsHaveToAgree) {
  // The rounds' means are -4.8 and -4.8 + shift. The means' jackknife errors are 0.05 and 0.1, so
  // three errors of their difference are 0.335.
  LadderFacts facts = good();
  const auto shifted = [&](double shift) {
    facts.before.clear();
    for (int i = 0; i < 4; ++i)
      facts.before.push_back({-4.8 + shift, 0.2});
    return kinds_of(facts);
  };
  EXPECT_THAT(shifted(-0.33), IsEmpty());
  EXPECT_THAT(shifted(0.33), IsEmpty());
  EXPECT_THAT(shifted(-0.34), ElementsAre(DoubtOf::rounds_disagree));
  EXPECT_THAT(shifted(0.34), ElementsAre(DoubtOf::rounds_disagree));
  // Rounds disagree if a value is infinite or NaN.
  facts = good();
  facts.before[2] = {-k_infinity, k_nan};
  EXPECT_THAT(kinds_of(facts), ElementsAre(DoubtOf::rounds_disagree));
  facts.before.assign(4, {k_nan, k_nan});
  EXPECT_THAT(kinds_of(facts), ElementsAre(DoubtOf::rounds_disagree));
}

TEST(OddsDoubts, OneBadLadderIsFarFromTheOthers) {
  LadderFacts facts = good();
  facts.judged[3].value = -9;
  // The bad ladder makes the error between ladders so large that the rounds agree.
  EXPECT_THAT(kinds_of(facts), ElementsAre(DoubtOf::wide, DoubtOf::ladders_disagree));
  // A bad ladder that is closer to the other ladders still disagrees with them. The deviations are
  // -0.6, 0.2, 0.2, 0.2, so the standard deviation is 0.4, four times the ladders' errors.
  facts.judged = {{-5.4, 0.1}, {-4.6, 0.1}, {-4.6, 0.1}, {-4.6, 0.1}};
  EXPECT_THAT(kinds_of(facts), ElementsAre(DoubtOf::ladders_disagree));
  for (LogEstimate& ladder : facts.judged)
    ladder.error = 0.134;
  EXPECT_THAT(doubts_of(facts), IsEmpty());
}

TEST(OddsDoubts, OneLadderAloneHasToKnowTheLog) {
  LadderFacts facts = good();
  for (LogEstimate& ladder : facts.judged)
    ladder.error = 1;
  EXPECT_THAT(doubts_of(facts), IsEmpty());
  for (LogEstimate& ladder : facts.judged)
    ladder.error = 2;
  const std::vector<Doubt> doubts = doubts_of(facts);
  ASSERT_THAT(kinds(doubts), ElementsAre(DoubtOf::wide));
  EXPECT_NEAR(doubts[0].longer, 4, 1e-12);
  facts.judged[1].error = k_nan;
  EXPECT_THAT(kinds_of(facts), ElementsAre(DoubtOf::wide));
}

TEST(OddsDoubts, LaddersWithoutAValueAreNotLeftOut) {
  LadderFacts facts = good();
  facts.judged[0] = {-k_infinity, k_nan};
  std::vector<Doubt> doubts = doubts_of(facts);
  ASSERT_THAT(kinds(doubts), ElementsAre(DoubtOf::no_value));
  facts.judged.assign(4, {-k_infinity, k_nan});
  EXPECT_THAT(kinds_of(facts), ElementsAre(DoubtOf::no_value));
}

TEST(OddsDoubts, ManyShortLaddersAsForAcm) {
  // The example resembles a run of requests/acm_tempered.toml. The only round has sixteen ladders,
  // 13 of them without a round trip. The mean log estimate is 6 below the truth, and the standard
  // error between ladders is 0.5.
  LadderFacts facts{.judged = {}, .before = {}, .round_trips = {}, .round = "round 1 of 1"};
  for (int i = 0; i < 16; ++i) {
    facts.judged.push_back({-66.4 + 4 * (i - 7.5) / 9.2, 0.8});
    facts.round_trips.push_back(i < 13 ? 0 : 1);
  }
  EXPECT_THAT(kinds_of(facts),
              ElementsAre(DoubtOf::few_round_trips, DoubtOf::first_round, DoubtOf::wide));
}

TEST(OddsDoubts, WeightedDrawsHaveToBeWorthEnough) {
  const std::vector<LogEstimate> chains{{-3, 0.2}, {-3.1, 0.2}};
  EXPECT_THAT(doubts_of_weights(chains, 100, 100), IsEmpty());
  EXPECT_THAT(kinds(doubts_of_weights(chains, 99, 100)), ElementsAre(DoubtOf::few_draws));
  EXPECT_THAT(kinds(doubts_of_weights(chains, k_nan, 100)), ElementsAre(DoubtOf::few_draws));
  // A ladder with error 0.23 is worth 1 / 0.23^2 = 18.9 draws. The two ladders need 40 draws
  // together.
  const std::vector<LogEstimate> rough{{-3, 0.23}, {-3.1, 0.23}};
  const std::vector<Doubt> doubts = doubts_of_weights(rough, 100, 100);
  ASSERT_THAT(kinds(doubts), ElementsAre(DoubtOf::few_draws));
  const std::vector<LogEstimate> apart{{-3, 0.02}, {-3.5, 0.02}};
  EXPECT_THAT(kinds(doubts_of_weights(apart, 1000, 100)), ElementsAre(DoubtOf::ladders_disagree));
  const std::vector<LogEstimate> none{{-3, 0.02}, {-k_infinity, k_nan}};
  EXPECT_THAT(kinds(doubts_of_weights(none, 1000, 100)), ElementsAre(DoubtOf::no_value));
}

math::IslandOdds islands(std::uint64_t count, double largest_share) {
  return {.islands = count, .log_mean = -207, .relative_sd = 1, .largest_share = largest_share};
}

TEST(OddsDoubts, FixedAndSizedNumbersOfIslandsHaveNone) {
  for (const IslandNumber number : {IslandNumber::fixed, IslandNumber::sized})
    EXPECT_THAT(doubts_of_islands(islands(math::k_islands_min, 0.1), number), IsEmpty());
}

TEST(OddsDoubts, IslandsMustNotChooseTheirOwnNumber) {
  for (const IslandNumber number :
       {IslandNumber::unfinished, IslandNumber::by_solutions, IslandNumber::unknown}) {
    const std::vector<Doubt> doubts = doubts_of_islands(islands(1000, 0.01), number);
    ASSERT_THAT(kinds(doubts), ElementsAre(DoubtOf::not_sized));
    EXPECT_FALSE(doubts[0].reason.empty());
  }
}

TEST(OddsDoubts, NoIslandMayHaveMostOfTheSum) {
  const std::vector<Doubt> doubts = doubts_of_islands(islands(1000, 0.304), IslandNumber::sized);
  ASSERT_THAT(kinds(doubts), ElementsAre(DoubtOf::heavy_tail));
  EXPECT_NEAR(doubts[0].longer, 3.04, 1e-12);
  EXPECT_TRUE(doubts[0].at_least);
  EXPECT_THAT(kinds(doubts_of_islands(islands(1000, 0.304), IslandNumber::by_solutions)),
              ElementsAre(DoubtOf::not_sized, DoubtOf::heavy_tail));
}

TEST(OddsDoubts, IslandsHaveToBeMany) {
  const std::vector<Doubt> doubts = doubts_of_islands(islands(10, 0.1), IslandNumber::fixed);
  ASSERT_THAT(kinds(doubts), ElementsAre(DoubtOf::few_draws));
  EXPECT_EQ(doubts[0].longer, 10);
  // If there is no solution or no island, the missing value is the only doubt.
  const math::IslandOdds none{.islands = 1000, .log_mean = -k_infinity};
  EXPECT_THAT(kinds(doubts_of_islands(none, IslandNumber::fixed)), ElementsAre(DoubtOf::no_value));
  EXPECT_THAT(kinds(doubts_of_islands({}, IslandNumber::fixed)), ElementsAre(DoubtOf::no_value));
}

TEST(OddsDoubts, IslandsNeedParticles) {
  const auto of_particles = [](std::optional<double> particles) {
    return doubts_of_islands(islands(1000, 0.01), IslandNumber::sized, particles);
  };
  EXPECT_THAT(of_particles({}), IsEmpty());
  EXPECT_THAT(of_particles(16), IsEmpty());
  ASSERT_THAT(kinds(of_particles(15)), ElementsAre(DoubtOf::few_particles));
}

TEST(OddsDoubts, IslandsWithoutDoubtsAreKnown) {
  // doubts_of_islands() returns no doubts if and only if IslandOdds::known() is true.
  for (const std::uint64_t count :
       {std::uint64_t{0}, math::k_islands_min - 1, math::k_islands_min}) {
    for (const double share : {0.01, 0.1, 0.11, 1.0}) {
      const math::IslandOdds odds = islands(count, share);
      EXPECT_EQ(doubts_of_islands(odds, IslandNumber::fixed).empty(), odds.known());
    }
  }
}

TEST(Remedy, IsTheLongest) {
  const Doubt doubts[] = {{.kind = DoubtOf::wide, .longer = 3, .at_least = true},
                          {.kind = DoubtOf::few_round_trips, .longer = 5, .at_least = false}};
  EXPECT_EQ(remedy_of(doubts).longer, 5);
  EXPECT_TRUE(remedy_of(doubts).at_least);
}

}  // namespace
}  // namespace sleight::analysis
