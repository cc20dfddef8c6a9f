#include "clients/plot/terminal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "clients/plot/axis.h"
#include "clients/plot/decimate.h"
#include "clients/plot/layout.h"
#include "clients/plot/text.h"
#include "common/base/check.h"

namespace sleight::plot {
namespace {

struct Glyph {
  std::string text;
  Color color = palette::k_ink;
};

/// A grid of small dots made of characters: braille patterns (2 x 4 dots per character), or in
/// ASCII the four characters " ", "'", "." and ":" (1 x 2 dots). Dots are about square, because a
/// terminal's characters are twice as high as wide. Dots are numbered from the upper left corner.
/// Content outside is clipped.
class DotCanvas {
 public:
  /// REQUIRES at least one column and one row of characters.
  DotCanvas(std::size_t columns, std::size_t rows, bool unicode);

  std::size_t rows() const { return rows_; }
  std::size_t width() const { return columns_ * dots_x_; }
  std::size_t height() const { return rows_ * dots_y_; }

  /// Return the position of the character that contains a dot.
  std::size_t column_of(double dot_x) const;
  std::size_t row_of(double dot_y) const;

  void dot(double x, double y, Color color);
  /// Draws a line of dots, or only every period-th dot.
  void line(Point from, Point to, Color color, std::size_t period = 1);
  /// Replaces a character's dots by text. REQUIRES printable text of width one.
  void glyph(std::size_t column, std::size_t row, std::string_view text, Color color);

  Glyph at(std::size_t column, std::size_t row) const;

 private:
  struct Cell {
    unsigned dots = 0;  ///< bit x + y * dots_x_
    std::string glyph = {};
    Color color = {};
  };
  Cell& cell(std::size_t column, std::size_t row) { return cells_[row * columns_ + column]; }

  std::size_t columns_;
  std::size_t rows_;
  std::size_t dots_x_;
  std::size_t dots_y_;
  std::vector<Cell> cells_;
};

// Returns the part of a segment inside [0, width] x [0, height] (Liang and Barsky's clipping).
std::optional<std::pair<Point, Point>> clipped(Point from, Point to, double width, double height) {
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  // For each side: the segment's speed outwards, and its start's distance inwards from the side.
  const double leaving[] = {-dx, dx, -dy, dy};
  const double inside[] = {from.x, width - from.x, from.y, height - from.y};
  double enter = 0;
  double leave = 1;
  for (std::size_t side = 0; side < 4; ++side) {
    if (leaving[side] == 0) {
      if (inside[side] < 0) return std::nullopt;
      continue;
    }
    const double at = inside[side] / leaving[side];
    if (leaving[side] < 0) {
      enter = std::max(enter, at);
    } else {
      leave = std::min(leave, at);
    }
  }
  if (!(enter <= leave)) return std::nullopt;
  return std::pair{Point{from.x + enter * dx, from.y + enter * dy},
                   Point{from.x + leave * dx, from.y + leave * dy}};
}

// Bits of dots; the dot at (x, y) has index x + 2 y. In Unicode, a braille character's dots are
// numbered down the left column, then down the right one, except that the lowest pair comes last.
constexpr unsigned k_braille_bit[] = {0x01, 0x08, 0x02, 0x10, 0x04, 0x20, 0x40, 0x80};

std::string braille(unsigned dots) {
  unsigned pattern = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    if ((dots >> i & 1U) != 0) pattern |= k_braille_bit[i];
  }
  // The character is U+2800 plus the pattern, as UTF-8.
  return {'\xE2', static_cast<char>(0xA0U | pattern >> 6),
          static_cast<char>(0x80U | (pattern & 0x3FU))};
}

DotCanvas::DotCanvas(std::size_t columns, std::size_t rows, bool unicode)
    : columns_(columns),
      rows_(rows),
      dots_x_(unicode ? 2 : 1),
      dots_y_(unicode ? 4 : 2),
      cells_(columns * rows) {
  CHECK_GE(columns, std::size_t{1});
  CHECK_GE(rows, std::size_t{1});
}

std::size_t DotCanvas::column_of(double dot_x) const {
  const double column = std::floor(std::round(dot_x) / static_cast<double>(dots_x_));
  return static_cast<std::size_t>(std::clamp(column, 0.0, static_cast<double>(columns_ - 1)));
}

std::size_t DotCanvas::row_of(double dot_y) const {
  const double row = std::floor(std::round(dot_y) / static_cast<double>(dots_y_));
  return static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(rows_ - 1)));
}

void DotCanvas::dot(double x, double y, Color color) {
  x = std::round(x);
  y = std::round(y);
  if (!(x >= 0 && y >= 0 && x < static_cast<double>(width()) &&
        y < static_cast<double>(height()))) {
    return;
  }
  const auto column = static_cast<std::size_t>(x);
  const auto row = static_cast<std::size_t>(y);
  Cell& target = cell(column / dots_x_, row / dots_y_);
  target.dots |= 1U << (column % dots_x_ + row % dots_y_ * dots_x_);
  target.color = color;
}

void DotCanvas::line(Point from, Point to, Color color, std::size_t period) {
  const auto part =
      clipped(from, to, static_cast<double>(width() - 1), static_cast<double>(height() - 1));
  if (!part) return;
  const auto [start, end] = *part;
  const double steps = std::ceil(std::max(std::abs(end.x - start.x), std::abs(end.y - start.y)));
  for (double step = 0; step <= steps; step += static_cast<double>(period)) {
    const double along = steps > 0 ? step / steps : 0;
    dot(start.x + along * (end.x - start.x), start.y + along * (end.y - start.y), color);
  }
}

void DotCanvas::glyph(std::size_t column, std::size_t row, std::string_view text, Color color) {
  if (column >= columns_ || row >= rows_) return;
  cell(column, row).glyph = text;
  cell(column, row).color = color;
}

Glyph DotCanvas::at(std::size_t column, std::size_t row) const {
  const Cell& here = cells_[row * columns_ + column];
  if (!here.glyph.empty()) return {here.glyph, here.color};
  if (here.dots == 0) return {};
  static constexpr const char* k_ascii[] = {" ", "'", ".", ":"};
  return {dots_x_ == 2 ? braille(here.dots) : k_ascii[here.dots], here.color};
}

constexpr std::size_t k_columns_min = 24;
constexpr std::size_t k_rows_min = 6;
constexpr std::size_t k_plot_rows_min = 4;
constexpr std::size_t k_band_period = 4;  // distance of dots on a band's edge
constexpr std::size_t k_disc_corners = 72;

using Row = std::vector<Glyph>;

// Converts text to the terminal's alphabet and cuts it to a width.
std::string words(std::string_view text, const TerminalOptions& options, std::size_t width) {
  const std::string clean = printable(text);
  return std::string(first_of(options.unicode ? clean : to_ascii(clean), width));
}

// Writes text into a row, starting at a column. Text outside the row is clipped.
void put(Row& row, std::size_t column, std::string_view text, Color color = palette::k_ink) {
  while (!text.empty() && column < row.size()) {
    const std::string_view character = first_of(text, 1);
    row[column++] = {std::string(character), color};
    text.remove_prefix(character.size());
  }
}

// Draws series as dots. A range's low end is at the first dot, its high end at the last dot.
class DotPainter {
 public:
  DotPainter(DotCanvas& canvas, PanelRanges ranges, const TerminalOptions& options)
      : canvas_(canvas), ranges_(ranges), options_(options) {}

  Point to_dots(Point data) const {
    const auto along = [](double value, Range range) {
      return (value - range.low) / (range.high - range.low);
    };
    return {along(data.x, ranges_.x) * static_cast<double>(canvas_.width() - 1),
            (1 - along(data.y, ranges_.y)) * static_cast<double>(canvas_.height() - 1)};
  }

  void operator()(const Line& line) const { path(line.points, line.color); }
  void operator()(const Steps& steps) const { path(stepped(steps.points), steps.color); }
  void operator()(const Markers& markers) const {
    for (const Point point : markers.points) {
      if (!is_drawable(point)) continue;
      const Point at = to_dots(point);
      canvas_.dot(at.x, at.y, markers.color);
    }
    infinities(markers.points, markers.color);
  }
  void operator()(const HorizontalBand& band) const {
    across(band.low, band.color, k_band_period);
    across(band.high, band.color, k_band_period);
  }
  void operator()(const HorizontalLine& line) const {
    across(line.y, line.color, line.dashed ? 2 : 1);
  }
  void operator()(const VerticalLine& line) const {
    if (!(std::abs(line.x) < k_infinite)) return;
    canvas_.line(to_dots({line.x, ranges_.y.low}), to_dots({line.x, ranges_.y.high}), line.color,
                 line.dashed ? 2 : 1);
  }
  void operator()(const Arrow& arrow) const {
    if (!is_drawable(arrow.from) || !is_drawable(arrow.to)) return;
    canvas_.line(to_dots(arrow.from), to_dots(arrow.to), arrow.color);
  }
  void operator()(const Disc& disc) const {
    if (!is_drawable(disc.center)) return;
    const double radius_y = disc.radius_y > 0 ? disc.radius_y : disc.radius_x;
    const auto corner = [&](std::size_t i) {
      const double angle = 2 * M_PI * static_cast<double>(i) / k_disc_corners;
      return to_dots({disc.center.x + disc.radius_x * std::cos(angle),
                      disc.center.y + radius_y * std::sin(angle)});
    };
    for (std::size_t i = 0; i < k_disc_corners; ++i) {
      canvas_.line(corner(i), corner(i + 1), disc.color);
      // Chords straight down from each corner fill the disc if the corners are dense enough.
      if (disc.filled) canvas_.line(corner(i), corner(k_disc_corners - i), disc.color);
    }
  }
  /// Draws only the outline. Dots have no lighter shade, so a filled rectangle would hide other
  /// series.
  void operator()(const Rectangle& rectangle) const {
    if (!is_drawable(rectangle.low) || !is_drawable(rectangle.high)) return;
    const Point a = to_dots(rectangle.low);
    const Point b = to_dots(rectangle.high);
    const Point corners[] = {a, {b.x, a.y}, b, {a.x, b.y}, a};
    for (std::size_t i = 1; i < std::size(corners); ++i)
      canvas_.line(corners[i - 1], corners[i], rectangle.color);
  }
  void operator()(const Polygon& polygon) const {
    if (!std::ranges::all_of(polygon.corners, is_drawable)) return;
    for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
      canvas_.line(to_dots(polygon.corners[i]),
                   to_dots(polygon.corners[(i + 1) % polygon.corners.size()]), polygon.color);
    }
  }
  void operator()(const Text& text) const {
    if (!is_drawable(text.at)) return;
    const Point at = to_dots(text.at);
    const std::string shown = words(text.text, options_, k_words_max);
    const std::size_t length = length_of(shown);
    const std::size_t before = text.anchor == Anchor::start    ? 0
                               : text.anchor == Anchor::middle ? length / 2
                                                               : length;
    const std::size_t column = canvas_.column_of(at.x);
    for (std::size_t i = 0; i < length; ++i) {
      if (column + i < before) continue;
      const std::string_view rest = std::string_view(shown).substr(first_of(shown, i).size());
      canvas_.glyph(column + i - before, canvas_.row_of(at.y), first_of(rest, 1), text.color);
    }
  }

 private:
  static constexpr std::size_t k_words_max = 200;

  void across(double y, Color color, std::size_t period) const {
    if (!(std::abs(y) < k_infinite)) return;
    canvas_.line(to_dots({ranges_.x.low, y}), to_dots({ranges_.x.high, y}), color, period);
  }

  void path(const std::vector<Point>& points, Color color) const {
    for (const auto run : drawable_runs(points)) {
      std::vector<Point> dots;
      dots.reserve(run.size());
      for (const Point point : run)
        dots.push_back(to_dots(point));
      dots = decimated_line(dots, 1.0);
      if (dots.size() == 1) canvas_.dot(dots[0].x, dots[0].y, color);
      for (std::size_t i = 1; i < dots.size(); ++i)
        canvas_.line(dots[i - 1], dots[i], color);
    }
    infinities(points, color);
  }

  // Draws an arrow at the edge for each infinite y.
  void infinities(const std::vector<Point>& points, Color color) const {
    for (const Point point : points) {
      if (!(point.x >= ranges_.x.low && point.x <= ranges_.x.high)) continue;
      if (!(std::abs(point.y) >= k_infinite)) continue;
      const bool up = point.y > 0;
      const std::size_t column = canvas_.column_of(to_dots({point.x, ranges_.y.low}).x);
      const std::size_t row = canvas_.row_of(up ? 0 : static_cast<double>(canvas_.height() - 1));
      const char* const arrow =
          up ? (options_.unicode ? "↑" : "^") : (options_.unicode ? "↓" : "v");
      canvas_.glyph(column, row, arrow, color);
    }
  }

  DotCanvas& canvas_;
  PanelRanges ranges_;
  const TerminalOptions& options_;
};

// The optional rows for which there is room, besides plot, axis and tick labels.
struct Furniture {
  bool title = false;
  bool y_label = false;
  bool x_label = false;
  std::vector<Row> legend;

  std::size_t rows() const {
    return std::size_t{title} + std::size_t{y_label} + std::size_t{x_label} + legend.size();
  }
};

std::vector<Row> legend_rows(const Panel& panel, const TerminalOptions& options) {
  std::vector<Row> rows;
  std::size_t column = options.columns;
  for (const LegendEntry& entry : legend_entries(panel)) {
    static constexpr const char* k_unicode[] = {"──", "╌╌", "• ", "┈┈", "─→"};
    static constexpr const char* k_ascii[] = {"--", "- ", "* ", "..", "->"};
    const auto swatch = static_cast<std::size_t>(entry.swatch);
    const std::string label = words(entry.label, options, options.columns - 5);
    const std::size_t width = 5 + length_of(label);
    if (column + width > options.columns) {
      rows.emplace_back(options.columns);
      column = 1;
    }
    put(rows.back(), column, options.unicode ? k_unicode[swatch] : k_ascii[swatch], entry.color);
    put(rows.back(), column + 3, label);
    column += width;
  }
  return rows;
}

Furniture furniture_of(const Panel& panel, const TerminalOptions& options) {
  Furniture out{.title = !panel.title.empty(),
                .y_label = !panel.y_label.empty(),
                .x_label = !panel.x_label.empty(),
                .legend = panel.legend ? legend_rows(panel, options) : std::vector<Row>{}};
  const std::size_t room = options.rows - 2 - k_plot_rows_min;
  if (out.rows() > room) out.legend.clear();
  if (out.rows() > room) out.y_label = false;
  if (out.rows() > room) out.x_label = false;
  if (out.rows() > room) out.title = false;
  return out;
}

std::size_t widest(const Ticks& ticks) {
  std::size_t width = 0;
  for (const std::string& label : ticks.labels)
    width = std::max(width, length_of(label));
  return width;
}

Ticks terminal_ticks(Range range, std::size_t count_max, const TerminalOptions& options) {
  Ticks ticks = nice_ticks(range, std::max<std::size_t>(count_max, 2));
  for (std::string& label : ticks.labels)
    label = words(label, options, options.columns / 2);
  return ticks;
}

// Returns the dots with the y axis and its labels on their left; the axis is in column left - 1.
std::vector<Row> plot_rows_of(const DotCanvas& canvas, const DotPainter& painter,
                              const Ticks& ticks, std::size_t left,
                              const TerminalOptions& options) {
  std::vector<Row> rows(canvas.rows(), Row(options.columns));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i][left - 1] = {options.unicode ? "│" : "|"};
    for (std::size_t column = left; column < options.columns; ++column) {
      rows[i][column] = canvas.at(column - left, i);
    }
  }
  for (std::size_t i = 0; i < ticks.values.size(); ++i) {
    Row& row = rows[canvas.row_of(painter.to_dots({0, ticks.values[i]}).y)];
    const std::string_view label = first_of(ticks.labels[i], left - 2);
    put(row, left - 2 - length_of(label), label);
    row[left - 1] = {options.unicode ? "┤" : "+"};
  }
  return rows;
}

// Draws the axis below the plot, and its labels if they fit.
void draw_x_axis(Row& axis, Row& labels, const Ticks& ticks, const DotPainter& painter,
                 const DotCanvas& canvas, std::size_t left, const TerminalOptions& options) {
  axis[left - 1] = {options.unicode ? "└" : "+"};
  for (std::size_t i = left; i < axis.size(); ++i)
    axis[i] = {options.unicode ? "─" : "-"};
  std::size_t free_from = 0;
  for (std::size_t i = 0; i < ticks.values.size(); ++i) {
    const std::size_t column = left + canvas.column_of(painter.to_dots({ticks.values[i], 0}).x);
    axis[column] = {options.unicode ? "┬" : "+"};
    const std::size_t length = length_of(ticks.labels[i]);
    std::size_t start = column > length / 2 ? column - length / 2 : 0;
    start = std::min(start, labels.size() - std::min(length, labels.size()));
    if (start < free_from) continue;
    put(labels, start, ticks.labels[i]);
    free_from = start + length + 1;
  }
}

std::string joined(const std::vector<Row>& rows, bool color) {
  std::string out;
  for (const Row& row : rows) {
    std::size_t end = row.size();
    while (end > 0 && (row[end - 1].text.empty() || row[end - 1].text == " "))
      --end;
    Color pen = palette::k_ink;
    for (std::size_t i = 0; i < end; ++i) {
      const Color& wanted = row[i].color;
      if (color && !row[i].text.empty() && wanted.with_opacity(1) != pen) {
        pen = wanted.with_opacity(1);
        // Ink is the terminal's own foreground, which may be light on dark.
        const auto level = [](std::uint8_t channel) { return (channel * 5 + 127) / 255; };
        out += pen == palette::k_ink
                   ? "\x1b[39m"
                   : fmt::format("\x1b[38;5;{}m",
                                 16 + 36 * level(pen.red) + 6 * level(pen.green) + level(pen.blue));
      }
      out += row[i].text.empty() ? " " : row[i].text;
    }
    if (pen != palette::k_ink) out += "\x1b[39m";
    out += '\n';
  }
  return out;
}

}  // namespace

std::string to_terminal(const Panel& panel, const TerminalOptions& wanted) {
  TerminalOptions options = wanted;
  options.columns = std::max(options.columns, k_columns_min);
  options.rows = std::max(options.rows, k_rows_min);
  const Furniture furniture = furniture_of(panel, options);
  const std::size_t plot_rows = options.rows - 2 - furniture.rows();

  // To the left of the plot, reserve space for the axis and for the widest label of a first
  // estimate of the ticks.
  PanelRanges ranges = ranges_of(panel);
  const std::size_t left = widest(terminal_ticks(ranges.y, plot_rows / 3, options)) + 2;
  DotCanvas canvas(options.columns - left, plot_rows, options.unicode);
  if (panel.equal_aspect) {
    ranges = with_equal_aspect(ranges, static_cast<double>(canvas.width() - 1),
                               static_cast<double>(canvas.height() - 1));
  }
  const DotPainter painter(canvas, ranges, options);
  for (const Series& series : panel.series)
    std::visit(painter, series);

  // From top to bottom: text, the plot, its axis, text.
  std::vector<Row> rows;
  const auto add_words = [&](std::string_view text, std::size_t column) {
    rows.emplace_back(options.columns);
    put(rows.back(), column, words(text, options, options.columns));
  };
  if (furniture.title) add_words(panel.title, 0);
  if (furniture.y_label) add_words(panel.y_label, 0);
  const Ticks y_ticks = terminal_ticks(ranges.y, plot_rows / 3, options);
  for (Row& row : plot_rows_of(canvas, painter, y_ticks, left, options)) {
    rows.push_back(std::move(row));
  }
  rows.emplace_back(options.columns);
  Row labels(options.columns);
  const Ticks x_ticks = terminal_ticks(ranges.x, (options.columns - left) / 10, options);
  draw_x_axis(rows.back(), labels, x_ticks, painter, canvas, left, options);
  rows.push_back(std::move(labels));
  if (furniture.x_label) {
    const std::string label = words(panel.x_label, options, options.columns - left);
    add_words(label, left + (options.columns - left - length_of(label)) / 2);
  }
  rows.insert(rows.end(), furniture.legend.begin(), furniture.legend.end());
  return joined(rows, options.color);
}

}  // namespace sleight::plot
