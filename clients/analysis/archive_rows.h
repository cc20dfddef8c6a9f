// Numbers out of an archive's datasets. Archives are untrusted: a dataset that is missing or has
// another shape is refused with ExitCode::bad_archive.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/model.h"

namespace sleight::analysis {

/// Draws read at a time.
inline constexpr std::uint64_t k_batch = 65536;

/// Throws base::Error(usage) when the archive has no such chain.
void check_chain(const archive::Source& source, std::uint64_t chain);

/// Size of a dimension of /sample_stats.
std::uint64_t stats_size(const archive::Source& source, std::string_view dimension);

/// Throws unless /sample_stats has a number of this variable for each chain and draw.
void check_series(const archive::Source& source, std::string_view variable);

/// Names of the world's outcome scalars, in order.
std::vector<std::string> outcome_names(const archive::Source& source);

/// Numbers and flags as doubles; nothing of text.
std::vector<double> as_doubles(const archive::Values& values);

struct Rows {
  std::uint64_t first = 0;
  std::uint64_t count = 0;
};

/// Rows of a dataset of doubles or integers, as doubles. Throws base::Error(bad_archive) when the
/// dataset is missing, of another shape than (rows, ...) with so many numbers to a row, (rows)
/// alone for one number, or has no such rows.
std::vector<double> read_rows(const archive::Source& source, std::string_view group,
                              std::string_view dataset, std::uint64_t columns, const Rows& rows);

}  // namespace sleight::analysis
