// Right islands pass the statistical checks, and each known mistake fails a check.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "tests/statistical/mutants/islands/island_mistakes.h"
#include "tests/statistical/mutants/islands/searched_toy.h"
#include "worker/run/island_scan.h"
#include "worker/sampling/particle_steps.h"

namespace sleight::statistical {
namespace {

using Islands = sampling::Islands<SearchedToy>;

constexpr std::uint64_t k_seed = 20270201;
constexpr std::uint64_t k_seeds = 3;

/// Returns the checks' settings and some extreme settings.
std::vector<IslandSetting> all_settings() {
  std::vector<IslandSetting> all = island_settings();
  for (const std::uint32_t particles : {1U, 2U, 3U, 7U, 40U}) {
    for (const double resample_below : {0.0, 0.5, 2.0}) {
      for (const double log_fallen : {-2.0, sampling::k_log_zero}) {
        all.push_back({.guide = {.log_fallen = log_fallen},
                       .options = {.particles = particles,
                                   .inverse_temperature = particles == 7 ? 0.0 : 1.0,
                                   .resample_below = resample_below}});
      }
    }
  }
  return all;
}

/// Returns a state where p_c > 0. Conditional islands require such a state.
StagedToy::State state_of(const sampling::ChainStreams& streams) {
  const StagedToy toy;
  random::Stream stream = streams.at(random::Purpose::start, 0);
  StagedToy::State state = toy.draw_prior(stream);
  while (toy.simulate(state).fallen)
    state = toy.draw_prior(stream);
  return state;
}

void expect_equal(const sampling::Island<SearchedToy>& real, const ReferenceIsland& reference) {
  EXPECT_EQ(real.log_z, reference.log_z);
  EXPECT_EQ(real.log_satisfied, reference.log_satisfied);
  EXPECT_EQ(real.effective_size, reference.effective_size);
  EXPECT_EQ(real.satisfied, reference.satisfied);
  EXPECT_EQ(real.is_unreachable, reference.is_unreachable);
  ASSERT_EQ(real.drawn.has_value(), reference.drawn.has_value());
  if (real.drawn) {
    EXPECT_EQ(real.drawn->state, *reference.drawn);
  }
}

TEST(StagedReference, MakesTheSameIslands) {
  // Goal: without a mistake, the reference makes the same islands as the real code. So each mutant
  // is the real algorithm with one mistake. Method: compare free and conditional islands of both
  // bit by bit, for many settings, seeds and island numbers.
  const SearchedToy world;
  int dead = 0;
  int unreachable = 0;
  for (const IslandSetting& setting : all_settings()) {
    for (std::uint32_t chain = 0; chain < 60; ++chain) {
      const sampling::ChainStreams streams = streams_of(k_seed + chain % 7, chain);
      const Islands real(world, setting.guide, setting.options, streams);
      const ReferenceIslands reference(setting, streams, Mistake::none);
      for (const std::uint64_t number :
           {std::uint64_t{0}, std::uint64_t{5}, std::uint64_t{1} << 48U}) {
        const auto free = real.free(number);
        expect_equal(free, reference.free(number));
        dead += free.drawn ? 0 : 1;
        if (setting.options.particles < 2) continue;
        const auto given = real.given(number, state_of(streams));
        expect_equal(given, reference.given(number, state_of(streams)));
        unreachable += given.is_unreachable ? 1 : 0;
      }
    }
    if (HasFailure()) break;
  }
  fmt::print("{} dead and {} unreachable ones among them\n", dead, unreachable);
  EXPECT_GT(dead, 100);
  EXPECT_GT(unreachable, 100);
}

struct BothChains {
  sampling::ParticleSample<SearchedToy> real;
  ReferenceChain reference;
};

void expect_equal(const BothChains& chains) {
  EXPECT_EQ(chains.real.sample.state, chains.reference.state);
  EXPECT_EQ(chains.real.log_z, chains.reference.log_z);
}

TEST(StagedReference, MakesTheSameSteps) {
  // Goal: chains of the reference equal chains of the real code. Method: alternate conditional
  // steps, independence steps and local moves in both chains. Compare states and Z after each step.
  const SearchedToy world;
  int stale = 0;
  for (const IslandSetting& setting : all_settings()) {
    if (setting.options.particles < 2) continue;
    const double beta = setting.options.inverse_temperature;
    for (std::uint32_t chain = 0; chain < 20; ++chain) {
      const sampling::ChainStreams streams = streams_of(k_seed, chain);
      const Islands islands(world, setting.guide, setting.options, streams);
      const ReferenceSteps steps(setting, streams, Mistake::none);
      const StagedToy::State start = state_of(streams);
      BothChains chains{.real = {.sample = sampling::evaluate(world, start)},
                        .reference = {.state = start}};
      for (std::uint64_t number = 0; number < 12; ++number) {
        if (number % 3 == 0) {
          sampling::conditional_step(islands, 100 + number, chains.real);
          steps.conditional(100 + number, chains.reference);
          expect_equal(chains);
        }
        sampling::independence_step(islands, 2 * number, chains.real);
        steps.independent(2 * number, chains.reference);
        expect_equal(chains);
        const auto report =
            sampling::metropolis_hastings_step(world, beta, streams, number, chains.real.sample);
        if (report.accepted) chains.real.log_z.reset();
        steps.local(number, chains.reference);
        expect_equal(chains);
        stale += chains.real.log_z ? 0 : 1;
      }
    }
    if (HasFailure()) break;
  }
  EXPECT_GT(stale, 1000);
}

TEST(StagedReference, MakesTheSameVisits) {
  // Goal: visits of the reference equal visits of a run, even if they start at a state of zero
  // density. Method: start both from the same prior draw, and compare the states after each visit.
  const SearchedToy world;
  int without_mass = 0;
  for (const IslandSetting& setting : all_settings()) {
    const sampling::IslandOptions as_in_runs{.particles = setting.options.particles};
    if (as_in_runs.particles < 2) continue;
    for (std::uint32_t chain = 0; chain < 20; ++chain) {
      const sampling::ChainStreams streams = streams_of(k_seed, chain);
      const run::IslandScan<SearchedToy> scans(world, setting.guide, as_in_runs.particles, streams,
                                               [](const sampling::SimulationReport&) {});
      const ReferenceSteps steps({setting.guide, as_in_runs}, streams, Mistake::none);
      random::Stream stream = streams.at(random::Purpose::prior, 0);
      ReferenceChain reference{.state = world.draw_prior(stream)};
      auto sample = sampling::evaluate(world, reference.state);
      without_mass += sample.log_constraint == sampling::k_log_zero ? 1 : 0;
      for (std::uint64_t scan = 1; scan < 6; ++scan) {
        sample = scans.visit(scan, sample).sample;
        steps.visit(scan, reference);
        EXPECT_EQ(sample.state, reference.state);
      }
    }
    if (HasFailure()) break;
  }
  EXPECT_GT(without_mass, 20);
}

template <class M>
double least_p(const IslandCheck<M>& check, M mistake, std::uint64_t seed) {
  const double least = std::ranges::min(check.p_values(mistake, seed));
  fmt::print("{}, seed {}: least p {:.3g}\n", check.name, seed, least);
  return least;
}

class RightIslands : public testing::TestWithParam<IslandCheck<Mistake>> {};
class RightPools : public testing::TestWithParam<IslandCheck<PoolMistake>> {};

TEST_P(RightIslands, PassTheCheck) {
  // Goal: right islands pass each check with several seeds.
  for (std::uint64_t seed = k_seed; seed < k_seed + k_seeds; ++seed)
    EXPECT_GT(least_p(GetParam(), Mistake::none, seed), k_rejects_below);
}

TEST_P(RightPools, PassTheCheck) {
  // Goal: right pools pass each check with several seeds.
  for (std::uint64_t seed = k_seed; seed < k_seed + k_seeds; ++seed)
    EXPECT_GT(least_p(GetParam(), PoolMistake::none, seed), k_rejects_below);
}

class IslandMutants : public testing::TestWithParam<IslandMutant<Mistake>> {};
class PoolMutants : public testing::TestWithParam<IslandMutant<PoolMistake>> {};

template <class M>
void expect_caught(const IslandMutant<M>& mutant, const std::vector<IslandCheck<M>>& checks) {
  const auto check = std::ranges::find(checks, mutant.check, &IslandCheck<M>::p_values);
  ASSERT_NE(check, checks.end());
  fmt::print("{}: {}\n", mutant.name, mutant.why);
  EXPECT_LT(least_p(*check, mutant.mistake, k_seed), k_mutants_below);
}

TEST_P(IslandMutants, AreCaught) {
  // Goal: each known mistake in islands fails the check that is meant for it.
  expect_caught(GetParam(), island_checks());
}

TEST_P(PoolMutants, AreCaught) {
  // Goal: each known mistake in pools fails the check that is meant for it.
  expect_caught(GetParam(), pool_checks());
}

const auto k_name = [](const auto& instance) { return std::string(instance.param.name); };

INSTANTIATE_TEST_SUITE_P(Checks, RightIslands, testing::ValuesIn(island_checks()), k_name);
INSTANTIATE_TEST_SUITE_P(Checks, RightPools, testing::ValuesIn(pool_checks()), k_name);
INSTANTIATE_TEST_SUITE_P(Mistakes, IslandMutants, testing::ValuesIn(island_mutants()), k_name);
INSTANTIATE_TEST_SUITE_P(Mistakes, PoolMutants, testing::ValuesIn(pool_mutants()), k_name);

template <class M>
void expect_all_used(const std::vector<IslandMutant<M>>& mutants,
                     const std::vector<IslandCheck<M>>& checks, M last) {
  std::set<M> mistakes;
  std::set<std::vector<double> (*)(M, std::uint64_t)> used;
  for (const IslandMutant<M>& mutant : mutants) {
    EXPECT_TRUE(mistakes.insert(mutant.mistake).second) << mutant.name;
    used.insert(mutant.check);
  }
  EXPECT_FALSE(mistakes.contains(M::none));
  EXPECT_EQ(mistakes.size(), static_cast<std::size_t>(last));
  for (const IslandCheck<M>& check : checks)
    EXPECT_TRUE(used.contains(check.p_values)) << "no mutant needs: " << check.name;
}

TEST(IslandChecks, EachMistakeAndEachCheckIsUsed) {
  // Goal: the table of mutants contains every mistake once and uses every check.
  expect_all_used(island_mutants(), island_checks(), Mistake::start_of_a_search_counts);
  expect_all_used(pool_mutants(), pool_checks(), PoolMistake::retained_drops_share_a_place);
}

}  // namespace
}  // namespace sleight::statistical
