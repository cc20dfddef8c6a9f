// A figure as an SVG document.
//
// Light background, dark ink, DejaVu Sans; words stay words (searchable, selectable). Long series
// are thinned to the pixels (decimate.h), so a million points make a file of some 40 kB. The same
// figure with the same notes gives the same bytes. Pure.
#pragma once

#include <string>

#include "clients/plot/figure.h"
#include "clients/plot/notes.h"

namespace sleight::plot {

/// Notes stand in a <metadata> element; without notes there is none. REQUIRES what figure.h
/// requires of its fields.
std::string to_svg(const Figure& figure, const Notes& notes = {});

/// Its panels' series alone, where the whole figure has them, on nothing: to be drawn upon another
/// picture of the same sizes (film.h). Bands are left out.
std::string svg_of_series(const Figure& figure);

}  // namespace sleight::plot
