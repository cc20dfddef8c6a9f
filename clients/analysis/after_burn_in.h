// What an archive's group /tempering says of the methods that go on after a burn-in, chain by
// chain: simulated tempering's walk over levels, tempered transitions, weighted ascents.
//
// Archives are untrusted, as in tempering.h. Not thread-safe, as the source isn't.
#pragma once

#include <cstdint>
#include <vector>

#include "clients/analysis/throw_odds.h"
#include "common/archive/model.h"

namespace sleight::analysis {

/// A chain's walk over levels, hottest first.
struct WalkReport {
  double round_trips = 0;
  std::vector<double> inverse_temperature;
  std::vector<double> visits;      ///< scans at the level
  std::vector<double> acceptance;  ///< of moves to the next level and back; NaN at the last
};

/// A chain's tempered transitions.
struct TransitionReport {
  double acceptance = 0;
  double levels = 0;  ///< below inverse temperature 1
};

/// A chain's ascents.
struct AscentReport {
  double effective_size = 0;
  double steps = 0;  ///< scans of an ascent, the draw from the prior among them
  LogEstimate log_z;
  LogEstimate log_p_satisfied;
};

/// Of the first `chains` chains. NaN, and nothing, where the archive has no such table.
std::vector<WalkReport> walks_of(const archive::Source& source, std::uint64_t chains);
std::vector<TransitionReport> transitions_of(const archive::Source& source, std::uint64_t chains);
std::vector<AscentReport> ascents_of(const archive::Source& source, std::uint64_t chains);

/// (sum w)^2 / sum w^2 over the draws of all chains; NaN where a weight can't be.
double effective_size_of_all(const archive::Source& source);

}  // namespace sleight::analysis
