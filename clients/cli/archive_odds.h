// What `sleight archive info` says of log Z and of the odds of a blind throw: an archive's own
// estimates, of its ladders or of its weighted ascents.
//
// Archives are untrusted, as in tempering.h. Not thread-safe, as the source isn't.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "clients/cli/throw_odds.h"
#include "common/archive/model.h"
#include "common/archive/summary.h"

namespace sleight::cli {

/// What the ladders of a tempered run estimate, or its weighted ascents.
struct ArchiveOdds {
  bool weighted = false;  ///< of the ascents: then no round is told
  bool burn_in = false;   ///< the rounds are a burn-in's
  std::size_t rounds = 0;
  std::size_t judged = 0;  ///< the round that log_z is of
  CombinedEstimate log_z;
  std::size_t satisfied_round = 0;   ///< the round that log_p_satisfied is of
  CombinedEstimate log_p_satisfied;  ///< of no ladder: nothing ever satisfied
  std::size_t without_trips = 0;     ///< ladders of that round that made no round trip
  double log_natural_throw = 0;
};

/// None where the archive has neither ladders nor weights.
std::optional<ArchiveOdds> odds_of(const archive::Source& source, const archive::Summary& summary);

/// Lines for people. `chains`: that the archive has.
std::string in_words(const ArchiveOdds& odds, std::uint64_t chains);

/// Numbers that are not known are null.
nlohmann::ordered_json as_json(const ArchiveOdds& odds);

}  // namespace sleight::cli
