// Converts SVG and figures to PNG images, by librsvg and cairo.
#pragma once

#include <string_view>

#include "clients/plot/figure.h"
#include "common/base/bytes.h"

namespace sleight::plot {

/// Maximum side of a picture; larger pictures are refused.
inline constexpr double k_png_side_max_px = 16384;

/// Draws the document with `scale` image pixels per SVG pixel. Throws base::Error if the document
/// can't be parsed or drawn, or if the image would be too large. REQUIRES scale > 0.
base::Bytes svg_to_png(std::string_view svg, double scale);

/// The default scale of 2 looks sharp on screens and in print.
base::Bytes to_png(const Figure& figure, double scale = 2);

}  // namespace sleight::plot
