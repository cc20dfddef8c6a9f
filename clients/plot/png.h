// SVG and figures as PNG images, by librsvg and cairo.
#pragma once

#include <string_view>

#include "clients/plot/figure.h"
#include "common/base/bytes.h"

namespace sleight::plot {

/// A picture larger than this on a side is refused rather than allocated.
inline constexpr double k_png_side_max_px = 16384;

/// The document drawn with `scale` image pixels per SVG pixel. Throws base::Error when it can't be
/// parsed or drawn, or is too large. REQUIRES scale > 0.
base::Bytes svg_to_png(std::string_view svg, double scale);

/// Two image pixels per SVG pixel look sharp on today's screens and in print.
base::Bytes to_png(const Figure& figure, double scale = 2);

}  // namespace sleight::plot
