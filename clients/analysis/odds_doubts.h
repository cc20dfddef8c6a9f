// Doubts: reasons why an estimate of log Z or odds gets no error, and what would help.
//
// Idea. If a ladder has not mixed, its log Z is wrong, but the error is small. The ladder's
// stepping stones and their jackknife use only the states that were found. In an unmixed ladder,
// the cold levels still hold their first states. So log Z is usually too low, and neither the
// errors nor the spread of ladders show this. Therefore an estimate has an error only if the judged
// round shows that its ladders have mixed. The reasons for doubt are:
//
//   `no_value`: a ladder has no estimate, because it found no solution. Leaving the ladder out
//     would bias the result.
//   `few_round_trips`: only round trips bring new states from the prior to inverse temperature 1.
//     Without round trips, the cold levels hold the first states (Syed et al. 2022). Each ladder
//     needs k_trips_each round trips, because other ladders' trips don't remove its bias from the
//     mean. All ladders together need k_renewals_in_all round trips, because errors estimated from
//     fewer are too inaccurate.
//   `first_round`: the round begins with prior draws at all temperatures. These draws may still
//     matter, and no earlier round exists to compare with.
//   `rounds_disagree`: the previous round is half as long and has a different estimate, so the
//     estimate still drifts.
//   `wide`: a ladder's log estimate has an error above k_spread_max. The mean of logs is then too
//     low by more than half of k_spread_max, and errors are unreliable.
//   `ladders_disagree`: the ladders differ by more than expected from their own errors, so each
//     ladder has missed some states.
//
// The constants were chosen on worlds with known odds. On these worlds, the errors cover the truth
// as often as they should (tests/statistical/odds_test.cpp).
//
// Weighted ascents are independent. The mean weight of ascents is unbiased for any burn-in. Ascents
// are doubted if their effective size is too small, if a single chain's error is too large, or if
// chains disagree.
//
// Free islands are independent too, and each estimate is unbiased. The reasons for doubt are:
//
//   `heavy_tail`: one island has more than a tenth of the sum. The mean and its error then likely
//     miss islands that are even larger.
//   `few_particles`: an island has fewer than 16 particles. Such islands usually miss the large
//     weights that dominate the mean, and then resemble each other.
//   `not_sized`: the number of islands depended on their results. The run ended at a number of
//     solutions, which come from large islands, or before the odds were precise enough. The number
//     is trusted if `scans` or `rounds` fixed it in advance, or if `odds` chose it from earlier
//     islands. Those earlier islands aren't counted.
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "clients/analysis/throw_odds.h"
#include "common/math/island_odds.h"

namespace sleight::analysis {

/// Round trips needed per ladder. If a round is only as long as a mean round trip, the chance of
/// this many trips is 1 in 270 (Poisson distribution, mean 1). So a round with this many trips is
/// several times as long as a round trip.
inline constexpr double k_trips_each = 5;
/// Round trips needed over all ladders. A standard deviation estimated from this many is accurate
/// to 11%. The effective size of weighted draws needs the same minimum.
inline constexpr double k_renewals_in_all = 40;
/// Maximum standard deviation of one ladder's log estimate. At 1, the mean of logs is below the log
/// of the mean by 0.5, half the variance. The standard error of four ladders is as large.
inline constexpr double k_spread_max = 1;
/// Maximum difference between two rounds, in standard errors of the difference.
inline constexpr double k_drift_max = 3;
/// Minimum particles per island. docs/MEASUREMENTS ("Intervals by islands") has the measurements.
inline constexpr double k_particles_min = 16;
/// Maximum spread of the ladders, divided by the spread expected from their own errors.
inline constexpr double k_disagreement_max = 3;
enum class DoubtOf : std::uint8_t {
  no_value,
  few_round_trips,
  few_draws,  ///< weighted draws: the effective size is too small
  first_round,
  rounds_disagree,
  wide,
  ladders_disagree,
  heavy_tail,     ///< islands
  few_particles,  ///< islands
  not_sized,      ///< islands
};

struct Doubt {
  DoubtOf kind{};
  std::string reason{};  ///< for people: one line without a capital and a full stop
  /// If the round's length or the number of weighted draws is multiplied by this factor, the doubt
  /// will likely disappear.
  double longer = 2;
  bool at_least = false;  ///< `longer` is a lower bound, since no measurement shows the factor
};

struct LadderFacts {
  std::vector<LogEstimate> judged;
  std::vector<LogEstimate> before;  ///< estimates in the previous round; empty if there is none
  std::vector<double> round_trips;  ///< in the judged round
  std::string round;                ///< such as "round 7 of 7"
};

/// Returns no doubts if the estimate can be trusted. REQUIRES: one number of each kind per ladder.
std::vector<Doubt> doubts_of(const LadderFacts& facts);

/// Judges weighted draws by each chain's estimate and by the effective size of all draws.
std::vector<Doubt> doubts_of_weights(std::span<const LogEstimate> chains, double effective_size,
                                     double effective_size_min);

/// How the number of islands was chosen.
enum class IslandNumber : std::uint8_t {
  fixed,         ///< scans or rounds
  sized,         ///< by earlier islands, which don't count
  unfinished,    ///< the request asks for odds, and the sized round isn't complete
  by_solutions,  ///< the run could end by solutions
  unknown,
};

/// Judges free islands. `particles`: particles per island, if the request sets them.
std::vector<Doubt> doubts_of_islands(const math::IslandOdds& islands, IslandNumber number,
                                     std::optional<double> particles = {});

/// Returns the greatest of the doubts' factors. A run that is longer by this factor will likely
/// remove all doubts. REQUIRES: not empty.
struct Remedy {
  double longer = 1;
  bool at_least = false;
};
Remedy remedy_of(std::span<const Doubt> doubts);

}  // namespace sleight::analysis
