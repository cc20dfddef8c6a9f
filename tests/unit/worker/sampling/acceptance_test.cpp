#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/numbers.h"
#include "worker/sampling/metropolis_hastings.h"

namespace sleight::sampling {
namespace {

/// always() returns whether every random number in (0, 1) accepts a candidate with this ratio.
/// never() returns whether every random number rejects the candidate.
bool always(double log_ratio) {
  return std::log(1 - 0x1p-53) < log_ratio;
}
bool never(double log_ratio) {
  return !(std::log(0x1p-53) < log_ratio);
}

TEST(TemperedLogDensity, WeighsTheConstraintAlone) {
  // Goal: the tempered log density is log p_w + beta log p_c. At beta 0 it is log p_w, even if p_c
  // is 0.
  EXPECT_EQ(tempered_log_density(-2, -8, 1), -10);
  EXPECT_EQ(tempered_log_density(-2, -8, 0.25), -4);
  EXPECT_EQ(tempered_log_density(-2, -8, 0), -2);
  EXPECT_EQ(tempered_log_density(-2, -k_infinity, 0), -2);
  EXPECT_EQ(tempered_log_density(-2, -k_infinity, 1e-300), -k_infinity);
}

TEST(LogAcceptanceRatio, IsLine7) {
  // Goal: log_acceptance_ratio() returns the log of p(A_c) q(A_i|A_c) / (p(A_i) q(A_c|A_i)).
  EXPECT_EQ(log_acceptance_ratio(-1, -2, -3, -5, 1, 0), -5);
  EXPECT_EQ(log_acceptance_ratio(-1, -2, -3, -5, 0.5, 0), -3.5);
  EXPECT_EQ(log_acceptance_ratio(-1, -2, -3, -5, 1, 7), 2);
  EXPECT_EQ(log_acceptance_ratio(-3, -5, -1, -2, 1, 0), 5);
  EXPECT_EQ(log_acceptance_ratio(-3, -5, -3, -5, 1, 0), 0);
}

TEST(LogAcceptanceRatio, NeverEntersZeroDensity) {
  // Goal: a chain always rejects candidates of zero density and proposals that cannot be reversed,
  // even if infinities give NaN. Method: try candidates whose constraint density is zero, whose
  // prior density is zero, or whose densities are both zero. Start from states with and without
  // density.
  for (const double q : {-5.0, 0.0, 5.0}) {
    EXPECT_TRUE(never(log_acceptance_ratio(-1, -2, -3, -k_infinity, 1, q)));
    EXPECT_TRUE(never(log_acceptance_ratio(-1, -2, -k_infinity, -2, 1, q)));
    EXPECT_TRUE(never(log_acceptance_ratio(-1, -2, -k_infinity, -k_infinity, 0.5, q)));
    EXPECT_TRUE(never(log_acceptance_ratio(-1, -2, -k_infinity, -2, 0, q)));
    EXPECT_TRUE(never(log_acceptance_ratio(-1, -k_infinity, -k_infinity, -2, 1, q)));
  }
  EXPECT_TRUE(never(log_acceptance_ratio(-1, -2, -3, -4, 1, -k_infinity)));
}

TEST(LogAcceptanceRatio, LeavesZeroDensityByThePrior) {
  // Goal: from a state that breaks a hard constraint, acceptance depends only on the prior and on
  // the proposal's ratio. Method: try candidates with and without constraint density.
  for (const double candidate_constraint : {-k_infinity, -3.0, 0.0}) {
    EXPECT_EQ(log_acceptance_ratio(-1, -k_infinity, -4, candidate_constraint, 1, 0.5), -2.5);
    EXPECT_TRUE(always(log_acceptance_ratio(-4, -k_infinity, -1, candidate_constraint, 1, 0)));
  }
  // At beta = 0 the constraint has no effect.
  EXPECT_EQ(log_acceptance_ratio(-1, -k_infinity, -4, -k_infinity, 0, 0), -3);
}

TEST(ChainStreams, DifferByEveryField) {
  // Goal: if two streams differ in seed, chain, replica, purpose or iteration, their random numbers
  // differ. Method: change one field at a time, and compare each stream's first random number.
  const ChainStreams base{.seed = 1, .chain = base::ChainId{2}, .replica = base::ReplicaId{3}};
  const auto word = [](const ChainStreams& streams, random::Purpose purpose, std::uint64_t at) {
    return streams.at(purpose, at).bits();
  };
  const std::uint64_t reference = word(base, random::Purpose::proposal, 4);
  EXPECT_EQ(word(base, random::Purpose::proposal, 4), reference);
  EXPECT_NE(word(base, random::Purpose::proposal, 5), reference);
  EXPECT_NE(word(base, random::Purpose::acceptance, 4), reference);
  EXPECT_NE(
      word({.seed = 2, .chain = base.chain, .replica = base.replica}, random::Purpose::proposal, 4),
      reference);
  EXPECT_NE(word({.seed = 1, .chain = base::ChainId{1}, .replica = base.replica},
                 random::Purpose::proposal, 4),
            reference);
  EXPECT_NE(word({.seed = 1, .chain = base.chain, .replica = base::ReplicaId{0}},
                 random::Purpose::proposal, 4),
            reference);
}

}  // namespace
}  // namespace sleight::sampling
