#include "clients/plot/svg.h"

#include <algorithm>
#include <cmath>

#include "clients/plot/decimate.h"
#include "clients/plot/layout.h"
#include "clients/plot/svg_writer.h"
#include "clients/plot/text.h"

namespace sleight::plot {

namespace {

constexpr Color k_grid{0xE9, 0xE9, 0xE9};
constexpr Color k_axis{0x66, 0x66, 0x66};
constexpr double k_infinity_mark = 4;  // half a side of the triangle at the edge, pixels
constexpr double k_head_length = 8;    // length of an arrow's head in pixels, at a width of 2
constexpr double k_half_capital =
    0.36;  // distance of a text's baseline below its middle, relative to its size

void draw_arrow(SvgWriter& svg, Point from, Point to, Stroke stroke) {
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  const double length = std::hypot(dx, dy);
  if (!(length > 0)) return;
  const Point along{dx / length, dy / length};
  const double head = std::min(k_head_length * std::max(stroke.width / 2, 0.5), length);
  const Point neck{to.x - head * along.x, to.y - head * along.y};
  const double half = head * 0.42;
  // The shaft ends inside the head, so that its square end doesn't blunt the tip.
  svg.segment(from, {neck.x + 0.3 * head * along.x, neck.y + 0.3 * head * along.y}, stroke);
  const Point corners[] = {to,
                           {neck.x - half * along.y, neck.y + half * along.x},
                           {neck.x + half * along.y, neck.y - half * along.x}};
  svg.polygon(corners, stroke.color);
}

// Draws a series in a panel's frame, except bands, which draw_band draws.
class SeriesPainter {
 public:
  SeriesPainter(SvgWriter& svg, const PanelLayout& layout) : svg_(svg), layout_(layout) {}

  void operator()(const Line& line) const {
    path(line.points, {.color = line.color, .width = line.width_px});
    infinities(line.points, line.color);
  }
  void operator()(const Steps& steps) const {
    path(stepped(steps.points), {.color = steps.color, .width = steps.width_px});
    infinities(steps.points, steps.color);
  }
  void operator()(const Markers& markers) const {
    const double cell = std::max(markers.radius_px / 2, 1.0);
    svg_.dots(decimated_markers(to_pixels(markers.points), cell), markers.radius_px, markers.color);
    infinities(markers.points, markers.color);
  }
  void operator()(const HorizontalBand&) const {}
  void operator()(const HorizontalLine& line) const {
    const double y = layout_.to_pixels({layout_.ranges.x.low, line.y}).y;
    if (!(std::abs(line.y) < k_infinite)) return;
    svg_.segment({layout_.frame.left, y}, {layout_.frame.right(), y},
                 {.color = line.color, .width = line.width_px, .dashed = line.dashed});
  }
  void operator()(const VerticalLine& line) const {
    if (!(std::abs(line.x) < k_infinite)) return;
    const double x = layout_.to_pixels({line.x, layout_.ranges.y.low}).x;
    svg_.segment({x, layout_.frame.top}, {x, layout_.frame.bottom()},
                 {.color = line.color, .width = line.width_px, .dashed = line.dashed});
  }
  void operator()(const Arrow& arrow) const {
    if (!is_drawable(arrow.from) || !is_drawable(arrow.to)) return;
    draw_arrow(svg_, layout_.to_pixels(arrow.from), layout_.to_pixels(arrow.to),
               {.color = arrow.color, .width = arrow.width_px});
  }
  void operator()(const Disc& disc) const {
    if (!is_drawable(disc.center)) return;
    const Point center = layout_.to_pixels(disc.center);
    const double data_radius_y = disc.radius_y > 0 ? disc.radius_y : disc.radius_x;
    const Point edge =
        layout_.to_pixels({disc.center.x + disc.radius_x, disc.center.y + data_radius_y});
    const double radius_x = std::abs(edge.x - center.x);
    const double radius_y = std::abs(edge.y - center.y);
    if (disc.filled) {
      svg_.ellipse(center, radius_x, radius_y, disc.color);
    } else {
      svg_.ellipse_outline(center, radius_x, radius_y, {.color = disc.color, .width = 1.4});
    }
  }
  void operator()(const Rectangle& rectangle) const {
    if (!is_drawable(rectangle.low) || !is_drawable(rectangle.high)) return;
    const Point a = layout_.to_pixels(rectangle.low);
    const Point b = layout_.to_pixels(rectangle.high);
    const Box box{std::min(a.x, b.x), std::min(a.y, b.y), std::abs(b.x - a.x), std::abs(b.y - a.y)};
    if (rectangle.filled) {
      svg_.rectangle(box, rectangle.color);
    } else {
      svg_.rectangle_outline(box, {.color = rectangle.color, .width = rectangle.width_px});
    }
  }
  void operator()(const Polygon& polygon) const {
    if (!std::ranges::all_of(polygon.corners, is_drawable)) return;
    svg_.polygon(to_pixels(polygon.corners), polygon.color);
  }
  void operator()(const Text& text) const {
    if (!is_drawable(text.at)) return;
    Point at = layout_.to_pixels(text.at);
    if (text.inside) at.y += k_half_capital * text.size_px;
    svg_.text(
        at, printable(text.text),
        {.size = text.size_px, .color = text.color, .anchor = text.anchor, .halo = !text.inside});
  }

 private:
  // Gaps remain: points that aren't drawable keep their NaN or infinity.
  std::vector<Point> to_pixels(const std::vector<Point>& points) const {
    std::vector<Point> out;
    out.reserve(points.size());
    for (const Point point : points) {
      out.push_back(is_drawable(point) ? layout_.to_pixels(point) : Point{NAN, NAN});
    }
    return out;
  }

  void path(const std::vector<Point>& points, Stroke stroke) const {
    const std::vector<Point> pixels = to_pixels(points);
    for (const auto run : drawable_runs(pixels)) {
      if (run.size() == 1) {
        svg_.disc(run.front(), std::max(stroke.width, 1.5), stroke.color);
      } else {
        svg_.polyline(decimated_line(run, 1.0), stroke);
      }
    }
  }

  // Draws a triangle at the edge for each infinite y, at most one per few pixels.
  void infinities(const std::vector<Point>& points, Color color) const {
    double drawn_to[] = {-k_infinite, -k_infinite};
    for (const Point point : points) {
      if (!(std::abs(point.x) < k_infinite) || !(std::abs(point.y) >= k_infinite)) continue;
      const bool up = point.y > 0;
      const double x = layout_.to_pixels({point.x, layout_.ranges.y.low}).x;
      if (std::abs(x - drawn_to[up]) < k_infinity_mark) continue;
      drawn_to[up] = x;
      const double edge = up ? layout_.frame.top : layout_.frame.bottom();
      const double base = edge + (up ? 1.7 : -1.7) * k_infinity_mark;
      const Point corners[] = {{x, edge}, {x - k_infinity_mark, base}, {x + k_infinity_mark, base}};
      svg_.polygon(corners, color);
    }
  }

  SvgWriter& svg_;
  const PanelLayout& layout_;
};

void draw_band(SvgWriter& svg, const PanelLayout& layout, const HorizontalBand& band) {
  if (std::isnan(band.low) || std::isnan(band.high)) return;
  const auto pixel_of = [&layout](double y) {
    const double inside = std::clamp(y, layout.ranges.y.low, layout.ranges.y.high);
    return layout.to_pixels({layout.ranges.x.low, inside}).y;
  };
  const double top = pixel_of(std::max(band.low, band.high));
  const double bottom = pixel_of(std::min(band.low, band.high));
  svg.rectangle({layout.frame.left, top, layout.frame.width, bottom - top}, band.color);
}

void draw_grid(SvgWriter& svg, const PanelLayout& layout) {
  for (const double x : layout.x_ticks.values) {
    const double at = layout.to_pixels({x, layout.ranges.y.low}).x;
    svg.segment({at, layout.frame.top}, {at, layout.frame.bottom()}, {.color = k_grid});
  }
  for (const double y : layout.y_ticks.values) {
    const double at = layout.to_pixels({layout.ranges.x.low, y}).y;
    svg.segment({layout.frame.left, at}, {layout.frame.right(), at}, {.color = k_grid});
  }
}

void draw_axes(SvgWriter& svg, const PanelLayout& layout) {
  const Box& frame = layout.frame;
  const Point corners[] = {
      {frame.left, frame.top}, {frame.left, frame.bottom()}, {frame.right(), frame.bottom()}};
  svg.polyline(corners, {.color = k_axis});
  const double tick = style::k_tick_length;
  const double half_digit = k_half_capital * style::k_tick_label;
  for (std::size_t i = 0; i < layout.x_ticks.values.size(); ++i) {
    const double x = layout.to_pixels({layout.x_ticks.values[i], layout.ranges.y.low}).x;
    svg.segment({x, frame.bottom()}, {x, frame.bottom() + tick}, {.color = k_axis});
    svg.text({x, frame.bottom() + tick + 3 + style::k_tick_label}, layout.x_ticks.labels[i],
             {.size = style::k_tick_label, .anchor = Anchor::middle});
  }
  for (std::size_t i = 0; i < layout.y_ticks.values.size(); ++i) {
    const double y = layout.to_pixels({layout.ranges.x.low, layout.y_ticks.values[i]}).y;
    svg.segment({frame.left - tick, y}, {frame.left, y}, {.color = k_axis});
    svg.text({frame.left - tick - 4, y + half_digit}, layout.y_ticks.labels[i],
             {.size = style::k_tick_label, .anchor = Anchor::end});
  }
  svg.text({frame.left + frame.width / 2, layout.cell.bottom() - 2}, layout.x_label,
           {.size = style::k_axis_label, .anchor = Anchor::middle});
  svg.text({layout.cell.left + style::k_axis_label - 2, frame.top + frame.height / 2},
           layout.y_label,
           {.size = style::k_axis_label, .anchor = Anchor::middle, .upwards = true});
}

void draw_legend_entry(SvgWriter& svg, const LegendEntry& entry) {
  const double y = entry.baseline - k_half_capital * style::k_legend;
  const double width = style::k_legend_swatch;
  switch (entry.swatch) {
    case Swatch::line:
    case Swatch::dashed_line:
      svg.segment({entry.left, y}, {entry.left + width, y},
                  {.color = entry.color, .width = 2, .dashed = entry.swatch != Swatch::line});
      break;
    case Swatch::dot:
      svg.disc({entry.left + width / 2, y}, 3, entry.color);
      break;
    case Swatch::area:
      svg.rectangle({entry.left, y - 5, width, 10}, entry.color);
      break;
    case Swatch::arrow:
      draw_arrow(svg, {entry.left, y}, {entry.left + width, y}, {.color = entry.color, .width = 2});
      break;
  }
  svg.text({entry.left + width + 6, entry.baseline}, entry.label, {.size = style::k_legend});
}

/// Draws the data, clipped to the frame; a line on the edge keeps its whole width.
void draw_series(SvgWriter& svg, const Panel& panel, const PanelLayout& layout) {
  svg.begin_clipped({layout.frame.left - 1, layout.frame.top - 1, layout.frame.width + 2,
                     layout.frame.height + 2});
  for (const Series& series : panel.series)
    std::visit(SeriesPainter(svg, layout), series);
  svg.end_group();
}

void draw_panel(SvgWriter& svg, const Panel& panel, const PanelLayout& layout) {
  // Draw bands, then the grid, below the data.
  for (const Series& series : panel.series) {
    if (const auto* band = std::get_if<HorizontalBand>(&series)) draw_band(svg, layout, *band);
  }
  if (panel.grid && panel.axes) draw_grid(svg, layout);
  draw_series(svg, panel, layout);
  if (panel.axes) draw_axes(svg, layout);
  svg.text({layout.frame.left, layout.cell.top + style::k_panel_title}, layout.title,
           {.size = style::k_panel_title, .weight = Weight::bold});
  for (const LegendEntry& entry : layout.legend)
    draw_legend_entry(svg, entry);
}

}  // namespace

std::string to_svg(const Figure& figure, const Notes& notes) {
  const FigureLayout layout = layout_of(figure);
  SvgWriter svg(figure.width_px, figure.height_px, printable(figure.title));
  svg.metadata(notes);
  svg.rectangle({0, 0, figure.width_px, figure.height_px}, {255, 255, 255});
  svg.text({style::k_outer, layout.title_baseline}, layout.title,
           {.size = style::k_figure_title, .weight = Weight::bold});
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    draw_panel(svg, figure.panels[i], layout.panels[i]);
  }
  return svg.finish();
}

std::string svg_of_series(const Figure& figure) {
  const FigureLayout layout = layout_of(figure);
  SvgWriter svg(figure.width_px, figure.height_px, printable(figure.title));
  for (std::size_t i = 0; i < figure.panels.size(); ++i)
    draw_series(svg, figure.panels[i], layout.panels[i]);
  return svg.finish();
}

}  // namespace sleight::plot
