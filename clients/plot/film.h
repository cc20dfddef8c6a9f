// Renders a film's frames: the still parts once, and the moving parts on top in each frame. So a
// frame's cost depends only on its moving parts. Not thread-safe. Example:
//
//   Film film(still);                  // looks like a PNG of the figure
//   film.show(moving);                 // its series on top, at the same places
//   write(film.png());                 // or film.pixels(), for a video encoder
#pragma once

#include <cstdint>
#include <memory>

#include "clients/plot/figure.h"
#include "common/base/bytes.h"

namespace sleight::plot {

class Film {
 public:
  /// `scale`: image pixels per figure pixel. Both sides of a frame are even, as video encoders
  /// require; a white row or column is added if necessary. Throws base::Error if the figure can't
  /// be drawn or is larger than a PNG may be. REQUIRES scale > 0.
  explicit Film(const Figure& still, double scale = 1);
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;
  ~Film();

  std::uint32_t columns() const;
  std::uint32_t rows() const;

  /// Draws the series of a figure without background, titles or axes. REQUIRES the still figure's
  /// size, number of panels, ranges and titles, because positions depend on them.
  void show(const Figure& moving);

  /// Returns the last shown frame, or the still figure.
  base::Bytes png() const;
  /// Returns the frame of png() row by row from the top, each pixel as blue, green, red and an
  /// unused byte. Valid until the next show().
  base::BytesView pixels() const;

 private:
  struct Surfaces;
  std::unique_ptr<Surfaces> surfaces_;
};

}  // namespace sleight::plot
