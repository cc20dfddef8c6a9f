// Thins long series to a device's resolution, without losing extremes.
//
// A line that stays within one device column is drawn by at most four of its points there: the
// first, lowest, highest and last, in their order. So a million points on 800 columns become at
// most 3,200, and no spike is lost. Each visit to a column counts separately, so a path that jumps
// back and forth keeps its points. Pure functions; points are in device coordinates unless stated
// otherwise.
#pragma once

#include <span>
#include <vector>

#include "clients/plot/figure.h"

namespace sleight::plot {

/// Returns the runs of drawable points between gaps, in order. Points may have any coordinates, and
/// the spans refer to `points`.
std::vector<std::span<const Point>> drawable_runs(std::span<const Point> points);

/// Returns a run without invisible points. REQUIRES drawable points, column > 0.
std::vector<Point> decimated_line(std::span<const Point> run, double column);

/// Returns the first drawable point in each square cell of side `cell`, in order.
std::vector<Point> decimated_markers(std::span<const Point> points, double cell);

/// Returns the corners of a step line: each value extends to the next point's x. Keeps gaps.
std::vector<Point> stepped(std::span<const Point> points);

}  // namespace sleight::plot
