// A grid of small dots made of characters: braille patterns (2 x 4 dots per character), or in ASCII
// the four characters " ", "'", "." and ":" (1 x 2 dots). Dots are about square, because a
// terminal's characters are twice as high as wide.
//
// Dots are numbered from the upper left corner. Content outside is clipped. Not thread-safe.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "clients/plot/figure.h"

namespace sleight::plot {

struct Glyph {
  std::string text;
  Color color = palette::k_ink;
};

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

}  // namespace sleight::plot
