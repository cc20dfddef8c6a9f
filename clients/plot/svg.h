// Writes a figure as an SVG document.
//
// The style has a light background, dark ink and DejaVu Sans. Text stays searchable and selectable.
// Long series are thinned to the pixels (decimate.h), so a million points become a file of about 40
// kB. The same figure with the same notes has the same bytes. Pure.
#pragma once

#include <string>

#include "clients/plot/figure.h"
#include "clients/plot/notes.h"

namespace sleight::plot {

/// Writes notes to a <metadata> element. REQUIRES: the figure's fields meet the requirements of
/// figure.h.
std::string to_svg(const Figure& figure, const Notes& notes = {});

/// Writes only the panels' series, at their usual places on a transparent background, to be drawn
/// over another picture of the same size (film.h). Omits bands.
std::string svg_of_series(const Figure& figure);

}  // namespace sleight::plot
