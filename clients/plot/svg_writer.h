// The few SVG elements that figures need, appended to a string.
//
// The same calls give the same bytes: numbers have at most two decimals (a fiftieth of what an eye
// sees at double size), no locale, no ids from the clock. Not thread-safe.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "clients/plot/figure.h"
#include "clients/plot/layout.h"
#include "clients/plot/notes.h"
#include "clients/plot/text.h"

namespace sleight::plot {

struct Stroke {
  Color color;
  double width = 1;
  bool dashed = false;
};

struct TextStyle {
  double size = 12;
  Color color = palette::k_ink;
  Anchor anchor = Anchor::start;
  Weight weight = Weight::normal;
  bool upwards = false;  ///< turned by a quarter to the left, about its anchor
  bool halo = false;     ///< a white rim, for words upon data
};

class SvgWriter {
 public:
  /// `title` is what a screen reader says. REQUIRES printable text here and below.
  SvgWriter(double width_px, double height_px, std::string_view title);

  /// A line `name: value` for each; nothing without notes. Renderers leave it out.
  void metadata(const Notes& notes);

  /// All that follows is cut to the box, until end_group.
  void begin_clipped(Box box);
  void end_group();

  void rectangle(Box box, Color fill);
  void rectangle_outline(Box box, Stroke stroke);
  void segment(Point from, Point to, Stroke stroke);
  /// Joined points; nothing for fewer than two.
  void polyline(std::span<const Point> points, Stroke stroke);
  void polygon(std::span<const Point> points, Color fill);
  void disc(Point center, double radius, Color fill);
  /// One path for all dots: as small as a thousand discs can be.
  void dots(std::span<const Point> centers, double radius, Color fill);
  void ellipse(Point center, double radius_x, double radius_y, Color fill);
  void ellipse_outline(Point center, double radius_x, double radius_y, Stroke stroke);
  void text(Point at, std::string_view words, const TextStyle& text_style);

  /// The document. REQUIRES: groups ended; not called before.
  std::string finish();

 private:
  std::string out_;
  std::size_t clips_ = 0;
  std::size_t open_groups_ = 0;
};

}  // namespace sleight::plot
