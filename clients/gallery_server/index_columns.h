// The index of animations (clients/browse/index.h) as columns. Saved pages, which have no server,
// search and group with it.
//
// Keys of the head:
//
//    "generation", "run", "entries", "bodies", "view_low_m", "view_high_m", "names",
//    "numbers" [{"name", "unit"}], "features" [{"name", "kind", "twin_of", "body"}].
//
// Columns by name, type, meaning and number of rows, for n entries of b bodies:
//
//    "is_find" u8, "chain" u32, "draw", "lineage", "end_s" f64, "in_proportion" u8      (n);
//    "number.K" f64 for each number                                                     (n);
//    "track_first", "track_count" u32: rows of pieces, by entry, then by body           (n * b);
//    "piece_start_s" f64, "piece_position_m", "piece_velocity_mps" f64 x 3              (pieces);
//    "piece_acceleration" u32: row of "accelerations_mps2"                              (pieces);
//    "accelerations_mps2" f64 x 3: distinct accelerations, of which there are few;
//    "satisfied_draws" f64, only if draws are in proportion: number of satisfied draws
//      that are assigned to the entry (shares.h)                                        (n);
//    "contact_first" u32: row of the entry's first contact                              (n + 1);
//    "contact_time_s" f64, "contact_body", "contact_partner" u32                        (contacts).
//
// Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "clients/browse/index.h"

namespace sleight::gallery {

/// `satisfied_draws`: one number per entry, or empty to omit the column. REQUIRES: at most 2^32
/// pieces and contacts.
std::string index_columns(const browse::Index& index, std::uint64_t generation,
                          std::span<const double> satisfied_draws = {});

}  // namespace sleight::gallery
