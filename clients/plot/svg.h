// A figure as an SVG document.
//
// Light background, dark ink, DejaVu Sans; words stay words (searchable, selectable). Long series
// are thinned to the pixels (decimate.h), so a million points make a file of some 40 kB. The same
// figure gives the same bytes. Pure.
#pragma once

#include <string>

#include "clients/plot/figure.h"

namespace sleight::plot {

/// REQUIRES what figure.h requires of its fields.
std::string to_svg(const Figure& figure);

}  // namespace sleight::plot
