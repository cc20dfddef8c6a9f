// Reads what an archive's group /tempering records about its ladders, round by round.
//
// Idea. A ladder and its step sizes are fixed within a round. So a round's draws belong to one
// Markov chain; draws of several rounds don't. The longest round is judged; if several are equally
// long, the last of them. Each round is twice as long as the previous round. So the last round is
// the longest, unless the run ended in its first half.
//
// Scans are numbered as in the run. Draws are counted from the first round on. The scans of
// simulated annealing precede the first round. The rounds of a burn-in have no draws.
//
// Archives are untrusted: invalid numbers throw ExitCode::bad_archive, and memory is limited to one
// round of one ladder. Not thread-safe, because archive::Source isn't.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/model.h"

namespace sleight::analysis {

/// No run has this many rounds, since rounds double.
inline constexpr std::uint64_t k_rounds_max = 64;
/// No ladder has this many temperatures or kinds of proposals.
inline constexpr std::uint64_t k_levels_max = 4096;
inline constexpr std::uint64_t k_kinds_max = 4096;
/// No ascent or excursion has this many temperatures, and no run has this many scans.
inline constexpr std::uint64_t k_steps_max = std::uint64_t{1} << 22;
inline constexpr std::uint64_t k_run_scans_max = std::uint64_t{1} << 52;

/// The scans of a round, the same for all ladders.
struct Round {
  std::uint64_t first_scan = 0;
  std::uint64_t scans = 0;
};

/// A ladder in one round. The hottest level comes first.
struct Ladder {
  std::vector<double> inverse_temperature;
  std::vector<double> swap_acceptance;          ///< between each level and the next: one fewer
  std::vector<double> local_barrier;            ///< NaN if the archive has none
  std::vector<std::vector<double>> acceptance;  ///< by level, by kind of proposal
};

/// Returns the rounds that every ladder has begun, in order; empty if the archive has no ladders.
/// `chains` and `draws`: the sizes of /sample_stats, for checks. No draws: rounds of a burn-in.
std::vector<Round> rounds_of(const archive::Source& source, std::uint64_t chains,
                             std::optional<std::uint64_t> draws);

/// Returns the draws of a round that is not part of a burn-in. REQUIRES: a valid round.
Round draws_of_round(std::span<const Round> rounds, std::size_t round);

/// REQUIRES: rounds isn't empty.
std::size_t judged_round(std::span<const Round> rounds);

/// Returns a number for each of the first `chains` ladders in a round, or NaN if the archive lacks
/// the number.
std::vector<double> of_ladders(const archive::Source& source, std::string_view name,
                               std::uint64_t chains, std::size_t round);
/// Returns the ladders without a round trip in this round. Their states may not have mixed.
std::vector<std::uint64_t> without_round_trip(const archive::Source& source, std::uint64_t chains,
                                              std::size_t round);

/// REQUIRES: `round` is an index into the result of rounds_of().
Ladder ladder_of(const archive::Source& source, std::uint64_t chain, std::size_t round);

/// Maximum moments of an index process (worker/sampling/index_process.h, which clients can't
/// include).
inline constexpr std::uint64_t k_moments_max = 1024;

/// The level of each replica of a ladder over time.
struct IndexProcess {
  std::vector<double> scan;                ///< of the run, ascending
  std::vector<std::vector<double>> level;  ///< by replica, by moment; 0 is the prior, NaN: no level
};

/// Returns an empty process if the archive lacks one. Archives of earlier versions lack it.
/// REQUIRES: a valid chain.
IndexProcess index_process_of(const archive::Source& source, std::uint64_t chain);

/// Returns a number for each of the first `chains` chains, or NaN if the archive lacks the number.
std::vector<double> of_chains(const archive::Source& source, std::string_view name,
                              std::uint64_t chains);

/// Returns a chain's row along a dimension; empty if the archive has no such table.
std::vector<double> row_of_chain(const archive::Source& source, std::string_view name,
                                 std::string_view dimension, std::uint64_t chain);

/// Visits a table over (chain, draw), if it exists.
void for_each_of_draws(const archive::Source& source, std::string_view name,
                       const std::function<void(double)>& visit);

/// Returns the number of free islands per chain, from a table over (chain, island). Returns nothing
/// if the archive has no such table.
std::optional<std::uint64_t> islands_of_chain(const archive::Source& source, std::string_view name,
                                              std::uint64_t chains);

/// The islands `first` .. `end` - 1 of each chain. No end: all.
struct IslandRange {
  std::uint64_t first = 0;
  std::optional<std::uint64_t> end{};
};

/// Visits the entries of these islands, chain after chain. Entries are logs of estimates: -infinity
/// or finite. REQUIRES: islands_of_chain() returns at least `first`.
void for_each_of_islands(const archive::Source& source, std::string_view name, IslandRange islands,
                         const std::function<void(double)>& visit);

/// Returns an island number. The number is stored for each chain. It must be the same for all
/// chains and at most `islands`. Nothing without the table.
std::optional<std::uint64_t> island_of_all(const archive::Source& source, std::string_view name,
                                           std::uint64_t chains, std::uint64_t islands);

/// Returns the names of the kinds of proposals from /sample_stats.
std::vector<std::string> proposal_kinds(const archive::Source& source);

/// Returns the log probability that a draw from the prior is a natural throw. Default: 0.
double log_natural_throw(const archive::Source& source);

}  // namespace sleight::analysis
