// Draws SVG documents to pixels, by librsvg and cairo. Private to clients/plot.
#pragma once

#include <cairo.h>

#include <memory>
#include <string_view>

#include "common/base/bytes.h"

namespace sleight::plot {

struct ReleaseSurface {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};
/// 32 bits per pixel, of which cairo leaves the first 8 unused.
using Surface = std::unique_ptr<cairo_surface_t, ReleaseSurface>;

/// Throws base::Error with cairo's reason unless the status is success.
void check_cairo(cairo_status_t status);

/// Returns a white surface. Throws base::Error if the surface can't be created. REQUIRES sides from
/// 1 to k_png_side_max_px.
Surface white_surface(int columns, int rows);

class SvgDocument {
 public:
  /// Throws base::Error if the text can't be parsed or has no size in pixels.
  explicit SvgDocument(std::string_view svg);
  SvgDocument(const SvgDocument&) = delete;
  SvgDocument& operator=(const SvgDocument&) = delete;
  ~SvgDocument();

  double width_px() const { return width_px_; }
  double height_px() const { return height_px_; }
  /// Draws over the surface from its upper left corner, with `scale` pixels per SVG pixel. Throws
  /// base::Error on failure.
  void draw(cairo_surface_t* surface, double scale) const;

 private:
  void* handle_;  ///< owned by librsvg
  double width_px_ = 0;
  double height_px_ = 0;
};

/// Pixels of a picture at a scale. pixel_size throws base::Error unless each side is from 1 to
/// k_png_side_max_px.
struct PixelSize {
  int columns = 0;
  int rows = 0;
};
PixelSize pixel_size(double width_px, double height_px, double scale);

/// Encodes a small PNG. Throws base::Error on failure.
base::Bytes png_of(cairo_surface_t* surface);
/// Encodes a PNG in a third of png_of's time, with a quarter more bytes. REQUIRES: a surface of
/// white_surface.
base::Bytes quick_png_of(cairo_surface_t* surface);

}  // namespace sleight::plot
