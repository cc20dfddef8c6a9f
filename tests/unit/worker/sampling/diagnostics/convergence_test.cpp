// Goal: complaints() explains why chains have not mixed, and gives no false alarm. Method: check
// the complaints about chains that have one fault each, and about chains that have none.
#include "worker/sampling/diagnostics/convergence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/facts.h"
#include "tests/unit/worker/sampling/diagnostics/made_chains.h"
#include "worker/sampling/diagnostics/effective_sample_size.h"
#include "worker/sampling/diagnostics/r_hat.h"

namespace sleight::sampling {
namespace {

using testing::changed;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::made;
using ::testing::MatchesRegex;
using ::testing::StartsWith;

std::vector<std::string> complaints_of(const OwnedChains& draws) {
  return complaints("x", convergence_of(draws.view()));
}

TEST(Convergence, collects_the_measures) {
  // Goal: each field of a Convergence contains the measure that the field's name states. Method:
  // check the fields for two chains of four known draws. For longer chains, compare the fields with
  // the functions that compute single measures.
  const OwnedChains draws{.values = {1, 2, 3, 4, 5, 5, 5, 5}, .chains = 2, .draws = 4};
  const Convergence found = convergence_of(draws.view());
  EXPECT_EQ(found.chains, 2U);
  EXPECT_EQ(found.draws, 4U);
  EXPECT_EQ(found.not_finite, 0U);
  EXPECT_EQ(found.unmoved, 1U);
  EXPECT_FALSE(found.constant);
  EXPECT_DOUBLE_EQ(found.mean, 3.75);
  EXPECT_DOUBLE_EQ(found.sd, std::sqrt(17.5 / 7));
  const OwnedChains longer = made({.coefficient = 0.5});
  const Convergence all = convergence_of(longer.view());
  EXPECT_EQ(all.r_hat, r_hat(longer.view()));
  EXPECT_EQ(all.r_hat_bulk, r_hat_bulk(longer.view()));
  EXPECT_EQ(all.ess_bulk, ess_bulk(longer.view()));
  EXPECT_EQ(all.ess_tail, ess_tail(longer.view()));
  EXPECT_EQ(all.mcse_mean, mcse_mean(longer.view()));
}

TEST(Complaints, are_none_of_mixed_chains) {
  EXPECT_THAT(complaints_of(made({})), IsEmpty());
}

TEST(Complaints, are_none_of_what_is_the_same_everywhere) {
  const auto constant = [](double, std::size_t) { return 0.1; };
  EXPECT_THAT(complaints_of(changed(made({}), constant)), IsEmpty());
  EXPECT_THAT(complaints_of(changed(made({.draws = 1}), constant)), IsEmpty());
}

TEST(Complaints, are_none_of_mixed_chains_of_two_values) {
  // Goal: complaints() doesn't report a missing tail as a fault. Method: use chains of the values 0
  // and 1. If 0 and 1 are equally frequent, all draws have equal distances from the median, and the
  // tail's R-hat is NaN. If 3 in 10 draws are 1, the 0.95 quantile is the maximum, and the tail's
  // effective sample size is NaN.
  OwnedChains even = made({});
  for (std::size_t i = 0; i < even.values.size(); i += 2) {
    const bool up = even.values[i] > 0;
    even.values[i] = up ? 1 : 0;
    even.values[i + 1] = up ? 0 : 1;
  }
  EXPECT_TRUE(std::isnan(convergence_of(even.view()).r_hat));
  EXPECT_THAT(complaints_of(even), IsEmpty());
  const auto rarer = [](double value, std::size_t) { return value > 0.524 ? 1.0 : 0.0; };
  const OwnedChains uneven = changed(made({}), rarer);
  EXPECT_TRUE(std::isnan(convergence_of(uneven.view()).ess_tail));
  EXPECT_THAT(complaints_of(uneven), IsEmpty());
}

TEST(Complaints, name_shifted_chains) {
  const OwnedChains shifted = changed(made({}), [](double value, std::size_t chain) {
    return value + 10 * static_cast<double>(chain);
  });
  const std::vector<std::string> found = complaints_of(shifted);
  EXPECT_THAT(found, ElementsAre(StartsWith("x: R-hat is "), tests::LinesHaveFacts("x: |bulk"),
                                 tests::LinesHaveFacts("x: |tail")));
}

TEST(Complaints, name_chains_that_never_move) {
  // Goal: complaints() reports chains that never move, for any R-hat: infinite, about 1e15, or
  // smaller. Method: give each chain its own constant value, with numbers of draws for which means
  // are exact or rounded. Then make only one of four chains constant.
  const auto own = [](double, std::size_t chain) { return 0.1 * static_cast<double>(chain); };
  for (const std::size_t draws : {64U, 1000U, 1024U, 2000U}) {
    const std::vector<std::string> found = complaints_of(changed(made({.draws = draws}), own));
    ASSERT_FALSE(found.empty());
    EXPECT_THAT(found[0], StartsWith("x: no chain ever moves"));
  }
  const auto first = [](double value, std::size_t chain) { return chain == 0 ? 2 : value; };
  EXPECT_THAT(complaints_of(changed(made({}), first))[0],
              tests::LinesHaveFacts("x: 1 of 4 chains|R-hat"));
}

TEST(Complaints, name_what_cannot_be_judged) {
  OwnedChains draws = made({});
  draws.values[17] = -std::numeric_limits<double>::infinity();
  draws.values[18] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(complaints_of(draws), ElementsAre(tests::LinesHaveFacts("x: 2 of 4000|NaN")));
  EXPECT_THAT(complaints_of(made({.draws = 5})),
              ElementsAre(MatchesRegex("x: 5 draws per chain .* 6 .*")));
}

TEST(Complaints, keep_to_the_thresholds) {
  // Goal: complaints begin just beyond the documented limits. Method: test measures exactly at each
  // limit and just beyond it.
  const Convergence at{.chains = 4,
                       .draws = 1000,
                       .r_hat_bulk = 1,
                       .r_hat = k_r_hat_max,
                       .ess_bulk = 400,
                       .ess_tail = 400};
  EXPECT_THAT(complaints("x", at), IsEmpty());
  Convergence past = at;
  past.r_hat = 1.0101;
  EXPECT_EQ(complaints("x", past).size(), 1U);
  past = at;
  past.ess_bulk = 399.9;
  EXPECT_THAT(complaints("x", past), ElementsAre(tests::LinesHaveFacts("x: |bulk|399|400")));
  past = at;
  past.ess_tail = 399.9;
  EXPECT_THAT(complaints("x", past), ElementsAre(tests::LinesHaveFacts("x: |tail|399|400")));
  past = at;
  past.chains = 5;
  EXPECT_EQ(complaints("x", past).size(), 2U);
  EXPECT_EQ(ess_wanted(1), 400);
  EXPECT_EQ(ess_wanted(5), 500);
}

}  // namespace
}  // namespace sleight::sampling
