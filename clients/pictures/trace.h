// Reads series from an archive: one scalar of /sample_stats along a chain.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "clients/plot/figure.h"
#include "common/archive/model.h"

namespace sleight::pictures {

/// Maximum number of points that a picture shows of a series. Longer series are thinned while they
/// are read.
inline constexpr std::size_t k_trace_points_max = 20'000;

struct TraceRange {
  std::uint64_t chain = 0;
  std::uint64_t draws = 0;  ///< number of first draws; 0: all
  std::size_t points_max = k_trace_points_max;
};

/// Returns the points (draw, value * scale) of a variable over (chain, draw). If the chain is
/// longer than `points_max`, only the first, lowest, highest and last point of each stretch remain,
/// so spikes stay and memory is limited. Throws base::Error: usage if there is no such chain,
/// bad_archive if there is no such variable.
std::vector<plot::Point> trace(const archive::Source& source, std::string_view variable,
                               const TraceRange& range, double scale);

/// Returns the requested chain, or the first six. Throws base::Error(usage) if the archive has no
/// such chain.
std::vector<std::uint64_t> chains_to_draw(const archive::Source& source,
                                          std::optional<std::uint64_t> asked);

}  // namespace sleight::pictures
