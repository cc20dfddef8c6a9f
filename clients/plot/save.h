// Figures as files.
#pragma once

#include <string>

#include "clients/plot/figure.h"
#include "clients/plot/notes.h"

namespace sleight::plot {

struct SaveOptions {
  Notes notes = {};  ///< REQUIRES an SVG, if there are any
};

/// Writes an SVG or a PNG, as the path's ending says (".svg", ".png", of any case). Written beside
/// its place and renamed: a viewer never sees half a picture. Throws base::Error: usage for another
/// ending or notes in a PNG, environment when it can't be written.
void save(const Figure& figure, const std::string& path, const SaveOptions& options = {});

}  // namespace sleight::plot
