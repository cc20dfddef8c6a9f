// Checks of islands. Right islands pass all checks, and each mutant fails at least one. A check
// takes a mistake and a seed and returns p-values, which are uniform for right code. P-values of
// means are two-sided and normal. The threshold of 1e-5 is 4.4 standard errors.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/statistical/mutants/islands/pooled_toy.h"
#include "tests/statistical/mutants/islands/staged_reference.h"

namespace sleight::statistical {

inline sampling::ChainStreams streams_of(std::uint64_t seed, std::uint32_t chain) {
  return {.seed = seed, .chain = base::ChainId{chain}, .replica = base::ReplicaId{0}};
}

template <class M>
struct IslandCheck {
  const char* name;
  std::vector<double> (*p_values)(M mistake, std::uint64_t seed);
};

/// A p-value below this limit rejects.
inline constexpr double k_rejects_below = 1e-5;
/// With the suite's seed, p-values of mutants must be below this limit. Mutants then fail with
/// other seeds too.
inline constexpr double k_mutants_below = 1e-9;

/// Settings for the comparison of the reference with the real code, and for some checks.
const std::vector<IslandSetting>& island_settings();

// Checks of the staged toy.
/// Tests the mean Z of free islands.
std::vector<double> z_is_right(Mistake mistake, std::uint64_t seed);
/// Tests the mean P(satisfied) of free islands.
std::vector<double> satisfied_is_right(Mistake mistake, std::uint64_t seed);
/// Tests the mean of a product: Z, times 1 if the island's draw satisfies the constraint, else 0.
std::vector<double> draws_are_weighed(Mistake mistake, std::uint64_t seed);
/// Tests exact draws after conditional steps.
std::vector<double> conditional_keeps(Mistake mistake, std::uint64_t seed);
/// Tests conditional steps with a guide that overrates fallen walkers.
std::vector<double> conditional_keeps_rescued(Mistake mistake, std::uint64_t seed);
/// Tests exact draws after conditional steps, each preceded by a local move.
std::vector<double> conditional_keeps_among_moves(Mistake mistake, std::uint64_t seed);
/// Tests exact draws after independence steps.
std::vector<double> independence_keeps(Mistake mistake, std::uint64_t seed);
/// Tests exact draws after independence steps, each followed by three local moves.
std::vector<double> independence_keeps_among_moves(Mistake mistake, std::uint64_t seed);
/// Tests exact draws after visits. Each visit has a conditional step and three independence steps.
std::vector<double> visits_keep(Mistake mistake, std::uint64_t seed);
/// Tests the share of satisfying draws in chains that start from a search.
std::vector<double> starts_do_not_count(Mistake mistake, std::uint64_t seed);

// Checks of the pooled toy.
std::vector<double> pool_z_is_right(PoolMistake mistake, std::uint64_t seed);
std::vector<double> pool_satisfied_is_right(PoolMistake mistake, std::uint64_t seed);
/// Tests the mean of 1 / Z of islands given exact draws.
std::vector<double> pool_given_z_is_right(PoolMistake mistake, std::uint64_t seed);
std::vector<double> pool_conditional_keeps(PoolMistake mistake, std::uint64_t seed);
std::vector<double> pool_independence_keeps(PoolMistake mistake, std::uint64_t seed);

const std::vector<IslandCheck<Mistake>>& island_checks();
const std::vector<IslandCheck<PoolMistake>>& pool_checks();

}  // namespace sleight::statistical
