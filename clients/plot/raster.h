// Pixels of SVG documents, by librsvg and cairo. Private to clients/plot.
#pragma once

#include <cairo.h>

#include <memory>
#include <string_view>

#include "common/base/bytes.h"

namespace sleight::plot {

struct ReleaseSurface {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};
/// Of 32 bits a pixel, of which cairo leaves the first 8 unused.
using Surface = std::unique_ptr<cairo_surface_t, ReleaseSurface>;

/// Throws base::Error with cairo's reason, unless it is none.
void check_cairo(cairo_status_t status);

/// A white one. Throws base::Error when it can't be made. REQUIRES sides from 1 to
/// k_png_side_max_px.
Surface white_surface(int columns, int rows);

/// A parsed document.
class SvgDocument {
 public:
  /// Throws base::Error when it can't be parsed or gives no size in pixels.
  explicit SvgDocument(std::string_view svg);
  SvgDocument(const SvgDocument&) = delete;
  SvgDocument& operator=(const SvgDocument&) = delete;
  ~SvgDocument();

  double width_px() const { return width_px_; }
  double height_px() const { return height_px_; }
  /// Upon what is there, from its upper left corner on, with `scale` pixels to one of its own.
  /// Throws base::Error when it can't be drawn.
  void draw(cairo_surface_t* surface, double scale) const;

 private:
  void* handle_;  ///< librsvg's
  double width_px_ = 0;
  double height_px_ = 0;
};

/// A side in pixels at a scale. Throws base::Error unless it is from 1 to k_png_side_max_px.
struct PixelSize {
  int columns = 0;
  int rows = 0;
};
PixelSize pixel_size(double width_px, double height_px, double scale);

/// Small. Throws base::Error when it can't be encoded.
base::Bytes png_of(cairo_surface_t* surface);
/// The same pixels in a third of the time, a fourth larger. REQUIRES: a surface of white_surface.
base::Bytes quick_png_of(cairo_surface_t* surface);

}  // namespace sleight::plot
