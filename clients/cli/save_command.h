// `sleight gallery --save`: saves archives as a folder of static files (saved_gallery.h).
#pragma once

#include <functional>
#include <string>

#include "clients/analysis/diagnosis.h"
#include "clients/cli/gallery_command.h"

namespace sleight::cli {

/// Saves archives, or the current archives of jobs. Prints progress and unreadable archives to
/// stderr. `service_called` returns the service's address. If no archive can be read, throws the
/// base::Error of the first archive. Also throws errors of save_gallery(). REQUIRES: options.save
/// is set; no other thread runs.
int save_archives(const CommandOptions& options, const std::function<std::string()>& service_called,
                  const analysis::Rules& rules);

}  // namespace sleight::cli
