// Axes: what range a panel shows and where its ticks stand.
//
// Ticks are multiples of 1, 2 or 5 times a power of ten, labelled with the fewest digits that tell
// neighbours apart. Pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "clients/plot/figure.h"

namespace sleight::plot {

struct Ticks {
  std::vector<double> values;
  std::vector<std::string> labels;  ///< one per value; minus is U+2212
};

/// The finest nice ticks inside `range` that number at most `count_max`, at least one interval
/// where the range holds two nice values at all. REQUIRES range.low < range.high, count_max >= 2.
Ticks nice_ticks(Range range, std::size_t count_max);

/// The ranges that a panel shows: those it gives, otherwise the extent of its finite points with a
/// margin. A constant or empty extent grows to something that can be drawn: always low < high, and
/// far enough apart that ticks differ.
struct PanelRanges {
  Range x;
  Range y;
};
PanelRanges ranges_of(const Panel& panel);

/// Grows the range that has room to spare until one unit is as long in x as in y on a frame of
/// this size. `height` per `width` is in the device's units, which must be square.
PanelRanges with_equal_aspect(PanelRanges ranges, double width, double height);

/// Finite and below k_infinite in both coordinates.
bool is_drawable(Point point);

}  // namespace sleight::plot
