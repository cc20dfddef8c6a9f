// Ladders of inverse temperatures, and what the swaps between neighbours tell about them (Syed,
// Bouchard-Cote, Deligiannidis, Doucet 2022, Non-reversible parallel tempering: a scalable highly
// parallel MCMC scheme).
//
// Idea. With r_i the rejection rate of swaps between levels i and i+1, the sum of r_i up to a level
// estimates the communication barrier Lambda(beta) there, whatever the ladder is; its slope, the
// local barrier, says where temperatures must lie close. A ladder is best when all r_i are equal:
// its levels cut the barrier into equal parts. Round trips per scan are then
//
//   1 / (2 + 2 sum of r_i / (1 - r_i)),
//
// if exploration at each level forgets enough between two swaps.
//
// A ladder is ascending, from 0 (the prior) to 1. Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sleight::sampling {

/// The power of first_ladder with which the hottest of a dozen levels are hot enough for narrow
/// constraints. Too hot costs a level; too cold costs rounds: a gap that rejects all swaps counts
/// as a barrier of 1, so respacing only halves it or so in each.
inline constexpr std::uint32_t k_first_power = 6;

/// What a run begins with, before anything is known: (i / (levels - 1))^power. With 1, steps are
/// equal, and the first states come down from the prior most quickly. REQUIRES: 2 levels at least;
/// a power above 0 and below 64, as the least level must stay above 0.
std::vector<double> first_ladder(std::uint32_t levels, std::uint32_t power = k_first_power);

/// The inverse temperatures of scans of simulated annealing from the prior to `target`:
/// target * scan / anneal_scans, for scans first_scan to first_scan + scans - 1. The target itself
/// is first reached by the scan after them.
std::vector<double> annealing(double target, std::uint64_t anneal_scans, std::uint64_t first_scan,
                              std::uint64_t scans);

/// The smallest and greatest number of levels of any ladder; LadderOptions::levels_max may set a
/// lower limit to those that a run chooses.
inline constexpr std::uint32_t k_levels_min = 2;
inline constexpr std::uint32_t k_levels_max = 256;

/// Twice the barrier, and one: then neighbours swap about every second time.
std::uint32_t levels_for(double barrier);

/// The communication barrier up to each level: 0 at the first, the whole one at the last.
/// `rejections`: between each level and the next.
std::vector<double> cumulative_barrier(std::span<const double> rejections);

/// The local barrier at each level: the slope of a monotone cubic (Fritsch and Carlson 1980)
/// through the cumulative barrier.
std::vector<double> local_barrier(std::span<const double> ladder,
                                  std::span<const double> rejections);

/// A ladder of so many levels that cut the cumulative barrier (the cubic of local_barrier) into
/// equal parts, so that swaps are rejected equally often. No two levels fall together: rates of 0
/// count as a small one. REQUIRES: levels from k_levels_min to k_levels_max; one rate for each gap.
std::vector<double> respaced(std::span<const double> ladder, std::span<const double> rejections,
                             std::uint32_t levels);

/// The same ladder with so many equal steps from each level to the next.
std::vector<double> finer(std::span<const double> ladder, std::uint32_t steps_per_level);

/// Round trips per scan, of all replicas together.
double predicted_round_trip_rate(std::span<const double> rejections);

/// A curve's value at `beta`, straight between the ladder's levels. REQUIRES: one value for each
/// level; beta from the first level to the last.
double interpolated(std::span<const double> ladder, std::span<const double> values, double beta);

}  // namespace sleight::sampling
