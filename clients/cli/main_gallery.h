// Adds `sleight gallery` to the command line.
#pragma once

#include <CLI/CLI.hpp>

#include "clients/cli/gallery_command.h"
#include "clients/cli/main_app.h"

namespace sleight::programs {

/// `rules` judge chains. REQUIRES: `options` and `action` must outlive the app.
void add_gallery_command(CLI::App& app, cli::CommandOptions& options, const analysis::Rules& rules,
                         Action& action);

}  // namespace sleight::programs
