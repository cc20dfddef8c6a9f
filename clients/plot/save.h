// Saves figures as files.
#pragma once

#include <string>

#include "clients/plot/figure.h"
#include "clients/plot/notes.h"

namespace sleight::plot {

struct SaveOptions {
  Notes notes = {};  ///< REQUIRES an SVG unless empty
};

/// Writes an SVG or a PNG, depending on the path's extension (".svg", ".png", in any case). The
/// file is written under a temporary name and renamed, so a viewer never sees half a picture.
/// Throws base::Error: usage for another extension or for notes in a PNG, environment on a write
/// error.
void save(const Figure& figure, const std::string& path, const SaveOptions& options = {});

}  // namespace sleight::plot
