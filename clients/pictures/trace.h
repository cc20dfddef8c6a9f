// Series out of an archive: one scalar of /sample_stats along one chain.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/plot/figure.h"
#include "common/archive/model.h"

namespace sleight::pictures {

/// Most points of one series in a picture; longer ones are thinned while they are read.
inline constexpr std::size_t k_trace_points_max = 20'000;

struct TraceRange {
  std::uint64_t chain = 0;
  std::uint64_t draws = 0;  ///< the first so many; 0 for all
  std::size_t points_max = k_trace_points_max;
};

/// (draw, value * scale) of a variable with dims (chain, draw). Of a chain too long for
/// `points_max` the first, lowest, highest and last of each stretch are kept, so spikes stay
/// and memory is bounded. Throws base::Error(usage) when the archive has no such chain, bad_archive
/// when it has no such variable.
std::vector<plot::Point> trace(const archive::Source& source, std::string_view variable,
                               const TraceRange& range, double scale);

/// The chains whose traces are drawn into one panel: the one asked for, or the first six. Throws
/// base::Error(usage) when the archive has no such chain.
std::vector<std::uint64_t> chains_to_draw(const archive::Source& source,
                                          std::optional<std::uint64_t> asked);

}  // namespace sleight::pictures
