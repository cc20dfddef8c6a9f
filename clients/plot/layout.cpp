#include "clients/plot/layout.h"

#include <algorithm>
#include <utility>

#include "clients/plot/text.h"
#include "common/base/check.h"

namespace sleight::plot {

namespace {

constexpr double k_frame_min = 8;  // pixels, so that mappings stay defined in a tiny figure
constexpr double k_pixels_per_y_tick = 34;
constexpr double k_pixels_per_x_tick = 60;
constexpr double k_x_label_gap = 14;  // between neighbouring tick labels
constexpr double k_label_gap = 7;     // between an axis label and the tick labels
constexpr double k_legend_gap = 18;   // between entries

// Margins between a cell and its frame. Panels of a column share left and right margins, and panels
// of a row share upper and lower margins, so axes line up both ways.
struct ColumnMargins {
  double left = 0;
  double right = 0;
};
struct RowMargins {
  double above = 0;
  double below = 0;
};
struct GridMargins {
  std::vector<ColumnMargins> columns;
  std::vector<RowMargins> rows;
};

LegendEntry entry_of(const Series& series) {
  struct Visitor {
    LegendEntry operator()(const Line& s) const { return {s.label, Swatch::line, s.color}; }
    LegendEntry operator()(const Steps& s) const { return {s.label, Swatch::line, s.color}; }
    LegendEntry operator()(const Markers& s) const { return {s.label, Swatch::dot, s.color}; }
    LegendEntry operator()(const HorizontalBand& s) const {
      return {s.label, Swatch::area, s.color};
    }
    LegendEntry operator()(const HorizontalLine& s) const {
      return {s.label, s.dashed ? Swatch::dashed_line : Swatch::line, s.color};
    }
    LegendEntry operator()(const VerticalLine& s) const {
      return {s.label, s.dashed ? Swatch::dashed_line : Swatch::line, s.color};
    }
    LegendEntry operator()(const Arrow& s) const { return {s.label, Swatch::arrow, s.color}; }
    LegendEntry operator()(const Disc& s) const {
      return {s.label, s.filled ? Swatch::area : Swatch::line, s.color};
    }
    LegendEntry operator()(const Rectangle& s) const {
      return {s.label, s.filled ? Swatch::area : Swatch::line, s.color};
    }
    LegendEntry operator()(const Polygon& s) const { return {s.label, Swatch::area, s.color}; }
    LegendEntry operator()(const Text&) const { return {}; }
  };
  return std::visit(Visitor{}, series);
}

double widest(const std::vector<std::string>& labels) {
  double width = 0;
  for (const std::string& label : labels) {
    width = std::max(width, text_width_px(label, style::k_tick_label));
  }
  return width;
}

/// If thinning would leave only one tick, up to this many ticks may be closer together than usual.
constexpr std::size_t k_crowded = 6;

// Thins ticks until neighbouring labels have a gap between them, but keeps two ticks if possible.
Ticks x_ticks_of(Range range, double width) {
  const auto fit = [&](const Ticks& ticks) {
    const double spacing = ticks.values.size() < 2 ? width
                                                   : (ticks.values[1] - ticks.values[0]) /
                                                         (range.high - range.low) * width;
    return widest(ticks.labels) + k_x_label_gap <= spacing;
  };
  auto count = static_cast<std::size_t>(std::clamp(width / k_pixels_per_x_tick, 2.0, 14.0));
  Ticks ticks = nice_ticks(range, count);
  while (count > 2 && !fit(ticks))
    ticks = nice_ticks(range, --count);
  while (ticks.values.size() < 2 && count < k_crowded) {
    Ticks more = nice_ticks(range, ++count);
    if (fit(more)) ticks = std::move(more);
  }
  return ticks;
}

// Places legend entries in rows between left and right. Returns the number of rows.
std::size_t place_legend(std::vector<LegendEntry>& entries, double left, double right, double top) {
  if (entries.empty()) return 0;
  std::size_t rows = 1;
  double x = left;
  for (LegendEntry& entry : entries) {
    const double text_max = std::max(right - left - style::k_legend_swatch - 6, 0.0);
    entry.label = fitted(entry.label, style::k_legend, text_max);
    const double width = style::k_legend_swatch + 6 + text_width_px(entry.label, style::k_legend);
    if (x > left && x + width > right) {
      ++rows;
      x = left;
    }
    entry.left = x;
    entry.baseline = top + style::k_legend_row * (static_cast<double>(rows) - 1) + 13;
    x += width + k_legend_gap;
  }
  return rows;
}

// Returns as many ticks as fit, but at least two if possible.
Ticks y_ticks_of(Range range, double height) {
  auto count = static_cast<std::size_t>(std::clamp(height / k_pixels_per_y_tick, 2.0, 8.0));
  Ticks ticks = nice_ticks(range, count);
  while (ticks.values.size() < 2 && count < k_crowded)
    ticks = nice_ticks(range, ++count);
  return ticks;
}

// Returns the height of title and legend above the frame, and of ticks and label below.
RowMargins row_margins_of(const Panel& panel, std::size_t legend_rows) {
  RowMargins out;
  out.above = panel.title.empty() ? 4 : style::k_panel_title + 9;
  if (legend_rows > 0) out.above += style::k_legend_row * static_cast<double>(legend_rows) + 4;
  if (!panel.axes) return out;
  out.below = style::k_tick_length + 4 + style::k_tick_label + 2;
  if (!panel.x_label.empty()) out.below += k_label_gap + style::k_axis_label;
  return out;
}

// Places a panel in its cell with the margins of its column and row. Enlarges `need` so that it
// includes the row margins that this panel needs.
PanelLayout place(const Panel& panel, Box cell, ColumnMargins sides, RowMargins row,
                  RowMargins& need) {
  PanelLayout out;
  out.cell = cell;
  const double left = cell.left + sides.left;
  const double width = std::max(cell.width - sides.left - sides.right, k_frame_min);
  // The legend is directly above the frame.
  if (panel.legend) out.legend = legend_entries(panel);
  const std::size_t legend_rows = place_legend(out.legend, left, left + width, 0);
  const RowMargins own = row_margins_of(panel, legend_rows);
  need = {std::max(need.above, own.above), std::max(need.below, own.below)};
  const double top = cell.top + std::max(row.above, own.above);
  const double below = std::max(row.below, own.below);
  out.frame = {left, top, width, std::max(cell.bottom() - below - top, k_frame_min)};
  const double legend_top = top - 4 - style::k_legend_row * static_cast<double>(legend_rows);
  for (LegendEntry& entry : out.legend)
    entry.baseline += legend_top;
  // Ranges and ticks depend on the frame's size.
  out.ranges = ranges_of(panel);
  if (panel.equal_aspect) {
    out.ranges = with_equal_aspect(out.ranges, out.frame.width, out.frame.height);
  }
  out.title =
      fitted(printable(panel.title), style::k_panel_title, width + sides.right, Weight::bold);
  if (!panel.axes) return out;
  out.y_ticks = y_ticks_of(out.ranges.y, out.frame.height);
  out.x_ticks = x_ticks_of(out.ranges.x, out.frame.width);
  out.x_label = fitted(printable(panel.x_label), style::k_axis_label, width);
  out.y_label = fitted(printable(panel.y_label), style::k_axis_label, out.frame.height);
  return out;
}

// Returns the side margins for a placed panel's texts.
ColumnMargins sides_of(const Panel& panel, const PanelLayout& placed) {
  ColumnMargins sides;
  if (!panel.axes) return sides;
  sides.left = style::k_tick_length + 4 + widest(placed.y_ticks.labels);
  if (!panel.y_label.empty()) sides.left += k_label_gap + style::k_axis_label;
  // A tick label at an end of the x axis extends beyond the frame by half its width.
  for (std::size_t i = 0; i < placed.x_ticks.values.size(); ++i) {
    const double at = placed.to_pixels({placed.x_ticks.values[i], placed.ranges.y.low}).x;
    const double half = text_width_px(placed.x_ticks.labels[i], style::k_tick_label) / 2;
    sides.left = std::max(sides.left, placed.frame.left - (at - half));
    sides.right = std::max(sides.right, at + half - placed.frame.right());
  }
  return sides;
}

// Returns the grid's cells, row by row. All frames of a figure have the same width; the rows'
// heights are proportional to the rows' shares.
std::vector<Box> cells_of(const Figure& figure, double top, const GridMargins& margins) {
  const std::size_t columns = figure.columns;
  const std::size_t rows = margins.rows.size();
  std::vector<double> shares(rows, 0.0);
  double shares_sum = 0;
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    CHECK_GT(figure.panels[i].height_share, 0.0);
    double& share = shares[i / columns];
    share = std::max(share, figure.panels[i].height_share);
  }
  for (const double share : shares)
    shares_sum += share;
  const auto gaps = [](std::size_t count) {
    return style::k_between_panels * static_cast<double>(count > 0 ? count - 1 : 0);
  };
  double frame_width = figure.width_px - 2 * style::k_outer - gaps(columns);
  for (const ColumnMargins& sides : margins.columns)
    frame_width -= sides.left + sides.right;
  frame_width = std::max(frame_width / static_cast<double>(columns), k_frame_min);
  const double height = figure.height_px - top - style::k_outer - gaps(rows);
  std::vector<Box> cells;
  double x = style::k_outer;
  double y = top;
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const ColumnMargins& sides = margins.columns[i % columns];
    const double cell_width = sides.left + frame_width + sides.right;
    const double cell_height = height * shares[i / columns] / shares_sum;
    cells.push_back({x, y, cell_width, cell_height});
    x += cell_width + style::k_between_panels;
    if (i % columns != columns - 1) continue;
    x = style::k_outer;
    y += cell_height + style::k_between_panels;
  }
  return cells;
}

}  // namespace

Point PanelLayout::to_pixels(Point data) const {
  const auto along = [](double value, Range range) {
    return (value - range.low) / (range.high - range.low);
  };
  return {frame.left + along(data.x, ranges.x) * frame.width,
          frame.bottom() - along(data.y, ranges.y) * frame.height};
}

std::vector<LegendEntry> legend_entries(const Panel& panel) {
  std::vector<LegendEntry> entries;
  for (const Series& series : panel.series) {
    LegendEntry entry = entry_of(series);
    entry.label = printable(entry.label);
    const bool known = std::ranges::any_of(
        entries, [&entry](const LegendEntry& other) { return other.label == entry.label; });
    if (!entry.label.empty() && !known) entries.push_back(std::move(entry));
  }
  return entries;
}

FigureLayout layout_of(const Figure& figure) {
  CHECK_GE(figure.columns, std::size_t{1});
  CHECK_GT(figure.width_px, 0.0);
  CHECK_GT(figure.height_px, 0.0);
  FigureLayout out;
  double top = style::k_outer;
  if (!figure.title.empty()) {
    out.title_baseline = top + style::k_figure_title;
    top += style::k_figure_title + 16;
    out.title = fitted(printable(figure.title), style::k_figure_title,
                       figure.width_px - 2 * style::k_outer, Weight::bold);
  }
  const std::size_t rows = (figure.panels.size() + figure.columns - 1) / figure.columns;
  GridMargins margins{std::vector(figure.columns, ColumnMargins{50, 10}),
                      std::vector(rows, RowMargins{})};
  // Margins depend on ticks, and ticks on margins. The second pass uses the first pass's ticks.
  // After the third pass, nothing changes.
  for (int pass = 0; pass < 3; ++pass) {
    const std::vector<Box> cells = cells_of(figure, top, margins);
    GridMargins needed{std::vector(figure.columns, ColumnMargins{}),
                       std::vector(rows, RowMargins{})};
    out.panels.clear();
    for (std::size_t i = 0; i < figure.panels.size(); ++i) {
      const std::size_t column = i % figure.columns;
      const std::size_t row = i / figure.columns;
      const Panel& panel = figure.panels[i];
      out.panels.push_back(
          place(panel, cells[i], margins.columns[column], margins.rows[row], needed.rows[row]));
      const ColumnMargins own = sides_of(panel, out.panels.back());
      ColumnMargins& sides = needed.columns[column];
      sides = {std::max(sides.left, own.left), std::max(sides.right, own.right)};
    }
    margins = std::move(needed);
  }
  return out;
}

}  // namespace sleight::plot
