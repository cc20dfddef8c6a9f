// Reads the per-chain results of methods with a burn-in from an archive's group /tempering: walks
// of simulated tempering, tempered transitions, weighted ascents.
//
// Archives are untrusted (see tempering.h). Not thread-safe, because archive::Source isn't.
#pragma once

#include <cstdint>
#include <vector>

#include "clients/analysis/throw_odds.h"
#include "common/archive/model.h"

namespace sleight::analysis {

/// A chain's walk over levels. The hottest level comes first.
struct WalkReport {
  double round_trips = 0;
  std::vector<double> inverse_temperature;
  std::vector<double> visits;      ///< scans at each level
  std::vector<double> acceptance;  ///< of moves to the next level and back; NaN at the last level
};

struct TransitionReport {
  double acceptance = 0;
  double levels = 0;  ///< levels below inverse temperature 1
};

struct AscentReport {
  double effective_size = 0;
  double steps = 0;  ///< scans of an ascent, including the prior draw
  LogEstimate log_z;
  LogEstimate log_p_satisfied;
};

/// Read the first `chains` chains. Fields are NaN or empty if the archive lacks their table.
std::vector<WalkReport> walks_of(const archive::Source& source, std::uint64_t chains);
std::vector<TransitionReport> transitions_of(const archive::Source& source, std::uint64_t chains);
std::vector<AscentReport> ascents_of(const archive::Source& source, std::uint64_t chains);

/// Returns (sum w)^2 / sum w^2 over the draws of all chains; NaN if a weight is invalid.
double effective_size_of_all(const archive::Source& source);

}  // namespace sleight::analysis
