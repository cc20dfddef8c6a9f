// Pictures as values: a figure is a title over a grid of panels, a panel is axes with series.
//
// A figure says what to show, never how: ticks, margins, legends and the thinning of long series
// are the writers' work (svg.h, png.h, terminal.h), so one figure serves a file and a terminal.
//
//   Panel panel{.title = "Landing position", .x_label = "iteration", .y_label = "x (D)"};
//   panel.series.push_back(HorizontalBand{.low = 0.9, .high = 1.1, .label = "target"});
//   panel.series.push_back(Line{.points = trace, .label = "chain 0"});
//   save(Figure{.title = "2D ball", .panels = {panel}}, "trace.svg");
//
// 1. Series are drawn in the order given, except that bands lie beneath everything.
// 2. A point with a NaN is a gap. An infinite y is a gap with a small triangle at the panel's edge,
//    so that log p = -inf is seen; an infinite x is a gap alone. Beyond k_infinite is infinite.
// 3. Equal labels in a panel share one legend entry; an empty label has none.
// 4. All text is UTF-8, or is repaired to it; what can't be printed is shown as U+FFFD.
//
// Coordinates are the panel's own (data) units, lengths with a suffix are pixels of the SVG.
// Values without shared state: thread-safe as any value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sleight::plot {

/// Numbers of larger magnitude are drawn as infinite: the axis arithmetic stays finite below it.
inline constexpr double k_infinite = 1e150;

struct Point {
  double x = 0;
  double y = 0;
  friend bool operator==(const Point&, const Point&) = default;
};

/// REQUIRES low < high, both finite, where a caller gives it.
struct Range {
  double low = 0;
  double high = 1;
  friend bool operator==(const Range&, const Range&) = default;
};

/// sRGB; `opacity` is 0 (clear) to 1.
struct Color {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  double opacity = 1;
  friend bool operator==(const Color&, const Color&) = default;

  Color with_opacity(double value) const { return {red, green, blue, value}; }
};

/// Okabe and Ito's colours, told apart by people with any of the common colour blindnesses.
namespace palette {
inline constexpr Color k_blue{0x00, 0x72, 0xB2};
inline constexpr Color k_vermillion{0xD5, 0x5E, 0x00};
inline constexpr Color k_green{0x00, 0x9E, 0x73};
inline constexpr Color k_orange{0xE6, 0x9F, 0x00};
inline constexpr Color k_purple{0xCC, 0x79, 0xA7};
inline constexpr Color k_sky{0x56, 0xB4, 0xE9};
inline constexpr Color k_ink{0x33, 0x33, 0x33};
inline constexpr Color k_grey{0x8A, 0x8A, 0x8A};

/// The colour of the n-th of several series that are alike; repeats after six.
Color series(std::size_t index);
}  // namespace palette

/// Straight lines between points, in any order of x (a trajectory may turn back).
struct Line {
  std::vector<Point> points = {};
  Color color = palette::k_blue;
  std::string label = {};
  double width_px = 1.4;
};

/// Each value holds from its x to the next point's x: what a counter or a repeated sample does.
struct Steps {
  std::vector<Point> points = {};
  Color color = palette::k_blue;
  std::string label = {};
  double width_px = 1.4;
};

/// A dot per point.
struct Markers {
  std::vector<Point> points = {};
  Color color = palette::k_blue;
  std::string label = {};
  double radius_px = 2.5;
};

/// All y from low to high, over the panel's whole width.
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

/// An event: over the panel's whole height.
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

/// An ellipse with the axes' directions; `radius_y` 0 means a circle in data units.
struct Disc {
  Point center = {};
  double radius_x = 1;
  double radius_y = 0;
  Color color = palette::k_green;
  std::string label = {};
  bool filled = true;
};

/// With the axes' directions, from one corner to the other.
struct Rectangle {
  Point low = {};
  Point high = {};
  Color color = palette::k_grey;
  std::string label = {};
  bool filled = true;
  double width_px = 1.4;  ///< of the outline, where not filled
};

/// A filled area: its corners in order, the last joined to the first. None if any is not finite.
struct Polygon {
  std::vector<Point> corners = {};
  Color color = palette::k_grey;
  std::string label = {};
};

enum class Anchor { start, middle, end };

/// Words at a point: their baseline starts, is centred or ends there.
struct Text {
  Point at = {};
  std::string text = {};
  Anchor anchor = Anchor::start;
  Color color = palette::k_ink;
  double size_px = 12;
  /// A label within a disc or box: the point is the middle of its height, and it has no white rim,
  /// which sets words off from lines beneath.
  bool inside = false;
};

using Series = std::variant<Line, Steps, Markers, HorizontalBand, HorizontalLine, VerticalLine,
                            Arrow, Disc, Rectangle, Polygon, Text>;

struct Panel {
  std::string title = {};
  std::string x_label = {};
  std::string y_label = {};
  /// Absent: from the series' finite points, with a margin. Points outside a given range are cut.
  std::optional<Range> x_range = std::nullopt;
  std::optional<Range> y_range = std::nullopt;
  /// One unit of x is as long as one of y; the range with room to spare grows on both sides.
  bool equal_aspect = false;
  /// Without: no ticks, axis labels or grid in a file, the frame fills its cell. For drawings that
  /// are no diagram. A terminal shows them always.
  bool axes = true;
  bool grid = true;
  bool legend = true;
  /// Height beside the other rows of the figure; a row takes its largest.
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
