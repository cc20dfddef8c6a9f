// Whether an error can be given for what ladders estimate, and if not, why not and what would help.
//
// Idea. A ladder that has not mixed gives a wrong log Z with a small error: its stepping stones,
// and the jackknife over them, see only the states that are there. The cold levels then still hold
// what climbed first, in all ladders alike, so that log Z mostly comes out too low and neither
// errors nor the spread of ladders show it. So an estimate has an error only if facts of the judged
// round say that its ladders have mixed. Each of these casts a doubt:
//
//   no value          A ladder has none: nothing satisfied. To leave it out would choose by luck.
//   few round trips   A round trip is what brings a state from the prior to inverse temperature 1
//                     and away again; without them the cold levels are those of the first states
//                     (Syed et al. 2022). Each ladder needs k_trips_each: other ladders' trips
//                     don't take its bias out of the mean. All together need k_renewals_in_all:
//                     errors are only as good as the number of renewals that they are estimated
//                     from.
//   first round       It begins with draws of the prior at all temperatures, and no round before
//                     it shows whether they are forgotten.
//   rounds disagree   The round before, half as long, says something else: there is a drift yet.
//   wide              One ladder alone knows the log to no better than k_spread_max. Then the
//                     log's mean lies too low by more than half of that, and errors are worth
//                     little.
//   ladders disagree  They lie further apart than their own errors explain: each misses something
//                     that its round trips did not bring.
//
// The constants were chosen on worlds whose odds are known, where the error that is given then
// covers the truth as often as it should (tests/statistical/odds_test.cpp).
//
// Weighted ascents are independent, and their mean weight is right on average whatever their
// burn-in did. They are doubted where they are worth too few draws, where one chain alone is wide,
// or where chains disagree.
//
// Free islands are independent too, and each estimate is right on average. These cast doubts:
//
//   heavy tail  One island has more than a tenth of the sum. Then larger ones are yet to come, and
//               neither the mean nor its error knows them.
//   few particles  Islands of fewer than 16: the large ones that carry the mean mostly have not
//               come, and the others look alike.
//   not sized   What the islands said has chosen how many there are: the run ended by solutions,
//               which come of large islands, or while the odds were not known well enough. A number
//               is good if it was fixed before (scans, rounds) or chosen by earlier islands that
//               don't count themselves (odds).
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "clients/analysis/throw_odds.h"
#include "common/math/island_odds.h"

namespace sleight::analysis {

/// Of each ladder. If a round were only as long as a round trip takes (a mean of 1), chance would
/// bring this many in 1 of 270 rounds (Poisson); so the round is several times as long.
inline constexpr double k_trips_each = 5;
/// Of all ladders together: a standard deviation estimated from so many is right to 11%. Weighted
/// draws have to be worth as many draws of equal weight.
inline constexpr double k_renewals_in_all = 40;
/// Standard deviation of one ladder's log. At 1, half the variance, by which the mean of logs lies
/// below the log of the mean, is as large as the standard error of four ladders.
inline constexpr double k_spread_max = 1;
/// Standard errors of the difference that two rounds may differ by.
inline constexpr double k_drift_max = 3;
/// Of an island. The doubt was measured (docs/MEASUREMENTS, "Intervals by islands").
inline constexpr double k_particles_min = 16;
/// How many times what ladders' own errors come to their spread may be.
inline constexpr double k_disagreement_max = 3;
enum class DoubtOf : std::uint8_t {
  no_value,
  few_round_trips,
  few_draws,  ///< of weighted ones: their effective size is too small
  first_round,
  rounds_disagree,
  wide,
  ladders_disagree,
  heavy_tail,     ///< of islands
  few_particles,  ///< of islands
  not_sized,      ///< of islands
};

struct Doubt {
  DoubtOf kind{};
  std::string reason{};  ///< for people: a line without a capital and a full stop
  /// So many times as long a round, or as many weighted draws, will likely remove it.
  double longer = 2;
  bool at_least = false;  ///< of `longer`: nothing measured says how much it takes
};

/// What the judged round says of every ladder.
struct LadderFacts {
  std::vector<LogEstimate> judged;
  std::vector<LogEstimate> before;  ///< the same in the round before; empty if there is none
  std::vector<double> round_trips;  ///< in the judged round
  std::string round;                ///< "round 7 of 7"
};

/// None if the estimate can be trusted. REQUIRES: as many numbers of each kind as ladders.
std::vector<Doubt> doubts_of(const LadderFacts& facts);

/// The same of weighted draws: an estimate of each chain, and what all draws together are worth.
std::vector<Doubt> doubts_of_weights(std::span<const LogEstimate> chains, double effective_size,
                                     double effective_size_min);

/// What has chosen how many islands there are.
enum class IslandNumber : std::uint8_t {
  fixed,         ///< scans or rounds
  sized,         ///< earlier islands, which don't count
  unfinished,    ///< the odds are asked for, and the round that they size isn't complete
  by_solutions,  ///< the run could end by solutions
  unknown,
};

/// The same of free islands. `particles`: of each, where the request says it.
std::vector<Doubt> doubts_of_islands(const math::IslandOdds& islands, IslandNumber number,
                                     std::optional<double> particles = {});

/// What it takes to remove all of them: the longest. REQUIRES: not empty.
struct Remedy {
  double longer = 1;
  bool at_least = false;
};
Remedy remedy_of(std::span<const Doubt> doubts);

}  // namespace sleight::analysis
