// Tests that the right code passes the statistical checks. A sampler with a known mistake must fail
// a check.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iterator>
#include <set>

#include "tests/statistical/mutants/checks.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/support/property.h"

namespace sleight::statistical {
namespace {

constexpr std::uint64_t k_seed = 20270101;
/// Maximum probability that the whole suite fails by chance.
constexpr double k_budget = 1e-3;

/// Number of seeds. The test compares their p-values with the uniform distribution.
std::uint64_t uniformity_seeds() {
  return property::long_run() ? 1000 : 100;
}

std::vector<Mutant> all_mutants() {
  std::vector<Mutant> all = wrong_kernels();
  for (auto* more : {wrong_methods, wrong_workers}) {
    for (Mutant& mutant : more())
      all.push_back(std::move(mutant));
  }
  return all;
}

class RightCode : public testing::TestWithParam<Check> {};

TEST_P(RightCode, PassesTheCheck) {
  // Goal: right code passes each check.
  const Check& check = GetParam();
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<double> p = check.p_values(right_code(), k_seed);
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begin;
  ASSERT_EQ(p.size(), check.count);
  fmt::print("{}: least p {:.3g} of {}, {:.0f} ms\n", check.name, std::ranges::min(p), p.size(),
             taken.count());
  EXPECT_GT(std::ranges::min(p), k_threshold) << "seed " << k_seed;
}

class CheapCheck : public testing::TestWithParam<Check> {};

TEST_P(CheapCheck, HasUniformPValues) {
  // Goal: the p-values of the cheaper half of the checks are calibrated. Method: run the right code
  // with many seeds. Compare the p-values with the uniform distribution. Checks marked `certain`
  // must pass with each of ten seeds.
  const Check& check = GetParam();
  const std::uint64_t seeds = check.certain ? 10 : uniformity_seeds();
  std::vector<std::vector<double>> p(check.count);
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const std::vector<double> once = check.p_values(right_code(), k_seed + 1 + seed);
    for (std::size_t i = 0; i < check.count; ++i)
      p[i].push_back(once[i]);
  }
  for (const std::vector<double>& values : p) {
    if (check.certain) {
      EXPECT_EQ(std::ranges::min(values), 1) << "seeds from " << k_seed + 1;
      continue;
    }
    const double uniform = uniformity_p(values);
    fmt::print("{}: {} p-values uniform with p {:.3g}\n", check.name, seeds, uniform);
    EXPECT_GT(uniform, k_threshold) << "seeds from " << k_seed + 1;
  }
}

std::vector<Check> cheap_checks() {
  std::vector<Check> cheap;
  std::ranges::copy_if(checks(), std::back_inserter(cheap), &Check::is_cheap);
  return cheap;
}

std::string name_of(const testing::TestParamInfo<Check>& instance) {
  std::string name = instance.param.name;
  std::ranges::replace(name, ' ', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Checks, RightCode, testing::ValuesIn(checks()), name_of);
INSTANTIATE_TEST_SUITE_P(Checks, CheapCheck, testing::ValuesIn(cheap_checks()), name_of);

TEST(Checks, FailByChanceOnceInAThousandRuns) {
  // Goal: the whole suite fails by chance at most once in 1,000 runs. Method: add up the thresholds
  // of all p-values, and the thresholds of all tests that p-values are uniform.
  double sum = 0;
  std::size_t uncertain = 0;
  std::size_t shown_uniform = 0;
  for (const Check& check : checks()) {
    if (check.certain) continue;
    ++uncertain;
    shown_uniform += check.is_cheap ? 1 : 0;
    sum += static_cast<double>(check.count) * k_threshold * (check.is_cheap ? 2 : 1);
  }
  fmt::print("the right code fails by chance with probability {:.2g} at most\n", sum);
  EXPECT_LT(sum, k_budget);
  EXPECT_GE(2 * shown_uniform, uncertain);
}

TEST(Mutants, AreCaught) {
  // Goal: at most one mutant passes all checks, and each check rejects at least one mutant. Method:
  // run each mutant's checks with the threshold for right code.
  const std::vector<Mutant> mutants = all_mutants();
  std::set<std::string> names;
  std::set<CheckId> used;
  std::size_t caught = 0;
  fmt::print("{:<34}{:<20}{:<10}{}\n", "mutant", "check", "p", "what is wrong");
  for (const Mutant& mutant : mutants) {
    EXPECT_TRUE(names.insert(mutant.name).second) << mutant.name;
    const char* by = "none";
    double least = 1;
    for (const CheckId id : mutant.checks) {
      const Check& check = check_of(id);
      const double p = std::ranges::min(check.p_values(mutant, k_seed));
      if (p >= least) continue;
      least = p;
      by = check.name;
      if (p >= k_threshold) continue;
      used.insert(id);
      break;
    }
    const bool rejected = least < k_threshold;
    caught += rejected ? 1 : 0;
    fmt::print("{:<34}{:<20}{:<10.2g}{}{}\n", mutant.name, by, least, mutant.what,
               rejected ? "" : "  ** NOT CAUGHT **");
  }
  fmt::print("{} of {} caught\n", caught, mutants.size());
  EXPECT_GE(mutants.size(), 25U);
  EXPECT_GE(caught + 1, mutants.size()) << "seed " << k_seed;
  EXPECT_GE(caught, 24U);
  for (const Check& check : checks())
    EXPECT_TRUE(used.contains(check.id)) << "no mutant needs: " << check.name;
}

}  // namespace
}  // namespace sleight::statistical
