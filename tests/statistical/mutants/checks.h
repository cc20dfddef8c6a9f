// Checks of samplers. Right code passes all checks; each mutant fails a check. A check takes a
// mutant and a seed, and returns p-values. If the code is right, p-values are uniform. A `certain`
// check returns 1 for right code and 0 for wrong code.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tests/statistical/mutants/mutant.h"

namespace sleight::statistical {

inline constexpr std::size_t k_places = RuggedRing::k_places;

struct Check {
  CheckId id;
  const char* name;
  std::vector<double> (*check)(const Mutant&, std::uint64_t seed);
  std::size_t count;  ///< Number of p-values.
  bool certain;       ///< P-values are 0 or 1.
  bool is_cheap;      ///< One of the cheaper half, whose p-values are tested for uniformity.

  std::vector<double> p_values(const Mutant& mutant, std::uint64_t seed) const {
    const sampling::Replaced replaced(mutant.formulas);
    return check(mutant, seed);
  }
};

/// A check rejects the code if a p-value is below this limit.
inline constexpr double k_threshold = 1e-5;

const std::vector<Check>& checks();
const Check& check_of(CheckId id);

/// Returns the seed of a check's n-th independent ladder.
inline std::uint64_t seed_of(std::uint64_t seed, std::uint64_t n) {
  return seed * 1'000'003 + n;
}

/// Returns the two-sided p-value for the hypothesis that independent draws have this mean, by
/// Student's t. Returns 0 if a draw is NaN.
double mean_p(std::span<const double> draws, double mean);

// Defined in kernel_checks.cpp.
std::vector<double> kernel_keeps(const Mutant& mutant, std::uint64_t seed);
std::vector<double> kernel_moves(const Mutant& mutant, std::uint64_t seed);
std::vector<double> scans_move(const Mutant& mutant, std::uint64_t seed);
std::vector<double> draws_are_fresh(const Mutant& mutant, std::uint64_t seed);
std::vector<double> results_are_pure(const Mutant& mutant, std::uint64_t seed);
std::vector<double> excursions_keep(const Mutant& mutant, std::uint64_t seed);
std::vector<double> excursions_descend(const Mutant& mutant, std::uint64_t seed);
// Defined in ladder_checks.cpp.
std::vector<double> ladder_keeps(const Mutant& mutant, std::uint64_t seed);
std::vector<double> replicas_travel(const Mutant& mutant, std::uint64_t seed);
std::vector<double> parts_are_found(const Mutant& mutant, std::uint64_t seed);
std::vector<double> modes_are_found(const Mutant& mutant, std::uint64_t seed);
std::vector<double> lineages_are_right(const Mutant& mutant, std::uint64_t seed);
std::vector<double> rounds_are_frozen(const Mutant& mutant, std::uint64_t seed);
// Defined in method_checks.cpp.
std::vector<double> stones_weigh(const Mutant& mutant, std::uint64_t seed);
std::vector<double> ascents_weigh(const Mutant& mutant, std::uint64_t seed);
std::vector<double> levels_walk(const Mutant& mutant, std::uint64_t seed);

}  // namespace sleight::statistical
