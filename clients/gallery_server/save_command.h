// `sleight gallery --save`: archives as a folder of static files (saved_gallery.h).
#pragma once

#include "clients/cli/diagnosis.h"
#include "clients/gallery_server/gallery_command.h"

namespace sleight::gallery {

/// Tells stderr how it goes, and of each archive that can't be read that it is left out. Throws
/// base::Error: of the first one where none is left, and as save_gallery. REQUIRES: a folder to
/// save in.
int save_archives(const CommandOptions& options, const cli::Rules& rules);

}  // namespace sleight::gallery
