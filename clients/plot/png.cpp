#include "clients/plot/png.h"

#include "clients/plot/raster.h"
#include "clients/plot/svg.h"
#include "common/base/check.h"

namespace sleight::plot {

base::Bytes svg_to_png(std::string_view svg, double scale) {
  CHECK_GT(scale, 0.0);
  const SvgDocument document(svg);
  const PixelSize size = pixel_size(document.width_px(), document.height_px(), scale);
  const Surface surface = white_surface(size.columns, size.rows);
  document.draw(surface.get(), scale);
  return png_of(surface.get());
}

base::Bytes to_png(const Figure& figure, double scale) {
  return svg_to_png(to_svg(figure), scale);
}

}  // namespace sleight::plot
