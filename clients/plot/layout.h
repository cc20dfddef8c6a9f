// Where everything of a figure stands, in pixels: frames of panels, ticks, rows of legends.
//
// Nothing overlaps: margins follow the measured texts, the legend has rows of its own above the
// frame, tick labels are thinned until they have room, and too long a text is cut with an ellipsis.
// Panels of a column share left and right margins, panels of a row those above and below, and all
// frames are equally wide, so that axes line up both ways. Pure.
#pragma once

#include <string>
#include <vector>

#include "clients/plot/axis.h"
#include "clients/plot/figure.h"

namespace sleight::plot {

/// Sizes of the house style, all in pixels.
namespace style {
inline constexpr double k_figure_title = 17;
inline constexpr double k_panel_title = 13.5;
inline constexpr double k_axis_label = 12.5;
inline constexpr double k_tick_label = 11.5;
inline constexpr double k_legend = 11.5;
inline constexpr double k_tick_length = 4;
inline constexpr double k_outer = 14;           ///< between the figure's edge and anything in it
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

/// What stands for a series in the legend.
enum class Swatch { line, dashed_line, dot, area, arrow };

struct LegendEntry {
  std::string label;
  Swatch swatch = Swatch::line;
  Color color;
  double left = 0;      ///< of the swatch
  double baseline = 0;  ///< of the label
};

/// The labels of a panel, each once, in order of first use; positions not yet set.
std::vector<LegendEntry> legend_entries(const Panel& panel);

struct PanelLayout {
  Box cell;   ///< everything of the panel
  Box frame;  ///< the data
  PanelRanges ranges;
  Ticks x_ticks;
  Ticks y_ticks;
  std::vector<LegendEntry> legend;
  std::string title;  ///< all three fitted to their place
  std::string x_label;
  std::string y_label;

  Point to_pixels(Point data) const;
};

struct FigureLayout {
  std::string title;
  double title_baseline = 0;
  std::vector<PanelLayout> panels;  ///< as the figure's
};

/// REQUIRES columns >= 1 and a positive size. A figure too small for its texts keeps frames of a
/// few pixels rather than negative ones.
FigureLayout layout_of(const Figure& figure);

}  // namespace sleight::plot
