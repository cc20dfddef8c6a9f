// Computes the positions of a figure's parts in pixels: panel frames, ticks, legend rows.
//
// Nothing overlaps: margins follow the measured texts, the legend has its own rows above the frame,
// tick labels are thinned until they fit, and long texts end in an ellipsis. Panels of a column
// share left and right margins, and panels of a row share upper and lower margins. All frames have
// the same width, so axes line up both ways. Pure.
#pragma once

#include <string>
#include <vector>

#include "clients/plot/axis.h"
#include "clients/plot/figure.h"

namespace sleight::plot {

/// Sizes of the house style in pixels.
namespace style {
inline constexpr double k_figure_title = 17;
inline constexpr double k_panel_title = 13.5;
inline constexpr double k_axis_label = 12.5;
inline constexpr double k_tick_label = 11.5;
inline constexpr double k_legend = 11.5;
inline constexpr double k_tick_length = 4;
inline constexpr double k_outer = 14;           ///< minimum distance from the figure's edge
inline constexpr double k_between_panels = 18;  ///< both ways
inline constexpr double k_legend_row = 19;
inline constexpr double k_legend_swatch = 22;
}  // namespace style

/// A rectangle; y grows downwards as in SVG.
struct Box {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;
  double right() const { return left + width; }
  double bottom() const { return top + height; }
};

/// The sample of a series in the legend.
enum class Swatch { line, dashed_line, dot, area, arrow };

struct LegendEntry {
  std::string label;
  Swatch swatch = Swatch::line;
  Color color;
  double left = 0;      ///< left edge of the swatch
  double baseline = 0;  ///< baseline of the label
};

/// Returns the labels of a panel without duplicates, in order of first use, without positions.
std::vector<LegendEntry> legend_entries(const Panel& panel);

struct PanelLayout {
  Box cell;   ///< the whole panel
  Box frame;  ///< the data area
  PanelRanges ranges;
  Ticks x_ticks;
  Ticks y_ticks;
  std::vector<LegendEntry> legend;
  std::string title;  ///< title and labels are cut to fit
  std::string x_label;
  std::string y_label;

  Point to_pixels(Point data) const;
};

struct FigureLayout {
  std::string title;
  double title_baseline = 0;
  std::vector<PanelLayout> panels;  ///< in the figure's order
};

/// REQUIRES columns >= 1 and a positive size. If a figure is too small for its texts, frames keep a
/// few pixels.
FigureLayout layout_of(const Figure& figure);

}  // namespace sleight::plot
