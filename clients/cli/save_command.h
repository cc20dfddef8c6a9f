// `sleight gallery --save`: archives as a folder of static files (saved_gallery.h).
#pragma once

#include <functional>
#include <string>

#include "clients/analysis/diagnosis.h"
#include "clients/cli/gallery_command.h"

namespace sleight::cli {

/// Tells stderr how it goes, and of each archive that can't be read that it is left out. Of a job
/// the archive is saved, or what it has committed so far. `service_called`: the service's place.
/// Throws base::Error: of the first one where none is left, and as save_gallery. REQUIRES: a folder
/// to save in; no other thread runs.
int save_archives(const CommandOptions& options, const std::function<std::string()>& service_called,
                  const analysis::Rules& rules);

}  // namespace sleight::cli
