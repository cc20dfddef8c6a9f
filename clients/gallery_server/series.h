// Plots of an archive as columns: numbers along chains, the ladders' rounds and levels, and prior
// and posterior.
//
// Kinds of plots:
//
//   `trace`: a number along a chain. Keys of the head: chain, chains, draws, unit, is_thinned.
//     Columns with all points: "draw" and "value". Columns with marked draws: "change_all" (an
//     accepted proposal that changes all variables), "fall" (a draw that doesn't satisfy the
//     constraint, after one that does), "lineage" (the draw has another lineage than the previous
//     draw).
//   `levels`: numbers by a ladder's rounds and levels. Key of the head: kinds. Columns are "round",
//     "level", "inverse_temperature", "swap_acceptance" (with the next cooler level, NaN at the
//     last level), and each kind of proposal's acceptance, "acceptance.0" and so on.
//   `rounds`: numbers by a ladder's rounds. Columns are "round", "round_trips",
//     "predicted_round_trips", "restarts", "barrier".
//   `index`: the level of each replica over time. Key of the head: replicas. Columns are "scan",
//     "level.0" and so on, and "round" (first scans of rounds).
//   `pair`: prior and posterior, as two histograms with the same bins. Keys of the head: unit,
//     is_weighted. Columns are "edges", "prior", "posterior" (shares, by weight if draws are
//     weighted).
//   `table`: the answer of /diagnosis.
//
// Functions throw base::Error if the archive is damaged, and Refused if the plot doesn't exist.
#pragma once

#include <string>
#include <string_view>

#include "clients/gallery_server/snapshot.h"
#include "common/json/value.h"

namespace sleight::gallery {

/// Maximum number of points of a trace; longer ones are thinned, with extremes kept.
inline constexpr std::size_t k_series_points_max = 2'000'000;
inline constexpr std::size_t k_bins = 60;

/// [{"name", "title", "kind", "group"}]; empty if there are no draws, or more than
/// k_counted_draws_max.
json::Value series_titles(const Snapshot& snapshot);

/// One plot's data (packed.h). `chain`: a number, as text.
std::string series_of(const Snapshot& snapshot, std::string_view name, std::string_view chain);

}  // namespace sleight::gallery
