// Appends the few SVG elements that figures need to a string.
//
// The same calls produce the same bytes: neither locale nor clock has an effect. Numbers have at
// most two decimals. The second decimal is a fiftieth of the smallest length that is visible at
// double size. Not thread-safe.
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
  bool upwards = false;  ///< rotated a quarter turn to the left about its anchor
  bool halo = false;     ///< a white rim, for text on data
};

class SvgWriter {
 public:
  /// `title` is for screen readers. REQUIRES printable text here and below.
  SvgWriter(double width_px, double height_px, std::string_view title);

  /// Writes a line `name: value` per note. Renderers ignore the metadata.
  void metadata(const Notes& notes);

  /// Clips all elements that are drawn before end_group() to the box.
  void begin_clipped(Box box);
  void end_group();

  void rectangle(Box box, Color fill);
  void rectangle_outline(Box box, Stroke stroke);
  void segment(Point from, Point to, Stroke stroke);
  /// Draws joined points; nothing for fewer than two.
  void polyline(std::span<const Point> points, Stroke stroke);
  void polygon(std::span<const Point> points, Color fill);
  void disc(Point center, double radius, Color fill);
  /// Writes one path for all dots, which is smaller than many discs.
  void dots(std::span<const Point> centers, double radius, Color fill);
  void ellipse(Point center, double radius_x, double radius_y, Color fill);
  void ellipse_outline(Point center, double radius_x, double radius_y, Stroke stroke);
  void text(Point at, std::string_view words, const TextStyle& text_style);

  /// Returns the document. REQUIRES: all groups have ended; called once.
  std::string finish();

 private:
  std::string out_;
  std::size_t clips_ = 0;
  std::size_t open_groups_ = 0;
};

}  // namespace sleight::plot
