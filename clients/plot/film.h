// Frames of a film: what stands still is drawn once, what moves upon it in each frame.
//
//   Film film(still);                  // as a PNG of it looks
//   film.show(moving);                 // its series upon that, in the same places
//   write(film.png());                 // or film.pixels(), for a video's encoder
//
// So a frame costs what moves, not the scenery. Not thread-safe.
#pragma once

#include <cstdint>
#include <memory>

#include "clients/plot/figure.h"
#include "common/base/bytes.h"

namespace sleight::plot {

class Film {
 public:
  /// `scale` image pixels to one of the figure's. Both sides of a frame are even, as encoders of
  /// videos ask: else a white row or column is added. Throws base::Error when it can't be drawn or
  /// is larger than a PNG may be. REQUIRES scale > 0.
  explicit Film(const Figure& still, double scale = 1);
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;
  ~Film();

  std::uint32_t columns() const;
  std::uint32_t rows() const;

  /// Draws the series of a figure: no background, no titles, no axes. REQUIRES: of the same sizes,
  /// with as many panels of the same ranges and titles, or they stand elsewhere.
  void show(const Figure& moving);

  /// The frame shown last, else the still figure.
  base::Bytes png() const;
  /// Likewise: row by row from above, each pixel as its blue, green, red and an unused byte. Valid
  /// until the next call of show.
  base::BytesView pixels() const;

 private:
  struct Surfaces;
  std::unique_ptr<Surfaces> surfaces_;
};

}  // namespace sleight::plot
