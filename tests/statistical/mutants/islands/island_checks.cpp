#include "tests/statistical/mutants/islands/island_checks.h"

#include <cmath>
#include <functional>
#include <numeric>

#include "common/base/check.h"
#include "common/random/discrete_distributions.h"
#include "tests/statistical/mutants/islands/searched_toy.h"
#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/rank_tests.h"
#include "worker/sampling/particle_steps.h"

namespace sleight::statistical {
namespace {

constexpr double k_always = 2;  ///< A resample_below that always resamples.
constexpr int k_islands = 4'000;

struct Chains {
  std::uint32_t count = 1'500;
  std::uint64_t steps = 5;
};

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// Returns the p-value for the hypothesis that independent draws have this mean, by the normal
/// distribution. Returns 0 if a draw is NaN.
double mean_p(const std::vector<double>& draws, double mean) {
  const MeanWithError seen = mean_of_independent(draws);
  if (!std::isfinite(seen.mean) || !(seen.standard_error > 0)) return 0;
  return std::erfc(std::abs(seen.mean - mean) / seen.standard_error / std::sqrt(2.0));
}

template <class World>
double mass_of(const World& world, double beta,
               const std::function<bool(typename World::State)>& is_chosen) {
  const std::vector<double> masses = world.masses(beta);
  double mass = 0;
  for (typename World::State state = 0; state < World::k_states; ++state)
    mass += is_chosen(state) ? masses[state] : 0;
  return mass;
}

bool satisfies(StagedToy::State state) {
  return k_toy.satisfied(k_toy.simulate(state));
}

/// Computes the mean of `value` over free islands in each setting. Returns the means' p-values.
std::vector<double> mean_over_islands(Mistake mistake, std::uint64_t seed,
                                      const std::function<double(const ReferenceIsland&)>& value,
                                      const std::function<double(double beta)>& expected) {
  std::vector<double> p;
  std::uint32_t chain = 0;
  for (const IslandSetting& setting : island_settings()) {
    std::vector<double> values;
    for (int i = 0; i < k_islands; ++i)
      values.push_back(
          value(ReferenceIslands(setting, streams_of(seed, chain++), mistake).free(0)));
    p.push_back(mean_p(values, expected(setting.options.inverse_temperature)));
  }
  return p;
}

using AfterSteps = std::function<std::uint32_t(std::uint32_t state, const sampling::ChainStreams&)>;

std::uint32_t exact_draw(const std::vector<double>& masses, const sampling::ChainStreams& streams) {
  random::Stream start = streams.at(random::Purpose::start, 0);
  return static_cast<std::uint32_t>(random::draw_by_share(masses, start));
}

/// Moves exact draws by steps of independent chains, and compares the states with `masses`. Returns
/// the p-value.
double kept(std::vector<double> masses, std::uint64_t seed, std::uint32_t first_chain,
            std::uint32_t count, const AfterSteps& after_steps) {
  const double total = sum(masses);
  for (double& mass : masses)
    mass /= total;
  std::vector<double> counts(masses.size(), 0.0);
  for (std::uint32_t chain = first_chain; chain < first_chain + count; ++chain) {
    const sampling::ChainStreams streams = streams_of(seed, chain);
    ++counts[after_steps(exact_draw(masses, streams), streams)];
  }
  return chi_square_p(counts, masses);
}

/// Moves exact draws by the reference's steps in each setting. Returns kept() of each setting.
std::vector<double> reference_keeps(
    Mistake mistake, std::uint64_t seed, const Chains& chains,
    const std::vector<IslandSetting>& settings,
    const std::function<void(const ReferenceSteps&, std::uint64_t number, ReferenceChain&)>& step) {
  std::vector<double> p;
  std::uint32_t first_chain = 0;
  for (const IslandSetting& setting : settings) {
    const auto after = [&](std::uint32_t state, const sampling::ChainStreams& streams) {
      const ReferenceSteps steps(setting, streams, mistake);
      ReferenceChain chain{.state = state};
      for (std::uint64_t number = 0; number < chains.steps; ++number)
        step(steps, number, chain);
      return chain.state;
    };
    p.push_back(kept(k_toy.masses(setting.options.inverse_temperature), seed, first_chain,
                     chains.count, after));
    first_chain += chains.count;
  }
  return p;
}

StagedToy::State found_state(const SearchedToy& world, const sampling::ChainStreams& streams) {
  for (std::uint64_t number = 0; number < run::k_starts_max; ++number) {
    sampling::SearchEffort effort;
    if (const auto find = run::search_start(world, {}, streams, number, effort)) return find->state;
  }
  CHECK(false);
  return 0;
}

}  // namespace

const std::vector<IslandSetting>& island_settings() {
  static const std::vector<IslandSetting> all{
      {.guide = {}, .options = {.particles = 8}},
      {.guide = {.flatness = 0}, .options = {.particles = 3, .resample_below = k_always}},
      {.guide = {.log_fallen = 0}, .options = {.particles = 2}},
      {.guide = {}, .options = {.particles = 5, .inverse_temperature = 2}}};
  return all;
}

std::vector<double> z_is_right(Mistake mistake, std::uint64_t seed) {
  return mean_over_islands(
      mistake, seed, [](const ReferenceIsland& island) { return std::exp(island.log_z); },
      [](double beta) { return sum(k_toy.masses(beta)); });
}

std::vector<double> satisfied_is_right(Mistake mistake, std::uint64_t seed) {
  return mean_over_islands(
      mistake, seed, [](const ReferenceIsland& island) { return std::exp(island.log_satisfied); },
      [](double) { return mass_of(k_toy, 0, satisfies); });
}

std::vector<double> draws_are_weighed(Mistake mistake, std::uint64_t seed) {
  return mean_over_islands(
      mistake, seed,
      [](const ReferenceIsland& island) {
        return island.drawn && satisfies(*island.drawn) ? std::exp(island.log_z) : 0;
      },
      [](double beta) { return mass_of(k_toy, beta, satisfies); });
}

std::vector<double> conditional_keeps(Mistake mistake, std::uint64_t seed) {
  return reference_keeps(mistake, seed, {}, island_settings(),
                         [](const auto& steps, std::uint64_t number, ReferenceChain& chain) {
                           steps.conditional(number, chain);
                         });
}

std::vector<double> conditional_keeps_rescued(Mistake mistake, std::uint64_t seed) {
  constexpr Chains k_long{.count = 4'500, .steps = 12};
  const IslandSetting setting{.guide = {.flatness = 0, .log_fallen = 0.5},
                              .options = {.particles = 8, .resample_below = k_always}};
  const std::vector<double> masses = k_toy.masses(1);
  std::vector<double> shares;
  for (std::uint32_t id = 0; id < k_long.count; ++id) {
    const sampling::ChainStreams streams = streams_of(seed, id);
    ReferenceChain chain{.state = exact_draw(masses, streams)};
    const ReferenceSteps steps(setting, streams, mistake);
    double rescued = 0;
    for (std::uint64_t number = 0; number < k_long.steps; ++number) {
      steps.conditional(number, chain);
      rescued += StagedToy::has_fallen(chain.state) ? 1 : 0;
    }
    // Draws of one chain are correlated, so their mean counts once.
    shares.push_back(rescued / k_long.steps);
  }
  return {mean_p(shares, mass_of(k_toy, 1, StagedToy::has_fallen) / sum(masses))};
}

std::vector<double> independence_keeps(Mistake mistake, std::uint64_t seed) {
  return reference_keeps(mistake, seed, {}, island_settings(),
                         [](const auto& steps, std::uint64_t number, ReferenceChain& chain) {
                           steps.independent(2 * number, chain);
                         });
}

std::vector<double> conditional_keeps_among_moves(Mistake mistake, std::uint64_t seed) {
  return reference_keeps(mistake, seed, {.count = 3'000, .steps = 6},
                         {{.guide = {.flatness = 0}, .options = {.particles = 8}}},
                         [](const auto& steps, std::uint64_t number, ReferenceChain& chain) {
                           steps.local(number, chain);
                           steps.conditional(number, chain);
                         });
}

std::vector<double> independence_keeps_among_moves(Mistake mistake, std::uint64_t seed) {
  // In the second setting, islands never reach states in which the walker fell on the way. Only
  // local moves reach these states.
  static const std::vector<IslandSetting> settings{
      {.guide = {}, .options = {.particles = 3}},
      {.guide = {.log_fallen = sampling::k_log_zero},
       .options = {.particles = 8, .resample_below = k_always}}};
  return reference_keeps(mistake, seed, {.count = 3'000, .steps = 6}, settings,
                         [](const auto& steps, std::uint64_t number, ReferenceChain& chain) {
                           steps.independent(2 * number, chain);
                           for (std::uint64_t local = 0; local < 3; ++local)
                             steps.local(3 * number + local, chain);
                         });
}

std::vector<double> visits_keep(Mistake mistake, std::uint64_t seed) {
  static const std::vector<IslandSetting> settings{
      {.guide = {}, .options = {.particles = 2, .resample_below = k_always}},
      {.guide = {}, .options = {.particles = 4}}};
  return reference_keeps(mistake, seed, {.count = 1'500, .steps = 4}, settings,
                         [](const auto& steps, std::uint64_t number, ReferenceChain& chain) {
                           steps.visit(number, chain);
                         });
}

std::vector<double> starts_do_not_count(Mistake mistake, std::uint64_t seed) {
  constexpr std::uint64_t k_burn_in = 8;
  constexpr std::uint32_t k_chains = 800;
  const SearchedToy world;
  const IslandSetting setting{.guide = {}, .options = {.particles = 8}};
  std::vector<double> shares;
  for (std::uint32_t id = 0; id < k_chains; ++id) {
    const sampling::ChainStreams streams = streams_of(seed, id);
    ReferenceChain chain{.state = found_state(world, streams)};
    std::vector<double> draws;
    if (mistake == Mistake::start_of_a_search_counts)
      draws.push_back(satisfies(chain.state) ? 1 : 0);
    for (std::uint64_t scan = 1; scan <= k_burn_in; ++scan)
      ReferenceSteps(setting, streams, mistake).visit(scan, chain);
    draws.push_back(satisfies(chain.state) ? 1 : 0);
    // Draws of one chain are correlated, so their mean counts once.
    shares.push_back(sum(draws) / static_cast<double>(draws.size()));
  }
  return {mean_p(shares, mass_of(k_toy, 1, satisfies) / sum(k_toy.masses(1)))};
}

namespace {

constexpr double k_pool_beta = 1;

const std::vector<sampling::IslandOptions>& pool_options() {
  static const std::vector<sampling::IslandOptions> all{
      {.particles = 6}, {.particles = 2, .resample_below = k_always}};
  return all;
}

using PoolIslands = sampling::Islands<PooledToy>;

std::vector<double> mean_over_pools(
    PoolMistake mistake, std::uint64_t seed,
    const std::function<double(const sampling::Island<PooledToy>&)>& value, double expected) {
  const PooledToy world(mistake);
  const PooledToy::Guide guide;
  std::vector<double> p;
  std::uint32_t chain = 0;
  for (const sampling::IslandOptions& options : pool_options()) {
    std::vector<double> values;
    for (int i = 0; i < 2 * k_islands; ++i)
      values.push_back(
          value(PoolIslands(world, guide, options, streams_of(seed, chain++)).free(0)));
    p.push_back(mean_p(values, expected));
  }
  return p;
}

std::vector<double> pool_keeps(
    PoolMistake mistake, std::uint64_t seed,
    const std::function<void(const PoolIslands&, std::uint64_t number,
                             sampling::ParticleSample<PooledToy>&)>& step) {
  const PooledToy world(mistake);
  const PooledToy::Guide guide;
  const Chains chains{.count = 3'000, .steps = 6};
  std::vector<double> p;
  std::uint32_t first_chain = 0;
  for (const sampling::IslandOptions& options : pool_options()) {
    const auto after = [&](std::uint32_t state, const sampling::ChainStreams& streams) {
      const PoolIslands islands(world, guide, options, streams);
      sampling::ParticleSample<PooledToy> current{.sample = sampling::evaluate(world, state)};
      for (std::uint64_t number = 0; number < chains.steps; ++number)
        step(islands, number, current);
      return current.sample.state;
    };
    p.push_back(kept(world.masses(k_pool_beta), seed, first_chain, chains.count, after));
    first_chain += chains.count;
  }
  return p;
}

}  // namespace

std::vector<double> pool_z_is_right(PoolMistake mistake, std::uint64_t seed) {
  return mean_over_pools(
      mistake, seed, [](const auto& island) { return std::exp(island.log_z); },
      sum(PooledToy().masses(k_pool_beta)));
}

std::vector<double> pool_satisfied_is_right(PoolMistake mistake, std::uint64_t seed) {
  const PooledToy world;
  return mean_over_pools(
      mistake, seed, [](const auto& island) { return std::exp(island.log_satisfied); },
      mass_of(world, 0,
              [&](PooledToy::State state) { return world.satisfied(world.simulate(state)); }));
}

std::vector<double> pool_given_z_is_right(PoolMistake mistake, std::uint64_t seed) {
  // If an island is made given an exact draw, its distribution is that of free islands reweighted
  // by Z' / Z. So the mean of 1 / Z' is 1 / Z if no island dies.
  constexpr std::uint32_t k_given = 20'000;
  const PooledToy world(mistake);
  const PooledToy::Guide guide;
  const std::vector<double> masses = world.masses(k_pool_beta);
  std::vector<double> inverse;
  for (std::uint32_t id = 0; id < k_given; ++id) {
    const sampling::ChainStreams streams = streams_of(seed, id);
    const PoolIslands islands(world, guide, pool_options().back(), streams);
    inverse.push_back(std::exp(-islands.given(0, exact_draw(masses, streams)).log_z));
  }
  return {mean_p(inverse, 1 / sum(masses))};
}

std::vector<double> pool_conditional_keeps(PoolMistake mistake, std::uint64_t seed) {
  return pool_keeps(mistake, seed,
                    [](const PoolIslands& islands, std::uint64_t number, auto& current) {
                      sampling::conditional_step(islands, number, current);
                    });
}

std::vector<double> pool_independence_keeps(PoolMistake mistake, std::uint64_t seed) {
  return pool_keeps(mistake, seed,
                    [](const PoolIslands& islands, std::uint64_t number, auto& current) {
                      sampling::independence_step(islands, 2 * number, current);
                    });
}

const std::vector<IslandCheck<Mistake>>& island_checks() {
  static const std::vector<IslandCheck<Mistake>> all{
      {"z_is_right", z_is_right},
      {"satisfied_is_right", satisfied_is_right},
      {"draws_are_weighed", draws_are_weighed},
      {"conditional_keeps", conditional_keeps},
      {"conditional_keeps_rescued", conditional_keeps_rescued},
      {"conditional_keeps_among_moves", conditional_keeps_among_moves},
      {"independence_keeps", independence_keeps},
      {"independence_keeps_among_moves", independence_keeps_among_moves},
      {"visits_keep", visits_keep},
      {"starts_do_not_count", starts_do_not_count}};
  return all;
}

const std::vector<IslandCheck<PoolMistake>>& pool_checks() {
  static const std::vector<IslandCheck<PoolMistake>> all{
      {"pool_z_is_right", pool_z_is_right},
      {"pool_satisfied_is_right", pool_satisfied_is_right},
      {"pool_given_z_is_right", pool_given_z_is_right},
      {"pool_conditional_keeps", pool_conditional_keeps},
      {"pool_independence_keeps", pool_independence_keeps}};
  return all;
}

}  // namespace sleight::statistical
