// Log Z and the odds of a blind throw, as `sleight archive info` reports them. The estimates come
// from an archive's ladders, weighted ascents or free islands. An estimate has an error only if
// there are no doubts (odds_doubts.h).
//
// The odds apply to a natural throw, which isn't always a draw from the prior. For example, the
// spelling prior drops each ball by chance, but a throw drops all balls
// (WorldLayout::log_natural_throw). Text shows only the throw's log P; JSON also shows the draw's
// log P.
//
// Archives are untrusted (see tempering.h). Not thread-safe, because archive::Source isn't.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/analysis/odds_doubts.h"
#include "clients/analysis/throw_odds.h"
#include "clients/report/report.h"
#include "common/archive/model.h"
#include "common/archive/summary.h"
#include "common/json/value.h"

namespace sleight::analysis {

struct JudgedEstimate {
  CombinedEstimate all;       ///< without ladders if nothing satisfied
  std::size_t round = 0;      ///< the estimate's round, counted from 0
  std::vector<Doubt> doubts;  ///< empty: the error can be trusted

  bool known() const { return doubts.empty() && all.error_from != ErrorFrom::unknown; }
};

/// Changes that would remove the doubts about a run's odds.
struct HowToKnow {
  double longer = 1;      ///< factor for the length of a round or the number of draws or islands
  bool at_least = false;  ///< `longer` is a lower bound
  /// Total rounds of each ladder, and their scans; empty for weighted draws and islands.
  std::optional<std::uint32_t> rounds{};
  std::optional<std::uint64_t> scans{};
  std::optional<double> odds{};  ///< islands: the rule in [stop] that determines their number
  std::string besides{};         ///< for people: other keys that help; may be empty
};

enum class OddsFrom : std::uint8_t {
  ladders,
  burn_in,  ///< ladders of a burn-in
  weights,  ///< ascents: chains stand for ladders, and rounds aren't reported
  islands,  ///< islands stand for ladders, and rounds aren't reported
};

struct ArchiveOdds {
  OddsFrom from = OddsFrom::ladders;
  std::size_t rounds = 0;
  std::size_t judged = 0;  ///< the round whose ladders are judged, counted from 0
  JudgedEstimate log_z{};
  /// Probability that a draw from the prior satisfies the constraint. If the judged round has no
  /// solution, the estimate comes from another round and is doubted.
  JudgedEstimate log_p_satisfied{};
  std::size_t without_trips = 0;  ///< ladders of the judged round without a round trip
  double log_natural_throw = 0;
  std::string natural_throw{};             ///< how a throw differs from a draw; may be empty
  std::optional<HowToKnow> how_to_know{};  ///< none if log P is known
  IslandNumber island_number = IslandNumber::unknown;
  /// If either number is set, estimates use only some of each chain's islands: islands from
  /// odds_from_island on (the sized batch), or islands before odds_until_island. Islands before
  /// odds_until_island are made whatever the results are.
  std::optional<std::uint64_t> odds_from_island{};
  std::optional<std::uint64_t> odds_until_island{};
};

/// Returns nothing if the archive has no ladders, weights or islands.
std::optional<ArchiveOdds> odds_of(const archive::Source& source, const archive::Summary& summary);

/// Adds the key `tempering`, and lines for people.
void add_odds(const ArchiveOdds& odds, report::Report& report);

/// Unknown numbers are null.
json::Value as_json(const ArchiveOdds& odds);

}  // namespace sleight::analysis
