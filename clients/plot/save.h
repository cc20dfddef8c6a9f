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
/// Throws base::Error(usage) for any other extension and for notes in a PNG, and
/// base::Error(environment) if the file can't be written.
void save(const Figure& figure, const std::string& path, const SaveOptions& options = {});

}  // namespace sleight::plot
