// Reads numbers from an archive's datasets. Archives are untrusted: a missing dataset or an
// unexpected shape throws ExitCode::bad_archive.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/model.h"

namespace sleight::analysis {

inline constexpr std::uint64_t k_batch = 65536;

/// Throws base::Error(usage) if the archive has no such chain.
void check_chain(const archive::Source& source, std::uint64_t chain);

std::uint64_t stats_size(const archive::Source& source, std::string_view dimension);

/// Throws unless /sample_stats has this variable for each chain and draw.
void check_series(const archive::Source& source, std::string_view variable);

/// Returns the names of the world's outcome scalars, in order.
std::vector<std::string> outcome_names(const archive::Source& source);

/// Returns numbers and flags as doubles. Returns nothing for text.
std::vector<double> as_doubles(const archive::Values& values);

struct Rows {
  std::uint64_t first = 0;
  std::uint64_t count = 0;
};

/// Reads rows of a dataset of doubles or integers, as doubles. Throws base::Error(bad_archive) if
/// the dataset or the rows are missing, or if the shape isn't (rows, ...) with `columns` numbers
/// per row. With one column, the shape may also be (rows).
std::vector<double> read_rows(const archive::Source& source, std::string_view group,
                              std::string_view dataset, std::uint64_t columns, const Rows& rows);

}  // namespace sleight::analysis
