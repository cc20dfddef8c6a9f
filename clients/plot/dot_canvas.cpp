#include "clients/plot/dot_canvas.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/base/check.h"

namespace sleight::plot {

namespace {

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

}  // namespace

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

}  // namespace sleight::plot
