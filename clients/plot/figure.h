// Pictures as values: a figure is a title and a grid of panels; a panel is axes with series.
//
// A figure describes content, not presentation. The writers choose ticks, margins and legends and
// thin long series (svg.h, png.h, terminal.h), so the same figure serves files and terminals.
// Example:
//
//   Panel panel{.title = "Landing position", .x_label = "iteration", .y_label = "x (D)"};
//   panel.series.push_back(HorizontalBand{.low = 0.9, .high = 1.1, .label = "target"});
//   panel.series.push_back(Line{.points = trace, .label = "chain 0"});
//   save(Figure{.title = "2D ball", .panels = {panel}}, "trace.svg");
//
//   1. Series are drawn in the order given, except that bands are below everything else.
//   2. A point with a NaN is a gap. An infinite y is a gap with a small triangle at the panel's
//      edge, so that log p = -inf is visible; an infinite x is only a gap. Coordinates beyond
//      k_infinite count as infinite.
//   3. Equal labels in a panel share one legend entry; an empty label has none.
//   4. All text is UTF-8 or is repaired; characters that can't be printed become U+FFFD.
//
// Coordinates are in the panel's data units; lengths with a suffix are in pixels of the SVG.
// Thread-safe as any value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sleight::plot {

/// Larger magnitudes are drawn as infinite, so that axis arithmetic stays finite.
inline constexpr double k_infinite = 1e150;

struct Point {
  double x = 0;
  double y = 0;
  friend bool operator==(const Point&, const Point&) = default;
};

/// REQUIRES low < high, both finite, if the caller sets the range.
struct Range {
  double low = 0;
  double high = 1;
  friend bool operator==(const Range&, const Range&) = default;
};

/// sRGB; opacity 0 is transparent.
struct Color {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  double opacity = 1;
  friend bool operator==(const Color&, const Color&) = default;

  Color with_opacity(double value) const { return {red, green, blue, value}; }
};

/// Okabe and Ito's colours, which people with common colour blindnesses can distinguish.
namespace palette {
inline constexpr Color k_blue{0x00, 0x72, 0xB2};
inline constexpr Color k_vermillion{0xD5, 0x5E, 0x00};
inline constexpr Color k_green{0x00, 0x9E, 0x73};
inline constexpr Color k_orange{0xE6, 0x9F, 0x00};
inline constexpr Color k_purple{0xCC, 0x79, 0xA7};
inline constexpr Color k_sky{0x56, 0xB4, 0xE9};
inline constexpr Color k_ink{0x33, 0x33, 0x33};
inline constexpr Color k_grey{0x8A, 0x8A, 0x8A};

/// Returns the colour of the n-th similar series; repeats after six.
Color series(std::size_t index);
}  // namespace palette

/// Straight lines between points. x may decrease, as in a trajectory.
struct Line {
  std::vector<Point> points = {};
  Color color = palette::k_blue;
  std::string label = {};
  double width_px = 1.4;
};

/// Each value extends to the next point's x, for counters and repeated samples.
struct Steps {
  std::vector<Point> points = {};
  Color color = palette::k_blue;
  std::string label = {};
  double width_px = 1.4;
};

struct Markers {
  std::vector<Point> points = {};
  Color color = palette::k_blue;
  std::string label = {};
  double radius_px = 2.5;
};

/// An area from `low` to `high` in y, over the panel's width.
struct HorizontalBand {
  double low = 0;
  double high = 0;
  std::string label = {};
  Color color = palette::k_green.with_opacity(0.18);
};

struct HorizontalLine {
  double y = 0;
  std::string label = {};
  Color color = palette::k_ink;
  double width_px = 1.2;
  bool dashed = true;
};

/// A line over the panel's height, for events.
struct VerticalLine {
  double x = 0;
  std::string label = {};
  Color color = palette::k_ink;
  double width_px = 1.2;
  bool dashed = true;
};

/// A shaft with a filled head at `to`.
struct Arrow {
  Point from = {};
  Point to = {};
  Color color = palette::k_vermillion;
  std::string label = {};
  double width_px = 2;
};

/// An ellipse parallel to the axes. radius_y = 0: a circle in data units.
struct Disc {
  Point center = {};
  double radius_x = 1;
  double radius_y = 0;
  Color color = palette::k_green;
  std::string label = {};
  bool filled = true;
};

struct Rectangle {
  Point low = {};
  Point high = {};
  Color color = palette::k_grey;
  std::string label = {};
  bool filled = true;
  double width_px = 1.4;  ///< of the outline, if not filled
};

/// A filled area: its corners in order, the last joined to the first. Not drawn if a corner isn't
/// finite.
struct Polygon {
  std::vector<Point> corners = {};
  Color color = palette::k_grey;
  std::string label = {};
};

enum class Anchor { start, middle, end };

/// Text whose baseline starts, is centred or ends at a point.
struct Text {
  Point at = {};
  std::string text = {};
  Anchor anchor = Anchor::start;
  Color color = palette::k_ink;
  double size_px = 12;
  /// For a label in a disc or box: the point is the middle of the text's height, and the text has
  /// no white rim. Any other text has a rim, which separates the text from lines that it covers.
  bool inside = false;
};

using Series = std::variant<Line, Steps, Markers, HorizontalBand, HorizontalLine, VerticalLine,
                            Arrow, Disc, Rectangle, Polygon, Text>;

struct Panel {
  std::string title = {};
  std::string x_label = {};
  std::string y_label = {};
  /// Default: the extent of the series' finite points, with a margin. Points outside a given range
  /// are clipped.
  std::optional<Range> x_range = std::nullopt;
  std::optional<Range> y_range = std::nullopt;
  /// Gives units of x and y the same length by widening one range on both sides.
  bool equal_aspect = false;
  /// If false, a file has no ticks, axis labels or grid, and the frame fills its cell. For drawings
  /// that aren't diagrams. A terminal always shows axes.
  bool axes = true;
  bool grid = true;
  bool legend = true;
  /// Height relative to other rows of the figure; a row uses its panels' maximum.
  double height_share = 1;
  std::vector<Series> series = {};
};

struct Figure {
  std::string title = {};
  double width_px = 860;
  double height_px = 480;
  /// Panels fill rows from left to right. REQUIRES at least 1.
  std::size_t columns = 1;
  std::vector<Panel> panels = {};
};

}  // namespace sleight::plot
