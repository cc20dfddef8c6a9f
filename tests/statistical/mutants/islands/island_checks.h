// Checks of islands. Right islands pass all checks; each mutant fails a check. A check takes a
// mistake and a seed, and returns p-values. If the code is right, p-values are uniform. P-values of
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

/// A check rejects the islands if a p-value is below this limit.
inline constexpr double k_rejects_below = 1e-5;
/// With the suite's seed, a mutant's p-value must be below this limit, so that the mutant fails
/// with other seeds too.
inline constexpr double k_mutants_below = 1e-9;

/// Settings in which the reference is compared with the real code. Some checks use them too.
const std::vector<IslandSetting>& island_settings();

// Checks of the staged toy.
std::vector<double> z_is_right(Mistake mistake, std::uint64_t seed);
std::vector<double> satisfied_is_right(Mistake mistake, std::uint64_t seed);
/// Tests the mean of Z, where Z counts as 0 if the island's draw doesn't satisfy the constraint.
std::vector<double> draws_are_weighed(Mistake mistake, std::uint64_t seed);
std::vector<double> conditional_keeps(Mistake mistake, std::uint64_t seed);
/// Tests conditional steps whose guide overrates fallen walkers.
std::vector<double> conditional_keeps_rescued(Mistake mistake, std::uint64_t seed);
/// Tests exact draws after conditional steps. A local move precedes each step.
std::vector<double> conditional_keeps_among_moves(Mistake mistake, std::uint64_t seed);
std::vector<double> independence_keeps(Mistake mistake, std::uint64_t seed);
/// Tests exact draws after independence steps. Three local moves follow each step.
std::vector<double> independence_keeps_among_moves(Mistake mistake, std::uint64_t seed);
/// Tests exact draws after visits. Each visit has a conditional step and three independence steps.
std::vector<double> visits_keep(Mistake mistake, std::uint64_t seed);
/// Tests the share of satisfying draws in chains that start from a search.
std::vector<double> starts_do_not_count(Mistake mistake, std::uint64_t seed);

// Checks of the pooled toy.
std::vector<double> pool_z_is_right(PoolMistake mistake, std::uint64_t seed);
std::vector<double> pool_satisfied_is_right(PoolMistake mistake, std::uint64_t seed);
/// Tests the mean of 1 / Z over islands that are made given exact draws.
std::vector<double> pool_given_z_is_right(PoolMistake mistake, std::uint64_t seed);
std::vector<double> pool_conditional_keeps(PoolMistake mistake, std::uint64_t seed);
std::vector<double> pool_independence_keeps(PoolMistake mistake, std::uint64_t seed);

const std::vector<IslandCheck<Mistake>>& island_checks();
const std::vector<IslandCheck<PoolMistake>>& pool_checks();

}  // namespace sleight::statistical
