// Exports archives as CSV, for people and for programs that can't read HDF5.
//
// A table has one row per index, and one column per scalar or array element.
//   posterior, sample_stats   a row for each (chain, draw)
//   replicas                  a row for each (chain, replica)
//   animations                a row for each animation
//   segments                  a row for each segment of the kept animations
//   finds, find_segments      the same for finds of a search
//   prior, sample_stats_prior a row for each draw from the prior
//   features, parts           a row for each feature or part of the scene description
//   points, find_points       a row for each control point of an animation's surface
// The first columns contain the coordinates of the index. An array element's column is `name[i,j]`,
// double-quoted if the name contains a comma (RFC 4180). If a dimension's coordinate is text, a
// word replaces the number: `accepted[all]`. A double is written as the shortest decimal that reads
// back to the same bits. Not-a-number is written as nan, the infinities as inf and -inf, and
// booleans as 0 and 1.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/model.h"

namespace sleight::archive {

std::vector<std::string> csv_tables();

/// Writes one table in batches. If `animations` is not empty, tables of animations, segments or
/// points contain only these animations' rows, in the given order. The caller must check the
/// stream's state afterwards. Throws base::Error(usage) if csv_tables() lacks `table`, or if the
/// table lacks one of `animations`. Throws base::Error(bad_archive) if the archive is damaged or
/// lacks the table's group.
void export_csv(const Source& source, std::string_view table, std::ostream& out,
                std::span<const std::uint64_t> animations = {});

}  // namespace sleight::archive
