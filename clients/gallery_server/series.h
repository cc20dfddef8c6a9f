// What can be plotted of an archive, as columns: the chains' numbers, what ladders learnt, prior
// against posterior.
//
// Kinds of plots:
//   trace   a number along a chain. Head: chain, chains, draws, unit, is_thinned. Columns: "draw"
//           and "value", and marks, by draw: "change_all" (an accepted proposal that changes
//           everything), "fall" (the first draw that doesn't satisfy behind one that does),
//           "lineage" (another visit to the prior than the draw before)
//   levels  along a ladder's rounds. Columns: "round", "level", "inverse_temperature",
//           "swap_acceptance" (with the next cooler one; NaN at the last), and for each kind of
//           proposal its acceptance: "acceptance.0" ...; head: kinds
//   rounds  numbers of a ladder by round. Columns: "round", "round_trips",
//           "predicted_round_trips", "restarts", "barrier"
//   pair    prior against posterior, as two histograms over the same bins. Columns: "edges",
//           "prior", "posterior" (shares; of weighted draws by their weights). Head: unit,
//           is_weighted
//   table   the answer of /diagnosis
//
// Functions throw base::Error where the archive is damaged, Refused where there is no such series.
#pragma once

#include <string>
#include <string_view>

#include "clients/gallery_server/snapshot.h"
#include "common/json/value.h"

namespace sleight::gallery {

/// Points of a trace that are sent whole; longer ones are thinned, extremes kept.
inline constexpr std::size_t k_series_points_max = 2'000'000;
inline constexpr std::size_t k_bins = 60;

/// [{"name", "title", "kind", "group"}]; none where there are no draws, or more than
/// k_counted_draws_max.
json::Value series_titles(const Snapshot& snapshot);

/// One of them (packed.h). `chain`: a number, as text.
std::string series_of(const Snapshot& snapshot, std::string_view name, std::string_view chain);

}  // namespace sleight::gallery
