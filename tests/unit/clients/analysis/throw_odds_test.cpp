// Goal: estimates of several ladders are combined on the log scale. The combined error is the
// largest of three errors. Odds are printed with readable units. Method: compare small cases with
// known results, and print odds near every change of unit.
#include "clients/analysis/throw_odds.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/facts.h"
#include "tests/support/numbers.h"

namespace sleight::analysis {
namespace {

CombinedEstimate combined_of(const std::vector<LogEstimate>& ladders) {
  return combined(ladders);
}

TEST(Combined, TheErrorIsTheLargerOfTheTwo) {
  // Values 1, 2, 3 have mean 2 and standard deviation 1, so the error between ladders is 1/sqrt(3).
  const CombinedEstimate apart = combined_of({{1, 0.3}, {2, 0.3}, {3, 0.3}});
  EXPECT_DOUBLE_EQ(apart.log.value, 2);
  EXPECT_DOUBLE_EQ(apart.log.error, 1 / std::sqrt(3.0));
  EXPECT_EQ(apart.error_from, ErrorFrom::between);
  EXPECT_EQ(apart.ladders, 3U);
  // The mean of two equal values with errors 3 and 4 has the error 5/2.
  const CombinedEstimate alike = combined_of({{7, 3}, {7, 4}});
  EXPECT_DOUBLE_EQ(alike.log.error, 2.5);
  EXPECT_EQ(alike.error_from, ErrorFrom::jackknife);
}

TEST(Combined, ManyLaddersDoNotAverageAwayWhatAMeanOfLogsLacks) {
  // If eight ladders have value 1 and eight have value 3, the variance is 16/15 and the standard
  // error between ladders is 0.26. Half the variance, 0.53, bounds the bias of a mean of logs.
  std::vector<LogEstimate> ladders(16, {1, 0.1});
  for (std::size_t i = 8; i < 16; ++i)
    ladders[i].value = 3;
  const CombinedEstimate many = combined_of(ladders);
  EXPECT_DOUBLE_EQ(many.log.value, 2);
  EXPECT_NEAR(many.between_error, std::sqrt(1.0 / 15), 1e-12);
  EXPECT_NEAR(many.own_error, 0.025, 1e-12);
  EXPECT_NEAR(many.log.error, 8.0 / 15, 1e-12);
  EXPECT_EQ(many.error_from, ErrorFrom::mean_of_logs);
}

TEST(Combined, OneLadderHasItsOwnError) {
  const CombinedEstimate one = combined_of({{-4, 0.5}});
  EXPECT_DOUBLE_EQ(one.log.error, 0.5);
  EXPECT_EQ(one.error_from, ErrorFrom::jackknife);
  const CombinedEstimate unknown = combined_of({{-4, k_nan}});
  EXPECT_EQ(unknown.log.value, -4);
  EXPECT_TRUE(std::isnan(unknown.log.error));
  EXPECT_EQ(unknown.error_from, ErrorFrom::unknown);
}

TEST(Combined, LaddersWithoutAValueAreLeftOut) {
  const CombinedEstimate some = combined_of({{-k_infinity, k_nan}, {-4, 0.5}, {k_nan, k_nan}});
  EXPECT_EQ(some.log.value, -4);
  EXPECT_EQ(some.ladders, 1U);
  const CombinedEstimate none = combined_of({{-k_infinity, k_nan}});
  EXPECT_EQ(none.ladders, 0U);
  EXPECT_TRUE(std::isnan(none.log.value));
  EXPECT_EQ(combined_of({}).ladders, 0U);
  // If the error of a ladder is unknown, it is not taken as 0.
  EXPECT_EQ(combined_of({{-4, 9}, {-5, k_nan}}).error_from, ErrorFrom::between);
}

TEST(ThrowOdds, AreAmongNaturalThrows) {
  const ThrowOdds odds = odds_of({.value = std::log(1e-6), .error = std::log(10.0)}, std::log(0.1));
  EXPECT_NEAR(odds.log10_throws, 5, 1e-12);
  EXPECT_NEAR(odds.log10_low, 4, 1e-12);
  EXPECT_NEAR(odds.log10_high, 6, 1e-12);
  // If an estimate exceeds a natural throw's probability by chance, the odds are one throw in one.
  EXPECT_EQ(odds_of({.value = 1, .error = 0}, 0).log10_throws, 0);
}

std::string words(double throws, double low = k_nan, double high = k_nan) {
  return in_words({std::log10(throws), std::log10(low), std::log10(high)});
}

TEST(ThrowOdds, InWords) {
  EXPECT_THAT(words(3.21e6, 2.1e6, 4.9e6),
              tests::HasFacts("one throw|3.2 million|2.1|4.9 million"));
  EXPECT_THAT(words(1.5e6, 4e5, 4e6), tests::HasFacts("one throw|1.5 million|400,000|4.0 million"));
  EXPECT_THAT(words(1.2e13, 1e12, 1e14), tests::HasFacts("one throw|1.2e13|1.0e12|1.0e14"));
  EXPECT_THAT(words(119.6, 116.1, 123.2), tests::HasFacts("one throw|120|116|123"));
  EXPECT_THAT(words(119.64, 119.52, 119.71), tests::HasFacts("one throw|119.6|119.5|119.7"));
  EXPECT_THAT(words(12345), tests::HasFacts("one throw|12,000|unknown"));
  EXPECT_THAT(words(1), tests::HasFacts("one throw|1.0|unknown"));
  EXPECT_THAT(words(2.44e9), tests::HasFacts("one throw|2.4 billion|unknown"));
  EXPECT_THAT(words(2.44e10), tests::HasFacts("one throw|24 billion|unknown"));
  EXPECT_THAT(words(999'999), tests::HasFacts("one throw|1.0 million|unknown"));
  EXPECT_THAT(words(999.9), tests::HasFacts("one throw|1,000|unknown"));
  EXPECT_THAT(words(9.99), tests::HasFacts("one throw|10|unknown"));
  EXPECT_THAT(in_words({400.3, k_nan, k_nan}), tests::HasFacts("one throw|2.0e400|unknown"));
}

}  // namespace
}  // namespace sleight::analysis
