#include "clients/plot/svg_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/base/check.h"

namespace sleight::plot {

namespace {

// Larger coordinates are outside any page. Renderers use 32-bit fixed point.
constexpr double k_pixel_far = 1e5;

std::string number(double value) {
  std::string text = fmt::format("{:.2f}", std::clamp(value, -k_pixel_far, k_pixel_far));
  while (text.back() == '0')
    text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string hex(Color color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color.red, color.green, color.blue);
}

std::string fill_of(Color color) {
  std::string out = fmt::format("fill=\"{}\"", hex(color));
  if (color.opacity < 1) out += fmt::format(" fill-opacity=\"{}\"", number(color.opacity));
  return out;
}

std::string stroke_of(Stroke stroke) {
  std::string out = fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"",
                                hex(stroke.color), number(stroke.width));
  if (stroke.color.opacity < 1) {
    out += fmt::format(" stroke-opacity=\"{}\"", number(stroke.color.opacity));
  }
  if (stroke.dashed) out += " stroke-dasharray=\"6 4\"";
  return out;
}

std::string joined(std::span<const Point> points) {
  std::string out;
  for (const Point point : points) {
    if (!out.empty()) out += ' ';
    out += number(point.x) + ',' + number(point.y);
  }
  return out;
}

}  // namespace

SvgWriter::SvgWriter(double width_px, double height_px, std::string_view title) {
  out_ = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" role=\"img\" font-family=\"DejaVu Sans, Verdana, sans-serif\">\n"
      "<title>{2}</title>\n",
      number(width_px), number(height_px), xml_escaped(title));
}

void SvgWriter::metadata(const Notes& notes) {
  if (notes.empty()) return;
  out_ += "<metadata>\n";
  for (const Note& note : notes)
    out_ += fmt::format("{}: {}\n", note.name, xml_escaped(printable(note.value)));
  out_ += "</metadata>\n";
}

void SvgWriter::begin_clipped(Box box) {
  const std::size_t id = clips_++;
  out_ += fmt::format(
      "<clipPath id=\"c{}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n"
      "<g clip-path=\"url(#c{})\">\n",
      id, number(box.left), number(box.top), number(box.width), number(box.height), id);
  ++open_groups_;
}

void SvgWriter::end_group() {
  CHECK_GT(open_groups_, std::size_t{0});
  --open_groups_;
  out_ += "</g>\n";
}

void SvgWriter::rectangle(Box box, Color fill) {
  out_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" {}/>\n", number(box.left),
                      number(box.top), number(box.width), number(box.height), fill_of(fill));
}

void SvgWriter::rectangle_outline(Box box, Stroke stroke) {
  out_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" {}/>\n", number(box.left),
                      number(box.top), number(box.width), number(box.height), stroke_of(stroke));
}

void SvgWriter::segment(Point from, Point to, Stroke stroke) {
  out_ += fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" {}/>\n", number(from.x),
                      number(from.y), number(to.x), number(to.y), stroke_of(stroke));
}

void SvgWriter::polyline(std::span<const Point> points, Stroke stroke) {
  if (points.size() < 2) return;
  out_ += fmt::format("<polyline points=\"{}\" {} stroke-linejoin=\"round\"/>\n", joined(points),
                      stroke_of(stroke));
}

void SvgWriter::polygon(std::span<const Point> points, Color fill) {
  out_ += fmt::format("<polygon points=\"{}\" {}/>\n", joined(points), fill_of(fill));
}

void SvgWriter::disc(Point center, double radius, Color fill) {
  out_ += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {}/>\n", number(center.x),
                      number(center.y), number(radius), fill_of(fill));
}

void SvgWriter::dots(std::span<const Point> centers, double radius, Color fill) {
  if (centers.empty()) return;
  // A line of length 0 with round ends is a dot.
  out_ += "<path d=\"";
  for (const Point center : centers)
    out_ += fmt::format("M{} {}h0", number(center.x), number(center.y));
  out_ += fmt::format("\" {} stroke-linecap=\"round\"/>\n",
                      stroke_of({.color = fill, .width = 2 * radius}));
}

void SvgWriter::ellipse(Point center, double radius_x, double radius_y, Color fill) {
  out_ += fmt::format("<ellipse cx=\"{}\" cy=\"{}\" rx=\"{}\" ry=\"{}\" {}/>\n", number(center.x),
                      number(center.y), number(radius_x), number(radius_y), fill_of(fill));
}

void SvgWriter::ellipse_outline(Point center, double radius_x, double radius_y, Stroke stroke) {
  out_ += fmt::format("<ellipse cx=\"{}\" cy=\"{}\" rx=\"{}\" ry=\"{}\" {}/>\n", number(center.x),
                      number(center.y), number(radius_x), number(radius_y), stroke_of(stroke));
}

void SvgWriter::text(Point at, std::string_view words, const TextStyle& text_style) {
  if (words.empty()) return;
  static constexpr const char* k_anchor[] = {"start", "middle", "end"};
  out_ += fmt::format("<text x=\"{}\" y=\"{}\" font-size=\"{}\" {}", number(at.x), number(at.y),
                      number(text_style.size), fill_of(text_style.color));
  if (text_style.anchor != Anchor::start) {
    out_ += fmt::format(" text-anchor=\"{}\"", k_anchor[static_cast<int>(text_style.anchor)]);
  }
  if (text_style.weight == Weight::bold) out_ += " font-weight=\"bold\"";
  if (text_style.halo) {
    out_ +=
        " stroke=\"#ffffff\" stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\"";
  }
  if (text_style.upwards) {
    out_ += fmt::format(" transform=\"rotate(-90 {} {})\"", number(at.x), number(at.y));
  }
  out_ += fmt::format(">{}</text>\n", xml_escaped(words));
}

std::string SvgWriter::finish() {
  CHECK_EQ(open_groups_, std::size_t{0});
  out_ += "</svg>\n";
  return std::move(out_);
}

}  // namespace sleight::plot
