// Ladders of inverse temperatures, and how swap statistics improve them (Syed, Bouchard-Cote,
// Deligiannidis, Doucet 2022, Non-reversible parallel tempering).
//
// Idea. Let r_i be the rejection rate of swaps between levels i and i+1. For any ladder, the sum of
// r_i up to a level estimates the communication barrier Lambda(beta) at that level. Temperatures
// must be dense where the slope of Lambda, the local barrier, is large. The best ladder has equal
// r_i, so its levels divide the barrier into equal parts. The rate of round trips per scan is then
//
//   1 / (2 + 2 sum of r_i / (1 - r_i)),
//
// if exploration at each level decorrelates the states enough between two swaps.
//
// A ladder ascends from 0 (the prior) to 1. Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sleight::sampling {

/// Exponent for first_ladder(). The exponent makes the hottest of a dozen levels hot enough for
/// narrow constraints. A ladder that starts too hot wastes a level. A ladder that starts too cold
/// costs rounds: a gap that rejects all swaps counts as a barrier of 1, so each respacing only
/// about halves the gap.
inline constexpr std::uint32_t k_first_power = 6;

/// Returns the initial ladder, (i / (levels - 1))^power. With power 1, steps are equal and the
/// first states descend from the prior fastest. REQUIRES: at least 2 levels; 0 < power < 64,
/// because the lowest level after the prior must stay above 0.
std::vector<double> first_ladder(std::uint32_t levels, std::uint32_t power = k_first_power);

/// Returns inverse temperatures for simulated annealing: target * scan / anneal_scans for each scan
/// from first_scan to first_scan + scans - 1. The first scan at `target` comes after the annealing.
std::vector<double> annealing(double target, std::uint64_t anneal_scans, std::uint64_t first_scan,
                              std::uint64_t scans);

/// Limits on the number of levels. LadderOptions::levels_max can lower the maximum.
inline constexpr std::uint32_t k_levels_min = 2;
inline constexpr std::uint32_t k_levels_max = 256;

/// Returns 2 * barrier + 1. With this many levels, neighbours swap about every second time.
std::uint32_t levels_for(double barrier);

/// Returns the communication barrier up to each level. `rejections` has a rate for each gap.
std::vector<double> cumulative_barrier(std::span<const double> rejections);

/// Returns the barrier's slope at each level, from a monotone cubic (Fritsch and Carlson 1980).
std::vector<double> local_barrier(std::span<const double> ladder,
                                  std::span<const double> rejections);

/// Returns a ladder that divides the cumulative barrier into equal parts, so all gaps reject
/// equally often. Between levels, the barrier is the cubic of local_barrier. A rate of 0 counts as
/// a small rate, so levels are distinct. REQUIRES: levels from k_levels_min to k_levels_max; one
/// rate per gap.
std::vector<double> respaced(std::span<const double> ladder, std::span<const double> rejections,
                             std::uint32_t levels);

/// Divides each gap of the ladder into steps_per_level equal steps.
std::vector<double> finer(std::span<const double> ladder, std::uint32_t steps_per_level);

/// Returns the number of round trips per scan, summed over all replicas.
double predicted_round_trip_rate(std::span<const double> rejections);

/// Interpolates linearly. REQUIRES: one value per level; beta within the ladder.
double interpolated(std::span<const double> ladder, std::span<const double> values, double beta);

}  // namespace sleight::sampling
