// Archives as CSV, for people and for programs that read nothing else.
//
// A table is wide: one row for each index, one column for each scalar or element.
//   posterior, sample_stats   a row for each (chain, draw)
//   replicas                  a row for each (chain, replica)
//   animations                a row for each animation
//   segments                  a row for each segment of the kept animations
//   finds, find_segments      likewise of what a search found
//   prior, sample_stats_prior a row for each draw from the prior
//   features, parts           a row for each of the scene's
//   points, find_points       a row for each control point of an animation's surface
// The first columns are the index, by its coordinates. An element of an array is `name[i,j]`, in
// double quotes where the name holds a comma (RFC 4180); along a dimension whose coordinate is
// text the word stands for the number: `accepted[all]`. Doubles are the shortest decimal that
// reads back to the same bits; nan, inf and -inf are spelled so; booleans are 0 and 1.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/model.h"

namespace sleight::archive {

/// Their names.
std::vector<std::string> csv_tables();

/// Writes one table, in batches; of one over animations, segments or points only the rows of
/// `animations`, in their order, where there are any. The caller checks the stream's state at the
/// end. Throws base::Error: usage when `table` is none of csv_tables() or has no such animation,
/// bad_archive when the archive has no such group or is damaged.
void export_csv(const Source& source, std::string_view table, std::ostream& out,
                std::span<const std::uint64_t> animations = {});

}  // namespace sleight::archive
