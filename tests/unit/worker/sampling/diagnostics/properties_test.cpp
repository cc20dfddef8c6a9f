// What the measures must satisfy whoever computes them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/unit/worker/sampling/diagnostics/made_chains.h"
#include "worker/sampling/diagnostics/effective_sample_size.h"
#include "worker/sampling/diagnostics/r_hat.h"
#include "worker/sampling/diagnostics/standard_error.h"
#include "worker/sampling/diagnostics/transforms.h"

namespace sleight::sampling {
namespace {

using testing::changed;
using testing::made;

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
constexpr double k_infinity = std::numeric_limits<double>::infinity();

TEST(EffectiveSampleSize, of_independent_draws_is_about_their_number) {
  // Goal: 4000 independent draws are worth 4000. Method: each measure over 20 seeds; its mean
  // within 5 standard errors, as the seeds themselves show them, plus the 2% by which cutting the
  // sum off at a negative pair is known to be short or long.
  using Measure = double (*)(const Chains&);
  for (const Measure measure : std::initializer_list<Measure>{
           ess_bulk, ess_mean, ess_sd,
           [](const Chains& draws) { return ess_quantile(draws, 0.5); }}) {
    std::vector<double> found;
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
      found.push_back(measure(made({.seed = seed}).view()));
    const double error = std::sqrt(variance_of(found) / 20);
    EXPECT_NEAR(mean_of(found), 4000, 5 * error + 80);
  }
}

TEST(EffectiveSampleSize, of_an_autoregression_is_the_known_one) {
  // Goal: the number itself, not its order alone. Method: AR(1) with coefficient r has the sum of
  // autocorrelations tau = (1 + r)/(1 - r); 8 chains of 4000 draws, 10 seeds, 5 standard errors
  // plus 3% for cutting off.
  for (const double r : {0.9, 0.5, -0.5}) {
    const double expected = 8 * 4000 * (1 - r) / (1 + r);
    const double cap = 8 * 4000 * std::log10(8 * 4000);
    std::vector<double> found;
    for (std::uint64_t seed = 1; seed <= 10; ++seed)
      found.push_back(
          ess_mean(made({.seed = seed, .chains = 8, .draws = 4000, .coefficient = r}).view()));
    const double error = std::sqrt(variance_of(found) / 10);
    EXPECT_NEAR(mean_of(found), std::min(expected, cap), 5 * error + 0.03 * expected) << r;
  }
}

TEST(EffectiveSampleSize, of_antithetic_chains_is_capped) {
  // Goal: at most S log10 S. Method: an autoregression at -0.99, worth far more.
  const OwnedChains draws = made({.coefficient = -0.99});
  EXPECT_NEAR(ess_mean(draws.view()), 4000 * std::log10(4000), 1e-9 * 4000);
}

TEST(RHat, of_mixed_chains_is_near_1_and_of_shifted_or_scaled_ones_is_not) {
  // Goal: it tells chains that agree from such that don't. Method: independent draws; the last
  // chain shifted by half a standard deviation (bulk), or three times as wide (tail alone).
  const OwnedChains mixed = made({});
  EXPECT_LT(r_hat(mixed.view()), 1.01);
  const OwnedChains shifted = changed(
      mixed, [](double value, std::size_t chain) { return chain == 3 ? value + 0.5 : value; });
  EXPECT_GT(r_hat_bulk(shifted.view()), 1.02);
  EXPECT_EQ(r_hat(shifted.view()), r_hat_bulk(shifted.view()));
  const OwnedChains scaled = changed(
      mixed, [](double value, std::size_t chain) { return chain == 3 ? value * 3 : value; });
  EXPECT_LT(r_hat_bulk(scaled.view()), 1.01);
  EXPECT_GT(r_hat_tail(scaled.view()), 1.05);
  EXPECT_EQ(r_hat(scaled.view()), r_hat_tail(scaled.view()));
}

TEST(RankBased, are_unchanged_by_monotone_functions) {
  // Goal: ranks alone count. Method: x -> x^3 and x -> exp(x), and the cube negated for R-hat,
  // whose ranks turn round; equal bits but for that. ess_mean does change.
  const OwnedChains draws = made({.draws = 333, .coefficient = 0.7});
  const auto cube = [](double value, std::size_t) { return value * value * value; };
  const OwnedChains cubed = changed(draws, cube);
  const OwnedChains grown = changed(draws, [](double x, std::size_t) { return std::exp(x); });
  for (const OwnedChains* other : {&cubed, &grown}) {
    EXPECT_EQ(ess_bulk(other->view()), ess_bulk(draws.view()));
    EXPECT_EQ(ess_tail(other->view()), ess_tail(draws.view()));
    EXPECT_EQ(r_hat_bulk(other->view()), r_hat_bulk(draws.view()));
    EXPECT_NE(ess_mean(other->view()), ess_mean(draws.view()));
  }
  const OwnedChains turned = changed(cubed, [](double x, std::size_t) { return -x; });
  EXPECT_NEAR(r_hat_bulk(turned.view()), r_hat_bulk(draws.view()), 1e-13);
  EXPECT_NEAR(ess_bulk(turned.view()), ess_bulk(draws.view()), 1e-10 * 1332);
}

TEST(StandardError, has_the_draws_unit_and_ignores_their_origin) {
  // Goal: errors of 8 x + 5 are 8 times those of x. Method: exact in binary but for the shift.
  const OwnedChains draws = made({.chains = 3, .draws = 200, .coefficient = 0.4});
  const OwnedChains moved = changed(draws, [](double x, std::size_t) { return 8 * x + 5; });
  EXPECT_NEAR(mcse_mean(moved.view()) / mcse_mean(draws.view()), 8, 1e-12);
  EXPECT_NEAR(mcse_sd(moved.view()) / mcse_sd(draws.view()), 8, 1e-11);
  EXPECT_NEAR(mcse_quantile(moved.view(), 0.3) / mcse_quantile(draws.view(), 0.3), 8, 1e-12);
}

TEST(StandardError, covers_the_truth_as_often_as_it_should) {
  // Goal: errors are neither boasts nor fears. Method: of 300 runs of an autoregression around 0
  // the mean lies within one error in 68.3% of cases; binomial, 4 standard errors (2.7% each).
  int covered = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const OwnedChains draws = made({.seed = seed, .draws = 500, .coefficient = 0.5});
    covered += std::fabs(mean_of(draws.values)) < mcse_mean(draws.view()) ? 1 : 0;
  }
  EXPECT_NEAR(covered / 300.0, 0.683, 0.108);
}

TEST(Nan, is_the_answer_where_there_is_none) {
  // Goal: each documented reason for NaN. Method: one array for each.
  const OwnedChains draws = made({.chains = 2, .draws = 21});
  const auto with = [&](std::size_t at, double value) {
    OwnedChains other = draws;
    other.values[at] = value;
    return other;
  };
  for (const double bad : {k_nan, k_infinity}) {
    const OwnedChains spoilt = with(3, bad);
    EXPECT_TRUE(std::isnan(ess_mean(spoilt.view())));
    EXPECT_TRUE(std::isnan(ess_tail(spoilt.view())));
    EXPECT_TRUE(std::isnan(mcse_sd(spoilt.view())));
    EXPECT_TRUE(std::isnan(mcse_quantile(spoilt.view(), 0.5)));
    EXPECT_EQ(std::isnan(r_hat(spoilt.view())), std::isnan(bad)) << "infinities have ranks";
    EXPECT_EQ(std::isnan(ess_bulk(spoilt.view())), std::isnan(bad));
    // The middle draw of 21 is in no half.
    EXPECT_FALSE(std::isnan(ess_mean(with(10, bad).view())));
    EXPECT_TRUE(std::isnan(mcse_mean(with(10, bad).view())));
  }
  const OwnedChains constant = changed(draws, [](double, std::size_t) { return 0.1; });
  EXPECT_TRUE(std::isnan(r_hat(constant.view())));
  EXPECT_TRUE(std::isnan(ess_bulk(constant.view())));
  const OwnedChains huge = changed(draws, [](double x, std::size_t) { return 1e200 * x; });
  EXPECT_TRUE(std::isnan(ess_mean(huge.view()))) << "the variance overflows";
  EXPECT_FALSE(std::isnan(ess_bulk(huge.view())));
  const OwnedChains one = made({.chains = 4, .draws = 1});
  EXPECT_TRUE(std::isnan(r_hat(one.view())));
  EXPECT_TRUE(std::isnan(ess_bulk(one.view())));
}

TEST(Shapes, must_fit) {
  // Goal: a view whose numbers don't fit its shape is refused. Method: one draw too few.
  const std::vector<double> five(5, 1.0);
  EXPECT_DEATH(r_hat({.values = five, .chains = 2, .draws = 3}), "check failed");
  EXPECT_DEATH(ess_mean({.values = {}, .chains = 1, .draws = 0}), "check failed");
  EXPECT_DEATH(ess_quantile({.values = five, .chains = 1, .draws = 5}, 1.1), "check failed");
}

}  // namespace
}  // namespace sleight::sampling
