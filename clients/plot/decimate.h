// Thinning of long series to what a device can show, extremes kept.
//
// A line that stays within one device column (or passes through it for a while) is drawn by at most
// four points there: the first, the lowest, the highest and the last, in the order in which they
// came. A million points on 800 columns so become at most 3,200, and no spike is lost. A path that
// jumps to and fro keeps its points: each visit to a column is its own run.
//
// Pure functions; points are in device coordinates unless said otherwise.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "clients/plot/figure.h"

namespace sleight::plot {

/// The runs of neighbouring drawable points, in order: what lies between two gaps.
/// Coordinates of any kind; the spans point into `points`.
std::vector<std::span<const Point>> drawable_runs(std::span<const Point> points);

/// One run with the points left out that can't be seen. REQUIRES drawable points, column > 0.
std::vector<Point> decimated_line(std::span<const Point> run, double column);

/// The first point in each square cell with a side of `cell`, in order; drawable points only.
std::vector<Point> decimated_markers(std::span<const Point> points, double cell);

/// The corners of the line that steps draw: each value held to the next point's x. Gaps are kept.
std::vector<Point> stepped(std::span<const Point> points);

}  // namespace sleight::plot
