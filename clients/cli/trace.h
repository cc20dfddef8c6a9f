// Series out of an archive: one scalar of /sample_stats along one chain.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clients/plot/figure.h"
#include "common/archive/model.h"

namespace sleight::cli {

struct TraceRange {
  std::uint64_t chain = 0;
  std::uint64_t draws = 0;  ///< the first so many; 0 for all
};

/// (draw, value * scale) of a double variable with dims (chain, draw). Throws base::Error(usage)
/// when the archive has no such chain, bad_archive when it has no such variable.
std::vector<plot::Point> trace(const archive::Source& source, std::string_view variable,
                               const TraceRange& range, double scale);

/// Size of a dimension of /sample_stats.
std::uint64_t stats_size(const archive::Source& source, std::string_view dimension);

/// Names of the world's outcome scalars, in order.
std::vector<std::string> outcome_names(const archive::Source& source);

/// A whole dataset of doubles or integers, as doubles.
std::vector<double> read_numbers(const archive::Source& source, std::string_view group,
                                 std::string_view dataset);

}  // namespace sleight::cli
