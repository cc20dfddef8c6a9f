// Computes a panel's ranges and ticks.
//
// Ticks are multiples of 1, 2 or 5 times a power of ten. Labels have the fewest digits that
// distinguish neighbours. Pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "clients/plot/figure.h"

namespace sleight::plot {

struct Ticks {
  std::vector<double> values;
  std::vector<std::string> labels;  ///< one per value; the minus sign is U+2212
};

/// Returns the finest nice ticks in `range`, at most `count_max`. If the range contains two nice
/// values, returns at least two. REQUIRES range.low < range.high, count_max >= 2.
Ticks nice_ticks(Range range, std::size_t count_max);

/// The shown ranges of a panel: its given ranges, otherwise the extent of its finite points with a
/// margin. A constant or empty extent is widened, so that low < high and ticks differ.
struct PanelRanges {
  Range x;
  Range y;
};
PanelRanges ranges_of(const Panel& panel);

/// Widens one of the ranges until a unit has the same length in x and y on a frame of this size.
/// `width` and `height` are in device units, which must be square.
PanelRanges with_equal_aspect(PanelRanges ranges, double width, double height);

/// Whether both coordinates are finite and below k_infinite.
bool is_drawable(Point point);

}  // namespace sleight::plot
