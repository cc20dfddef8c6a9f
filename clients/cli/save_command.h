// `sleight gallery --save`: saves archives as a folder of static files (saved_gallery.h).
#pragma once

#include <functional>
#include <string>

#include "clients/analysis/diagnosis.h"
#include "clients/cli/gallery_command.h"

namespace sleight::cli {

/// Saves archives, or jobs' archives so far. Prints progress to stderr, and which archives can't be
/// read. `service_called` returns the service's address. Throws the first archive's base::Error if
/// none can be read, and errors of save_gallery. REQUIRES: options.save is set; no other thread
/// runs.
int save_archives(const CommandOptions& options, const std::function<std::string()>& service_called,
                  const analysis::Rules& rules);

}  // namespace sleight::cli
