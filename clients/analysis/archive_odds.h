// What `sleight archive info` says of log Z and of the odds of a blind throw: an archive's own
// estimates, of its ladders, its weighted ascents or its free islands, with an error only where
// nothing speaks against it (odds_doubts.h).
//
// The odds are those of a natural throw, which need not be a draw from the prior: for words the
// prior drops each ball by chance, and a throw drops all of them (WorldLayout::log_natural_throw).
// People are shown log P of the throw alone; machines get both.
//
// Archives are untrusted, as in tempering.h. Not thread-safe, as the source isn't.
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
  CombinedEstimate all;       ///< of no ladder: nothing satisfied
  std::size_t round = 0;      ///< that it is of, counted from 0
  std::vector<Doubt> doubts;  ///< none: its error can be trusted

  bool known() const { return doubts.empty() && all.error_from != ErrorFrom::unknown; }
};

/// How to come to know what is doubted.
struct HowToKnow {
  double longer = 1;      ///< so many times as long a round, or as many weighted draws or islands
  bool at_least = false;  ///< of it
  /// So many rounds of each ladder in all, and their scans; none for weighted draws and islands.
  std::optional<std::uint32_t> rounds{};
  std::optional<std::uint64_t> scans{};
  std::optional<double> odds{};  ///< of islands: the rule in [stop] that sizes them
  std::string besides{};         ///< other keys that help, for people; may be empty
};

/// Whose estimates they are.
enum class OddsFrom : std::uint8_t {
  ladders,
  burn_in,  ///< of ladders too
  weights,  ///< of ascents: no round is told, chains take the ladders' place
  islands,  ///< no round is told, islands take the ladders' place
};

struct ArchiveOdds {
  OddsFrom from = OddsFrom::ladders;
  std::size_t rounds = 0;
  std::size_t judged = 0;  ///< the round whose ladders are doubted, counted from 0
  JudgedEstimate log_z{};
  /// That a draw from the prior satisfies. Of another round where nothing satisfied in the judged
  /// one; then it is doubted.
  JudgedEstimate log_p_satisfied{};
  std::size_t without_trips = 0;  ///< ladders of the judged round that made no round trip
  double log_natural_throw = 0;
  std::string natural_throw{};  ///< what a throw is, if no draw: "a throw includes all bodies"
  std::optional<HowToKnow> how_to_know{};  ///< none where log P is known
  IslandNumber island_number = IslandNumber::unknown;
  /// Of each chain: those from here on count, which were sized; or those before, which were made in
  /// any case.
  std::optional<std::uint64_t> odds_from_island{};
  std::optional<std::uint64_t> odds_until_island{};
};

/// None where the archive has neither ladders nor weights nor islands.
std::optional<ArchiveOdds> odds_of(const archive::Source& source, const archive::Summary& summary);

/// Adds `tempering`, and lines for people.
void add_odds(const ArchiveOdds& odds, report::Report& report);

/// Numbers that are not known are null.
json::Value as_json(const ArchiveOdds& odds);

}  // namespace sleight::analysis
