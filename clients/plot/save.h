// Figures as files.
#pragma once

#include <string>

#include "clients/plot/figure.h"

namespace sleight::plot {

/// Writes an SVG or a PNG, as the path's ending says (".svg", ".png", of any case); `png_scale` is
/// image pixels per SVG pixel. Written beside its place and renamed: a viewer never sees half a
/// picture. Throws base::Error: usage for another ending, environment when it can't be written.
void save(const Figure& figure, const std::string& path, double png_scale = 2);

}  // namespace sleight::plot
