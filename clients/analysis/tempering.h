// What an archive's group /tempering says of its ladders, round by round.
//
// Idea. Within a round a ladder and its proposals' sizes are frozen, so the draws of one round are
// those of one Markov chain, and draws of several rounds are not. One round is judged: the longest,
// and of equals the later. Rounds double, so that is the last one, unless the run was cut in its
// first half.
//
// Scans are those of the run. Draws are counted from the first round on: scans of simulated
// annealing come before it. Where a method burns in, its rounds have no draws at all.
//
// Archives are untrusted: numbers that can't be are refused with ExitCode::bad_archive, and nothing
// larger than one round of one ladder is held. Not thread-safe, as the source isn't.
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

/// More rounds than any run can have, since they double.
inline constexpr std::uint64_t k_rounds_max = 64;
/// More temperatures, and more kinds of proposals, than any ladder has.
inline constexpr std::uint64_t k_levels_max = 4096;
inline constexpr std::uint64_t k_kinds_max = 4096;
/// More temperatures than any ascent or excursion goes through, and more scans than any run has.
inline constexpr std::uint64_t k_steps_max = std::uint64_t{1} << 22;
inline constexpr std::uint64_t k_run_scans_max = std::uint64_t{1} << 52;

/// Scans that all ladders have in a round.
struct Round {
  std::uint64_t first_scan = 0;
  std::uint64_t scans = 0;
};

/// One ladder in one round, hottest level first.
struct Ladder {
  std::vector<double> inverse_temperature;
  std::vector<double> swap_acceptance;          ///< of each level with the next: one fewer
  std::vector<double> local_barrier;            ///< NaN where the archive has none
  std::vector<std::vector<double>> acceptance;  ///< by level, by kind of proposal
};

/// Rounds that every ladder has scans of, in order; empty where the archive has no ladders.
/// `chains`, `draws`: of /sample_stats, which they must fit; no draws: they are a burn-in's.
std::vector<Round> rounds_of(const archive::Source& source, std::uint64_t chains,
                             std::optional<std::uint64_t> draws);

/// A round's draws, where it is no burn-in's. REQUIRES: one of these rounds.
Round draws_of_round(std::span<const Round> rounds, std::size_t round);

/// Index of the round that is judged. REQUIRES: rounds not empty.
std::size_t judged_round(std::span<const Round> rounds);

/// A number of each of the first `chains` ladders in a round; NaN where the archive has none.
std::vector<double> of_ladders(const archive::Source& source, std::string_view name,
                               std::uint64_t chains, std::size_t round);
/// The ladders that made no round trip in a round: their states are on their way yet.
std::vector<std::uint64_t> without_round_trip(const archive::Source& source, std::uint64_t chains,
                                              std::size_t round);

/// REQUIRES: the round is one of rounds_of.
Ladder ladder_of(const archive::Source& source, std::uint64_t chain, std::size_t round);

/// Most moments of an index process (worker/sampling/index_process.h, which this side can't see).
inline constexpr std::uint64_t k_moments_max = 1024;

/// At which level each replica of a ladder was.
struct IndexProcess {
  std::vector<double> scan;                ///< of the run, ascending
  std::vector<std::vector<double>> level;  ///< by replica, by moment; 0 is the prior, NaN: at none
};

/// Empty where the archive says nothing of it, as those of earlier versions. REQUIRES: one of its
/// chains.
IndexProcess index_process_of(const archive::Source& source, std::uint64_t chain);

/// A number of each of the first `chains` chains; NaN where the archive has none.
std::vector<double> of_chains(const archive::Source& source, std::string_view name,
                              std::uint64_t chains);

/// A chain's row over such a dimension; empty where the archive has no such table.
std::vector<double> row_of_chain(const archive::Source& source, std::string_view name,
                                 std::string_view dimension, std::uint64_t chain);

/// Visits a table over (chain, draw), if it is there.
void for_each_of_draws(const archive::Source& source, std::string_view name,
                       const std::function<void(double)>& visit);

/// Free islands of each chain in a table over (chain, island) of `chains` chains; none where the
/// archive has no such table.
std::optional<std::uint64_t> islands_of_chain(const archive::Source& source, std::string_view name,
                                              std::uint64_t chains);

/// Islands of each chain from `first` on and before `end`, which is all where it is left out.
struct IslandRange {
  std::uint64_t first = 0;
  std::optional<std::uint64_t> end{};
};

/// Visits these entries of each chain, chain after chain: logs of estimates, which are -infinity or
/// finite. REQUIRES: islands_of_chain has some, and `first` of them at least.
void for_each_of_islands(const archive::Source& source, std::string_view name, IslandRange islands,
                         const std::function<void(double)>& visit);

/// The number of an island in a table by chain, the same for each chain and at most `islands`; none
/// without the table.
std::optional<std::uint64_t> island_of_all(const archive::Source& source, std::string_view name,
                                           std::uint64_t chains, std::uint64_t islands);

/// Names of the kinds of proposals, as /sample_stats has them.
std::vector<std::string> proposal_kinds(const archive::Source& source);

/// Log of the probability that a draw from the prior is a natural throw: 0 where nothing is said.
double log_natural_throw(const archive::Source& source);

}  // namespace sleight::analysis
