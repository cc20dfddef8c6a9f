// Pictures of 2D ball archives: the thesis's figures 2.3 and 2.4.
#pragma once

#include <cstdint>
#include <optional>

#include "clients/plot/figure.h"
#include "common/archive/model.h"

namespace sleight::cli {

/// Figure 2.4: where the ball lands along chains, in diameters, with the band of the tolerance; and
/// log p below. Of one chain, or of the first six when none is given.
plot::Figure ball_2d_trace(const archive::Source& source, std::optional<std::uint64_t> chain,
                           std::uint64_t draws);

/// Figure 2.3: paths of the ball's centre in up to `count` kept animations, one of each lineage
/// first, with an arrow along each collision's normal and the target on the table. Of one chain, or
/// of all when none is given.
plot::Figure ball_2d_paths(const archive::Source& source, std::optional<std::uint64_t> chain,
                           std::size_t count);

}  // namespace sleight::cli
